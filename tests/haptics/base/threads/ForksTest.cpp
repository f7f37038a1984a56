#include "haptics/base/threads/Forks.h"

#include "haptics/base/threads/LatestWorker.h"
#include "tests/Forked.h"

#include <memory>

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

struct ForksAnswer
{
    std::uint64_t frame = 0;
};

/// Counts how many there are.
struct ForksCounted
{
    explicit ForksCounted(int* itsCount, bool isFirst) : count(itsCount), first(isFirst)
    {
        ++*count;
    }
    ~ForksCounted() { --*count; }
    ForksCounted(const ForksCounted&) = delete;
    ForksCounted& operator=(const ForksCounted&) = delete;
    int* count;
    bool first;
};

} // namespace

TEST(Forks, AChildCountsOneMoreThanItsParent)
{
    const std::uint64_t before = forks();
    const MadeHere isOurs;
    EXPECT_TRUE(isOurs);
    EXPECT_EQ(inChild([&] { return forks() == before + 1 && !isOurs && MadeHere() ? 0 : 1; }), 0);
    EXPECT_EQ(forks(), before);
    EXPECT_TRUE(isOurs);
}

TEST(Forks, WhatIsTheParentsIsNeitherUsedNorDestroyed)
{
    int count = 0;
    auto one = std::make_unique<OfProcess<ForksCounted>>(
        [&](bool isFirst) { return std::make_unique<ForksCounted>(&count, isFirst); });
    EXPECT_TRUE((*one)->first);
    const auto work = [&]
    {
        if ((*one)->first || count != 2) return 1;
        one.reset();
        return count == 1 ? 0 : 2; // that of the parent
    };
    EXPECT_EQ(inChild(work), 0);
    EXPECT_EQ(inChild(
                  [&]
                  {
                      one.reset();
                      return count == 1 ? 0 : 1;
                  }),
              0);
    EXPECT_TRUE((*one)->first);
    one.reset();
    EXPECT_EQ(count, 0);
}

TEST(Forks, AWorkerOfTheParentsKeepsNoChildWaiting)
{
    auto worker = std::make_unique<LatestWorker<ForksAnswer, ForksAnswer>>(
        [](const ForksAnswer& asked) { return std::make_unique<ForksAnswer>(asked); });
    worker->submit({7});
    ASSERT_TRUE(worker->waitFor(7, 60.0));
    EXPECT_EQ(inChild(
                  [&]
                  {
                      worker->submit({8});
                      if (worker->waitFor(8, 1e6) || worker->take()) return 1;
                      worker.reset();
                      return 0;
                  }),
              0);
    worker->submit({8});
    EXPECT_TRUE(worker->waitFor(8, 60.0));
}
