#include "haptics/base/InputError.h"
#include "haptics/probe/PressureProbe.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

FieldSequence sequenceOf(int fields, double fieldRate_Hz, double modulation_Hz)
{
    FieldSequence sequence;
    sequence.fields.assign(static_cast<std::size_t>(fields), Eigen::VectorXcf::Ones(4));
    sequence.modulation.fieldRate_Hz = fieldRate_Hz;
    sequence.modulation.amplitudeRate_Hz = modulation_Hz;
    return sequence;
}

TEST(DriveSchedule, FieldsInTurnRepeat)
{
    const DriveSchedule schedule = stepsOf(sequenceOf(3, 500.0, 0.0), 1.0);
    ASSERT_EQ(schedule.steps.size(), 3u);
    EXPECT_TRUE(schedule.repeats);
    EXPECT_DOUBLE_EQ(schedule.duration_s(), 0.006);
    for (int k = 0; k < 3; ++k)
    {
        EXPECT_EQ(schedule.steps[std::size_t(k)].drive, k);
        EXPECT_EQ(schedule.steps[std::size_t(k)].amplitude, 1.0);
    }
}

TEST(DriveSchedule, AModulationRepeatsWithTheFieldsWhereItDoes)
{
    const FieldSequence sequence = sequenceOf(8, 1000.0, 200.0);
    const DriveSchedule schedule = stepsOf(sequence, 1.0);
    ASSERT_EQ(schedule.steps.size(), 40u);
    const Modulator modulator(sequence.modulation);
    for (int k = 0; k < 40; ++k)
    {
        const ScheduledDrive& step = schedule.steps[std::size_t(k)];
        EXPECT_EQ(step.drive, k % 8);
        EXPECT_NEAR(step.amplitude, std::fabs(std::cos(M_PI * k / 5.0)), 1e-9);
    }
    const DriveSchedule never = stepsOf(sequenceOf(1, 1000.0, 100.0 * std::sqrt(2.0)), 0.5);
    EXPECT_FALSE(never.repeats);
    EXPECT_LE(never.begin_s, -0.19);
    EXPECT_GE(never.begin_s + never.duration_s(), 0.5);
    // The step that begins at time 0 has the full amplitude.
    EXPECT_NEAR(
        never.steps[std::size_t(std::lround(-never.begin_s * 1000.0))].amplitude, 1.0, 1e-9);
}

TEST(DriveSchedule, WhatCannotBePlayedIsRefused)
{
    EXPECT_THROW(stepsOf(FieldSequence(), 1.0), base::InputError);
    EXPECT_THROW(stepsOf(sequenceOf(1, 1000.0, 0.0), NAN), base::InputError);
    EXPECT_THROW(stepsOf(sequenceOf(1, 1000.0, 0.0), 3601.0), base::InputError);
    EXPECT_THROW(stepsOf(sequenceOf(1, 40e3, 100.0 * std::sqrt(2.0)), 3600.0), base::InputError);
}

} // namespace
} // namespace midair::haptics
