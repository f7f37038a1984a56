#include "haptics/base/threads/ThreadPool.h"

#include "tests/Eventually.h"

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

// Each piece is done once, by whoever takes it; runs of both kinds follow each other at all
// distances in time.
TEST(ThreadPool, WorkIsTakenOnceByThoseWhoAreAwake)
{
    constexpr int kPieces = 40;
    for (const int threads : {1, 2, 4 * midair::base::coreCount() + 3})
    {
        ThreadPool pool(threads);
        std::vector<std::atomic<int>> taken(kPieces);
        std::vector<int> done(static_cast<std::size_t>(threads), 0);
        for (int round = 0; round < 400; ++round)
        {
            if (round % 80 == 0) letPass(2e-3);
            for (std::atomic<int>& piece : taken)
                piece = 0;
            std::vector<int> sums(static_cast<std::size_t>(threads), 0);
            pool.runHelped(
                [&](int thread)
                {
                    for (int k = 0; k < kPieces; ++k)
                        if (taken[static_cast<std::size_t>(k)].fetch_add(1) == 0)
                            sums[static_cast<std::size_t>(thread)] += k + 1;
                });
            int sum = 0;
            for (const int part : sums)
                sum += part;
            ASSERT_EQ(sum, kPieces * (kPieces + 1) / 2) << round;
            if (round % 3 == 0)
                pool.run([&](int thread) { ++done[static_cast<std::size_t>(thread)]; });
        }
        for (const int count : done)
            EXPECT_EQ(count, 134);
    }
}

TEST(ThreadPool, WakingDoesNoWork)
{
    for (const int threads : {1, 2})
    {
        ThreadPool pool(threads);
        std::atomic<int> done{0};
        for (int round = 0; round < 200; ++round)
        {
            // Between spinning and sleeping: woken twice, or not at all.
            if (round % 50 == 0) letPass(2e-3);
            for (int k = 0; k < round % 3; ++k)
                pool.wake();
            pool.run([&](int) { ++done; });
        }
        pool.wake(); // and its end follows
        EXPECT_EQ(done, 200 * threads);
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
