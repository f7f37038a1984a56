#include "device/autd3/protocol/Commands.h"
#include "device/drive/DriveEncoder.h"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

using namespace midair::device;
using namespace midair::device::autd3;

namespace
{

constexpr double kPi = 3.14159265358979323846;

// What a unit plays of a phase, which is a delay, and an intensity, which is a place in the table.
std::complex<double> playedByUnit(int phase, int intensity)
{
    const double width = dutyWidths()[static_cast<std::size_t>(intensity)] / 512.0;
    return std::polar(std::sin(kPi * width), -2 * kPi * phase / 256);
}

DriveSignal everyLevel(int transducers)
{
    DriveSignal signal = silentSignal(transducers);
    for (int i = 0; i < transducers; ++i)
    {
        signal.phase[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(7 * i);
        signal.duty[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i);
    }
    return signal;
}

} // namespace

// Widths are in 1/512 where duty levels are in 1/510 of the period: off by 1/1024 at most.
TEST(Autd3Levels, a_unit_plays_what_a_drive_means)
{
    const DriveSignal signal = everyLevel(2 * kTransducersPerUnit);
    std::vector<std::complex<float>> wanted;
    decode(signal, wanted);
    for (const int first : {0, kTransducersPerUnit})
    {
        UnitPattern pattern;
        toUnit(signal, first, pattern);
        for (std::size_t k = 0; k < pattern.phase.size(); ++k)
        {
            const auto q = playedByUnit(pattern.phase[k], pattern.intensity[k]);
            const std::complex<double> want = wanted[static_cast<std::size_t>(first) + k];
            EXPECT_NEAR(std::abs(q - want), 0, kPi / 1024 + 1e-6) << first + static_cast<int>(k);
        }
    }
}

TEST(Autd3Levels, off_is_off_and_full_is_half_a_period)
{
    EXPECT_EQ(dutyWidths()[0], 0);
    EXPECT_EQ(dutyWidths()[255], 256);
    for (std::size_t duty = 1; duty < 256; ++duty)
        EXPECT_GT(dutyWidths()[duty], dutyWidths()[duty - 1]);
}

TEST(Autd3Levels, silence_is_one_pattern)
{
    DriveSignal signal = everyLevel(kTransducersPerUnit);
    signal.duty.assign(signal.duty.size(), 0);
    UnitPattern pattern;
    toUnit(signal, 0, pattern);
    EXPECT_EQ(pattern, UnitPattern());
    EXPECT_TRUE(pattern.isEven());
}
