#include "haptics/base/AlignedBuffer.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;

namespace
{

// Around the limits between parts, shared pages and whole ones.
constexpr std::size_t kSizes[] = {1,
                                  64,
                                  4095,
                                  4096,
                                  4097,
                                  100000,
                                  (1U << 20) - 1,
                                  1U << 20,
                                  (1U << 20) + 1,
                                  2U << 20,
                                  (2U << 20) + 1,
                                  9U << 20};

} // namespace

TEST(LargeMemory, ArraysDontOverlapAndAreAligned)
{
    for (int round = 0; round < 3; ++round)
    {
        std::vector<std::pair<unsigned char*, std::size_t>> all;
        for (int k = 0; k < 4; ++k)
            for (const std::size_t bytes : kSizes)
            {
                all.emplace_back(static_cast<unsigned char*>(base::takeMemory(bytes)), bytes);
                EXPECT_EQ(reinterpret_cast<std::uintptr_t>(all.back().first) % 64, 0U) << bytes;
                std::memset(all.back().first, static_cast<int>(all.size()), bytes);
            }
        int mark = 0;
        for (const auto& [memory, bytes] : all)
        {
            ++mark;
            for (std::size_t i = 0; i < bytes; ++i)
                ASSERT_EQ(memory[i], mark) << bytes << ' ' << i;
        }
        for (const auto& [memory, bytes] : all)
            base::giveMemory(memory, bytes);
    }
}

TEST(LargeMemory, ThreadsShareIt)
{
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 4; ++thread)
        threads.emplace_back(
            [thread]
            {
                for (int k = 0; k < 200; ++k)
                {
                    const std::size_t bytes = kSizes[(k + thread) % 10];
                    auto* memory = static_cast<unsigned char*>(base::takeMemory(bytes));
                    std::memset(memory, thread, bytes);
                    ASSERT_EQ(memory[bytes / 2], thread);
                    base::giveMemory(memory, bytes);
                }
            });
    for (std::thread& thread : threads)
        thread.join();
}

TEST(AlignedBuffer, IsZeroWhereItSaysSo)
{
    for (int round = 0; round < 3; ++round)
    {
        base::AlignedBuffer<float> unset, zero;
        unset.reserveUnset(300000);
        std::fill_n(unset.data(), 300000, 7.0F);
        {
            base::AlignedBuffer<float> moved = std::move(unset);
            EXPECT_EQ(moved[299999], 7.0F);
        }
        zero.reserve(300000); // most likely the same memory
        for (std::size_t i = 0; i < 300000; ++i)
            ASSERT_EQ(zero[i], 0.0F);
    }
    base::AlignedBuffer<double> most;
    EXPECT_THROW(most.reserve(static_cast<std::size_t>(-1) / 4), std::bad_alloc);
}
