#include "haptics/base/threads/LatestSlot.h"

#include <algorithm>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

using midair::base::LatestSlot;

namespace
{

constexpr double kLong_s = 60.0;

template<typename T>
bool takes(midair::base::LatestSlot<T>& slot, T& value)
{
    return slot.take(value, kLong_s) == midair::base::LatestSlot<T>::Taken::VALUE;
}

} // namespace

TEST(LatestSlot, TheNewestWinsAndTheOthersAreCounted)
{
    midair::base::LatestSlot<int> slot;
    for (int i = 1; i <= 5; ++i)
    {
        int value = i;
        EXPECT_TRUE(slot.put(value));
    }
    int taken = 0;
    ASSERT_TRUE(takes(slot, taken));
    EXPECT_EQ(taken, 5);
    EXPECT_EQ(slot.puts(), 5u);
    EXPECT_EQ(slot.drops(), 4u);
}

TEST(LatestSlot, ClosedGivesNothingMore)
{
    midair::base::LatestSlot<int> slot;
    int value = 1;
    slot.put(value);
    slot.close();
    int taken = 7;
    EXPECT_FALSE(takes(slot, taken));
    EXPECT_EQ(taken, 7);
    value = 2;
    EXPECT_FALSE(slot.put(value));
    EXPECT_EQ(value, 2);
}

TEST(LatestSlot, NothingIsTakenWhereNothingCame)
{
    midair::base::LatestSlot<int> slot;
    int value = 7;
    EXPECT_EQ(slot.take(value, 0.001), midair::base::LatestSlot<int>::Taken::NOTHING);
    EXPECT_EQ(value, 7);
}

TEST(LatestSlot, CloseWakesAConsumerThatWaits)
{
    midair::base::LatestSlot<int> slot;
    bool taken = true;
    std::thread consumer(
        [&]
        {
            int value = 0;
            taken = takes(slot, value);
        });
    slot.close();
    consumer.join();
    EXPECT_FALSE(taken);
}

TEST(LatestSlot, MemoryGoesRound)
{
    // Three buffers circulate between producer, slot and consumer: after they have grown once no
    // pointer is new.
    midair::base::LatestSlot<std::vector<int>> slot;
    std::vector<int> mine;
    std::vector<int> theirs;
    std::vector<const int*> seen;
    for (int i = 0; i < 12; ++i)
    {
        mine.assign(1000, i);
        if (std::find(seen.begin(), seen.end(), mine.data()) == seen.end())
            seen.push_back(mine.data());
        slot.put(mine);
        if (i % 3 != 0)
        {
            takes(slot, theirs);
            EXPECT_EQ(theirs.front(), i);
        }
    }
    EXPECT_LE(seen.size(), 3u);
}

TEST(LatestSlot, BetweenTwoThreadsValuesComeInOrderAndNoneIsCountedTwice)
{
    midair::base::LatestSlot<int> slot;
    constexpr int kLast = 20000;
    std::vector<int> taken;
    std::thread consumer(
        [&]
        {
            int value = 0;
            while (takes(slot, value))
            {
                taken.push_back(value);
                if (value == kLast) return;
            }
        });
    for (int i = 1; i <= kLast; ++i)
    {
        int value = i;
        slot.put(value);
    }
    consumer.join();
    ASSERT_FALSE(taken.empty());
    EXPECT_EQ(taken.back(), kLast);
    for (std::size_t i = 1; i < taken.size(); ++i)
        EXPECT_LT(taken[i - 1], taken[i]);
    EXPECT_EQ(taken.size() + slot.drops(), static_cast<std::size_t>(kLast));
}
