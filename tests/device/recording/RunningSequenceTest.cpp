#include "device/recording/RecordingDevice.h"
#include "tests/device/Fields.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::device;
using recording::RunningSequence;

namespace
{

DriveSequence sequenceOf(int fields, double rate_Hz)
{
    DriveSequence sequence;
    sequence.rate_Hz = rate_Hz;
    for (int k = 0; k < fields; ++k)
        sequence.signals.push_back(evenField(4, static_cast<std::uint8_t>(k), 200));
    return sequence;
}

} // namespace

TEST(RunningSequence, begins_each_step_at_its_time_to_the_nanosecond)
{
    for (const double rate_Hz : {0.01, 1.0, 3.0, 999.9, 1000.0, 7000.0, 40e3})
    {
        const RunningSequence running(sequenceOf(3, rate_Hz), 123);
        for (const std::uint64_t step : {0ULL, 1ULL, 2ULL, 1000ULL, 1234567ULL})
        {
            const std::uint64_t time_ns = running.time_ns(step);
            const long double exact_ns = 123 + static_cast<long double>(step) * 1e9L / rate_Hz;
            // Half a nanosecond, and what a double holds of days.
            EXPECT_LE(std::abs(static_cast<long double>(time_ns) - exact_ns),
                      0.5L + exact_ns * 4e-16L);
            EXPECT_EQ(running.begun(time_ns), step + 1);
            EXPECT_EQ(running.begun(running.time_ns(step + 1) - 1), step + 1);
            EXPECT_EQ(running.signal(step).phase[0], step % 3);
        }
    }
}

TEST(RunningSequence, leaves_out_what_is_too_late_to_catch_up_with)
{
    RunningSequence running(sequenceOf(4, 1000), 0);
    EXPECT_EQ(running.leaveOutLate(2'000'000'000), 0U); // 2001 steps have begun
    EXPECT_EQ(running.step(), 0U);
    EXPECT_EQ(running.leaveOutLate(5'000'000'000), 3000U);
    EXPECT_EQ(running.step(), 3000U);
    EXPECT_EQ(running.leaveOutLate(5'000'000'000), 0U);
}

TEST(DriveSequence, is_whole_with_signals_of_one_length_and_a_rate)
{
    EXPECT_TRUE(sequenceOf(1, 1000).fits(4));
    EXPECT_TRUE(sequenceOf(3, DriveSequence::kMostRate_Hz).fits(4));
    EXPECT_FALSE(sequenceOf(3, 1000).fits(5));
    EXPECT_FALSE(sequenceOf(0, 1000).fits(4));
    for (const double rate_Hz : {0.0, -1.0, 40001.0, std::nan(""), HUGE_VAL})
        EXPECT_FALSE(sequenceOf(3, rate_Hz).fits(4)) << rate_Hz;
    DriveSequence uneven = sequenceOf(3, 1000);
    uneven.signals[1].duty.pop_back();
    EXPECT_FALSE(uneven.fits(4));
}
