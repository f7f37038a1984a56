#include "engine-bridge/playing/ArrayOutput.h"

#include "device/limits/GuardedDevice.h"
#include "tests/engine-bridge/playing/PlayerDevices.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace
{

using midair::base::MessageLog;
using midair::base::StopToken;
using midair::bridge::ArrayOutput;
using midair::haptics::FieldSequence;

FieldSequence held(int transducers)
{
    FieldSequence sequence;
    sequence.fields.emplace_back(Eigen::VectorXcf::Constant(transducers, 1.0f));
    return sequence;
}

void play(ArrayOutput& output, const FieldSequence& sequence)
{
    output.play(midair::bridge::drivesOf(sequence.fields, 5), sequence.modulation, StopToken());
}

/// Returns what was thrown; empty: nothing.
std::string refusal(ArrayOutput& output, const FieldSequence& sequence)
{
    try
    {
        play(output, sequence);
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return {};
}

TEST(ArrayOutput, SaysWhatIsWrongWithAFieldAndGoesOn)
{
    MessageLog messages;
    Collector* device = nullptr;
    ArrayOutput output(
        [&device]
        {
            auto made = std::make_unique<Collector>();
            device = made.get();
            return made;
        },
        messages);
    EXPECT_EQ(refusal(output, held(5)), "");
    const std::vector<Eigen::VectorXcf> before = output.planned();

    EXPECT_EQ(refusal(output, held(4)),
              "solver gave 4 activations for 5 transducers; nothing is played");
    FieldSequence second = held(5);
    second.fields.push_back(held(4).fields[0]);
    EXPECT_EQ(refusal(output, second),
              "solver gave 4 activations for 5 transducers; nothing is played");
    FieldSequence broken = held(5);
    broken.fields[0][3] = std::nanf("");
    EXPECT_EQ(refusal(output, broken),
              "solver gave activations that are not finite; nothing is played");

    EXPECT_EQ(device->signals().size(), 1u);
    ASSERT_EQ(output.planned().size(), 1u);
    EXPECT_EQ(output.planned()[0], before[0]);
    EXPECT_TRUE(messages.all().empty());
}

TEST(ArrayOutput, HasNoDeviceWhateverIsThrown)
{
    MessageLog messages;
    ArrayOutput output([]() -> std::unique_ptr<midair::device::ArrayDevice> { throw 5; }, messages);
    EXPECT_FALSE(output.isOpen());
    ASSERT_EQ(messages.messages().size(), 1u);
    EXPECT_EQ(messages.messages().front().code, midair::base::MessageCode::DEVICE_OPEN);
    EXPECT_EQ(messages.messages().front().text, "something was thrown that is no std::exception");
}

midair::device::DeviceLayout fivePlaces()
{
    midair::device::DeviceLayout layout;
    layout.transducers = 5;
    return layout;
}

bool isSounding(const ArrayOutput& output)
{
    return !output.played().front().isZero(0.0f);
}

// A device with a hold is silent once nobody wants its field any more, and plays it until then.
TEST(ArrayOutput, WhatIsHeldPlaysAsLongAsItIsWanted)
{
    using midair::bridge::ArrayState;
    using midair::device::GuardedDevice;
    midair::test::SetClock clock;
    midair::device::SafetyLimits limits;
    limits.hold_s = 0.4;
    const auto open = [&]
    {
        return std::make_unique<GuardedDevice>(
            midair::device::openDevice("sim:", fivePlaces()), limits, 5, nullptr, clock);
    };
    const auto lead = std::make_shared<midair::device::Lead>(clock);
    MessageLog messages;
    ArrayOutput output(open, messages);
    ASSERT_TRUE(output.isOpen());
    output.follow(lead);
    clock.await(1);
    play(output, held(5));
    for (int k = 0; k < 30; ++k)
    {
        clock.pass(0.39);
        EXPECT_TRUE(isSounding(output)) << "it rests, and is wanted";
        EXPECT_EQ(output.state(), ArrayState::PLAYING);
        lead->keepAlive();
    }
    clock.pass(0.41);
    EXPECT_FALSE(isSounding(output)) << "the application stands still";
    EXPECT_EQ(output.state(), ArrayState::SILENT);
    EXPECT_EQ(output.attend(StopToken()), ArrayOutput::Attention::NOTHING) << "nobody wants it";
    EXPECT_FALSE(isSounding(output));
    lead->keepAlive();
    EXPECT_FALSE(isSounding(output)) << "the word alone plays nothing";
    EXPECT_EQ(output.attend(StopToken()), ArrayOutput::Attention::RESENT);
    EXPECT_TRUE(isSounding(output)) << "the application goes on";
}

// Or the same field would not be sent again once it is wanted again.
TEST(ArrayOutput, WhatAnotherThreadHasSilencedDoesNotPlay)
{
    using midair::bridge::ArrayState;
    MessageLog messages;
    ArrayOutput output([] { return midair::device::openDevice("sim:", fivePlaces()); }, messages);
    play(output, held(5));
    EXPECT_TRUE(output.isPlaying());
    output.silenceNow();
    EXPECT_FALSE(output.isPlaying());
    EXPECT_EQ(output.state(), ArrayState::SILENT);
    play(output, held(5));
    EXPECT_TRUE(output.isPlaying());
    EXPECT_TRUE(isSounding(output));
    output.silence(ArrayOutput::Silence::WANTED);
    EXPECT_TRUE(output.isPlaying()) << "silence is what it was given";
}

TEST(ArrayOutput, AFieldOfSilenceIsNotSaidToPlay)
{
    using midair::bridge::ArrayState;
    MessageLog messages;
    ArrayOutput output([] { return midair::device::openDevice("sim:", fivePlaces()); }, messages);
    FieldSequence silence;
    silence.fields.emplace_back(Eigen::VectorXcf::Zero(5));
    play(output, silence);
    EXPECT_NE(output.reading().state, ArrayState::PLAYING);
    play(output, held(5));
    EXPECT_EQ(output.reading().state, ArrayState::PLAYING);
    output.setAmplitudeCap(0.0);
    output.judge(ArrayState::SILENT);
    play(output, held(5));
    EXPECT_EQ(output.reading().state, ArrayState::SILENT);
}

// Whoever reads "fault" looks for something that is broken.
TEST(ArrayOutput, WhatAMuteHasSilencedIsNoFaultAndIsPlayedAgain)
{
    using midair::bridge::ArrayState;
    MessageLog messages;
    ArrayOutput output([] { return midair::device::openDevice("sim:", fivePlaces()); }, messages);
    for (const bool isAttended : {true, false})
    {
        play(output, held(5));
        output.setMuted(true);
        if (isAttended)
        {
            EXPECT_EQ(output.attend(StopToken()), ArrayOutput::Attention::NOTHING);
        }
        EXPECT_EQ(output.state(), ArrayState::MUTED);
        output.setMuted(false);
        EXPECT_FALSE(isSounding(output)) << isAttended;
        EXPECT_EQ(output.state(), ArrayState::MUTED) << "until it is played again";
        EXPECT_EQ(output.attend(StopToken()), ArrayOutput::Attention::RESENT) << isAttended;
        EXPECT_TRUE(isSounding(output));
        EXPECT_EQ(output.state(), ArrayState::PLAYING);
    }
}

} // namespace
