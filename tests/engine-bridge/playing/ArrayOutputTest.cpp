#include "engine-bridge/playing/ArrayOutput.h"

#include "tests/engine-bridge/playing/PlayerDevices.h"

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

/// Returns what play() threw; empty: nothing.
std::string refusal(ArrayOutput& output, const FieldSequence& sequence)
{
    try
    {
        output.play(sequence, 5, StopToken());
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

} // namespace
