#include "haptics/base/threads/ThreadPool.h"

#include <atomic>
#include <ctime>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::base;

TEST(ThreadPool, EveryThreadDoesItsPartEachTime)
{
    for (const int threads : {1, 2, midair::base::coreCount(), 4 * midair::base::coreCount() + 3})
    {
        midair::base::ThreadPool pool(threads);
        ASSERT_EQ(pool.threads(), threads);
        std::vector<int> done(static_cast<std::size_t>(threads), 0);
        for (int run = 0; run < 500; ++run)
            pool.run([&](int thread) { ++done[static_cast<std::size_t>(thread)]; });
        for (const int count : done)
            EXPECT_EQ(count, 500);
    }
}

#ifdef __linux__
// They used to look out for work in turns of 20 to 50 microseconds each before every sleep, and the
// caller all the time.
TEST(ThreadPool, MoreThreadsThanCoresDoNotSpin)
{
    const auto spent_s = []
    {
        timespec time{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    midair::base::ThreadPool pool(2 * midair::base::coreCount() + 1);
    const double before_s = spent_s();
    // The last one sleeps, as a thread without a core does; the caller is to sleep too.
    for (int run = 0; run < 10; ++run)
        pool.run(
            [&](int thread)
            {
                if (thread + 1 < pool.threads()) return;
                timespec time{0, 50000000};
                nanosleep(&time, nullptr);
            });
    EXPECT_LT(spent_s() - before_s, 0.25) << "of 0.5 s that passed";
}
#endif
