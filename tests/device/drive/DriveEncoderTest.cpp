#include "device/drive/DriveEncoder.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

constexpr double kPi = 3.141592653589793;

double amplitudeOf(int level)
{
    return std::sin(kPi * level / 510.0);
}

// The slow reference: every level is tried, in double.
int nearestPhase(std::complex<double> q)
{
    int best = 0;
    double bestCosine = -2;
    for (int level = 0; level < 256; ++level)
    {
        const double cosine = std::real(q / std::abs(q) * std::polar(1.0, -2 * kPi * level / 256));
        if (cosine > bestCosine)
        {
            best = level;
            bestCosine = cosine;
        }
    }
    return best;
}

int nearestDuty(double amplitude)
{
    int best = 0;
    for (int level = 1; level < 256; ++level)
        if (std::abs(amplitudeOf(level) - amplitude) < std::abs(amplitudeOf(best) - amplitude))
            best = level;
    return best;
}

double phaseDistance(std::complex<double> q, int level)
{
    return std::abs(std::arg(q * std::polar(1.0, -2 * kPi * level / 256)));
}

} // namespace

TEST(DriveEncoder, chooses_the_nearest_levels)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<float> angle(-4.0F, 4.0F);
    std::uniform_real_distribution<float> amplitude(0.0F, 1.1F);
    std::vector<std::complex<float>> q(20000);
    for (std::complex<float>& value : q)
        value = std::polar(amplitude(random), angle(random));
    DriveSignal signal;
    ASSERT_TRUE(encode(q.data(), static_cast<int>(q.size()), signal));
    ASSERT_EQ(signal.size(), 20000);
    ASSERT_EQ(signal.duty.size(), 20000U);
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        const std::complex<double> exact(q[i]);
        // 1e-6 rad and 1e-6 of full drive: single precision's rounding at the border between two
        // levels.
        EXPECT_LE(phaseDistance(exact, signal.phase[i]),
                  phaseDistance(exact, nearestPhase(exact)) + 1e-6)
            << q[i];
        const double clipped = std::min(std::abs(exact), 1.0);
        EXPECT_LE(std::abs(clipped - amplitudeOf(signal.duty[i])),
                  std::abs(clipped - amplitudeOf(nearestDuty(clipped))) + 1e-6)
            << q[i];
    }
}

TEST(DriveEncoder, gives_back_every_level)
{
    DriveSignal levels;
    for (int phase = 0; phase < 256; ++phase)
        for (int duty = 0; duty < 256; ++duty)
        {
            levels.phase.push_back(static_cast<std::uint8_t>(phase));
            levels.duty.push_back(static_cast<std::uint8_t>(duty));
        }
    std::vector<std::complex<float>> q;
    decode(levels, q);
    DriveSignal again;
    ASSERT_TRUE(encode(q.data(), static_cast<int>(q.size()), again));
    EXPECT_EQ(again.duty, levels.duty);
    for (int i = 0; i < again.size(); ++i)
        EXPECT_EQ(again.phase[i],
                  levels.duty[i] == 0 ? 0 : levels.phase[i]); // nothing at 0 has a phase
}

TEST(DriveEncoder, decodes_the_drive_law)
{
    std::vector<std::complex<float>> q;
    decode({{0, 64, 128, 192, 1}, {255, 255, 32, 0, 100}}, q);
    ASSERT_EQ(q.size(), 5U);
    const std::complex<double> expected[] = {
        1, {0, 1}, -amplitudeOf(32), 0, std::polar(amplitudeOf(100), 2 * kPi / 256)};
    for (int i = 0; i < 5; ++i)
        EXPECT_LT(std::abs(std::complex<double>(q[i]) - expected[i]), 1e-7) << i; // float
    EXPECT_NEAR(amplitudeLevels()[32], 0.196, 5e-4); // "20 %, i.e. 32/255" of the paper
}

TEST(DriveEncoder, clips_and_keeps_the_phase)
{
    const std::vector<std::complex<float>> q = {
        {0, 1.5F}, {-3e38F, 3e38F}, {1e-42F, 0}, {0, 0}, {-0.0F, -0.0F}};
    DriveSignal signal;
    ASSERT_TRUE(encode(q.data(), 5, signal));
    EXPECT_EQ(signal.phase, (std::vector<std::uint8_t>{64, 96, 0, 0, signal.phase[4]}));
    EXPECT_EQ(signal.duty, (std::vector<std::uint8_t>{255, 255, 0, 0, 0}));
}

TEST(DriveEncoder, rounds_a_phase_just_below_a_turn_to_0)
{
    const std::vector<std::complex<float>> q = {{1, -1e-3F}, {1, -0.02F}};
    DriveSignal signal;
    ASSERT_TRUE(encode(q.data(), 2, signal));
    EXPECT_EQ(signal.phase[0], 0);
    EXPECT_EQ(signal.phase[1], 255);
}

TEST(DriveEncoder, silences_a_field_that_is_not_finite)
{
    const float bad[] = {std::numeric_limits<float>::quiet_NaN(),
                         std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity()};
    for (const float value : bad)
        for (int place = 0; place < 74;
             ++place) // in the vector part and in the remainder of a loop
        {
            std::vector<std::complex<float>> q(37, {1, 0});
            reinterpret_cast<float*>(q.data())[place] = value;
            DriveSignal signal;
            EXPECT_FALSE(encode(q.data(), 37, signal));
            EXPECT_EQ(signal.duty, std::vector<std::uint8_t>(37, 0));
            EXPECT_EQ(signal.phase, std::vector<std::uint8_t>(37, 0));
        }
}

TEST(DriveEncoder, takes_an_empty_field)
{
    DriveSignal signal{{1}, {2}};
    EXPECT_TRUE(encode(nullptr, 0, signal));
    EXPECT_EQ(signal.size(), 0);
    EXPECT_TRUE(signal.duty.empty());
}
