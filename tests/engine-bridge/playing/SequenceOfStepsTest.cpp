#include "engine-bridge/playing/FieldPlayer.h"

#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

using midair::bridge::sequenceOfSteps;
using midair::bridge::signalOfStep;
using midair::device::DriveSequence;
using midair::device::DriveSignal;
using midair::haptics::Modulator;
using midair::haptics::ModulatorOptions;

namespace
{

// Field k has phase 10 k, and duties from silence to full drive.
std::vector<DriveSignal> numberedSignals(int count)
{
    std::vector<DriveSignal> signals;
    for (int k = 0; k < count; ++k)
        signals.push_back({std::vector<std::uint8_t>(5, static_cast<std::uint8_t>(10 * k)),
                           {0, 30, 90, 200, 255}});
    return signals;
}

ModulatorOptions optionsOf(double fieldRate_Hz, double amplitudeRate_Hz)
{
    ModulatorOptions options;
    options.fieldRate_Hz = fieldRate_Hz;
    options.amplitudeRate_Hz = amplitudeRate_Hz;
    return options;
}

std::size_t stepsOf(int fields, double fieldRate_Hz, double amplitudeRate_Hz, int most = 4096)
{
    const Modulator modulator(optionsOf(fieldRate_Hz, amplitudeRate_Hz));
    return sequenceOfSteps(numberedSignals(fields), modulator, most).signals.size();
}

} // namespace

TEST(SequenceOfSteps, RepeatsWithTheCycleAndTheModulation)
{
    EXPECT_EQ(stepsOf(8, 1000, 0), 8u);
    EXPECT_EQ(stepsOf(1, 1000, 200), 5u);
    EXPECT_EQ(stepsOf(8, 1000, 200), 40u);
    EXPECT_EQ(stepsOf(10, 1000, 200), 10u);
    EXPECT_EQ(stepsOf(3, 0.3, 0.1), 3u); // a quotient that no double holds
    EXPECT_EQ(stepsOf(1, 40000, 10), 4000u);
}

TEST(SequenceOfSteps, IsNoneWhereItDoesNotRepeatInTime)
{
    EXPECT_EQ(stepsOf(1, 1000, 300), 0u); // 3 1/3 steps
    EXPECT_EQ(stepsOf(1, 1000, 499.999), 0u);
    EXPECT_EQ(stepsOf(1, 10, 500), 0u); // several periods a step
    EXPECT_EQ(stepsOf(8, 1000, 200, 39), 0u);
    EXPECT_EQ(stepsOf(8, 1000, 200, 40), 40u);
    EXPECT_EQ(stepsOf(8, 1000, 0, 7), 0u);
    EXPECT_EQ(stepsOf(8, 1000, 0, 0), 0u); // for a device that keeps none
    EXPECT_EQ(stepsOf(1, 40000, 0.5), 0u);
    EXPECT_EQ(stepsOf(0, 1000, 0), 0u);
}

// In later periods a level may differ, where rounding falls the other way.
TEST(SequenceOfSteps, IsWhatTheStepsAre)
{
    for (const ModulatorOptions& options :
         {optionsOf(1000, 0), optionsOf(1000, 250), optionsOf(7000, 100), optionsOf(0.3, 0.1)})
    {
        const std::vector<DriveSignal> cycle = numberedSignals(6);
        const Modulator modulator(options);
        const DriveSequence sequence = sequenceOfSteps(cycle, modulator, 4096);
        ASSERT_FALSE(sequence.signals.empty());
        EXPECT_TRUE(sequence.fits(5));
        EXPECT_EQ(sequence.rate_Hz, options.fieldRate_Hz);
        const auto count = static_cast<std::int64_t>(sequence.signals.size());
        DriveSignal signal;
        for (std::int64_t step = 0; step < 20 * count; ++step)
        {
            const DriveSignal& kept = sequence.signals[static_cast<std::size_t>(step % count)];
            signalOfStep(cycle, modulator, step, signal);
            ASSERT_EQ(kept.phase, signal.phase) << step;
            for (std::size_t i = 0; i < 5; ++i)
                ASSERT_LE(std::abs(kept.duty[i] - signal.duty[i]), step < count ? 0 : 1) << step;
        }
    }
}
