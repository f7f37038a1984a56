// A line that carries so many fields a second: what doesn't fit is refused or slowed down, and
// told.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/InputError.h"
#include "haptics/sequence/Modulator.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

haptics::LineRate lineOf(double fieldsPerSecond, bool onOff = false)
{
    return {fieldsPerSecond, onOff};
}

std::string refusal(const haptics::LineRate& line, double frequency_Hz)
{
    haptics::ModulatorOptions modulation;
    try
    {
        line.fit(modulation, frequency_Hz);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "none";
}

double fitted(const haptics::LineRate& line, double frequency_Hz, double fieldRate_Hz = 1000.0)
{
    haptics::ModulatorOptions modulation;
    modulation.fieldRate_Hz = fieldRate_Hz;
    line.fit(modulation, frequency_Hz);
    return modulation.fieldRate_Hz;
}

/// Takes everything, over a line that carries 85.5 fields/s.
class SlowDevice : public FakeDevice
{
public:
    using FakeDevice::FakeDevice;
    device::DriveAbility ability() const override
    {
        device::DriveAbility ability;
        ability.fieldsPerSecond = 85.5;
        return ability;
    }
};

HologramOptions slowOptions(const std::shared_ptr<FakeLog>& log)
{
    HologramOptions options = fakeOptions(log);
    options.deviceFactory = [log](const std::string&, const device::DeviceLayout& layout)
    { return std::make_unique<SlowDevice>(log, layout.transducers); };
    return options;
}

std::ptrdiff_t countOf(const HologramResult& result, const std::string& message)
{
    return std::count(result.messages.begin(), result.messages.end(), message);
}

const std::string kRefusal =
    "modulation of 200 Hz needs 800 fields/s; the device carries 85.5: at most 21.3 Hz";

} // namespace

TEST(SlowLine, RefusesAModulationThatItDoesNotCarry)
{
    EXPECT_EQ(refusal(lineOf(85.5), 200.0), kRefusal);
    EXPECT_EQ(refusal(lineOf(85.5), 21.3), "none");
    // What is on or off needs no more than one of each.
    EXPECT_EQ(refusal(lineOf(85.5, true), 42.0), "none");
    EXPECT_EQ(refusal(lineOf(85.5, true), 60.0),
              "modulation of 60 Hz needs 120 fields/s; the device carries 85.5: at most 42.7 Hz");
    EXPECT_EQ(refusal(lineOf(0.0), 500.0), "none");
    EXPECT_EQ(refusal(haptics::LineRate(), 500.0), "none");
}

TEST(SlowLine, LowersTheFieldRateToWhatItCarries)
{
    EXPECT_EQ(fitted(lineOf(85.5), 0.0), 85.5);
    EXPECT_EQ(fitted(lineOf(85.5), 0.0, 50.0), 50.0);
    EXPECT_EQ(fitted(lineOf(0.0), 200.0), 1000.0);
    EXPECT_EQ(fitted(lineOf(5000.0), 200.0), 1000.0);
    // To whole periods, or the samples would beat with the modulation.
    EXPECT_EQ(fitted(lineOf(950.0), 200.0), 800.0);
    EXPECT_EQ(fitted(lineOf(85.5), 20.0), 80.0);
    EXPECT_EQ(fitted(lineOf(85.5, true), 42.0), 84.0);
}

TEST(SlowLine, AModulationTooFastForTheDeviceIsSilentAndTold)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = slowOptions(log);
    options.modulation.amplitudeRate_Hz = 200.0;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    const auto result = pipeline.process(squareSnapshot(0.01));
    EXPECT_EQ(result->report().stop, haptics::StopReason::REFUSED);
    EXPECT_EQ(result->report().message, kRefusal);
    EXPECT_EQ(countOf(*result, kRefusal), 1) << "once";
    EXPECT_FALSE(result->playing);
    EXPECT_EQ(log->sends, 0);
    EXPECT_EQ(log->solves, 0) << "nothing is solved in vain";
}

TEST(SlowLine, AnObjectsModulationTooFastForTheDeviceSilencesWhatPlays)
{
    const auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(slowOptions(log));
    ASSERT_TRUE(pipeline.process(squareSnapshot())->playing);
    ASSERT_EQ(log->sends, 1);
    SceneSnapshot two = squareSnapshot();
    two.objects[0].properties.modulationFrequency_Hz = 200.0;
    EXPECT_EQ(pipeline.process(two)->report().message, kRefusal);
    EXPECT_EQ(log->silences, 1);
    // Not alike: of two objects one is steady, so that a period is made of fields of its own.
    two.objects.push_back(squareSnapshot(0.05).objects[0]);
    two.objects[1].id = 2;
    EXPECT_EQ(pipeline.process(two)->report().message, kRefusal);
    EXPECT_EQ(log->sends, 1);
    two.objects[0].properties.modulationFrequency_Hz = 20.0;
    const auto result = pipeline.process(two);
    EXPECT_TRUE(result->playing);
    EXPECT_EQ(result->sequence.fields.size(), 4U);
    EXPECT_EQ(result->sequence.modulation.fieldRate_Hz, 80.0);
}

TEST(SlowLine, FieldsInTurnFollowEachOtherAsFastAsTheDeviceTakesThem)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = slowOptions(log);
    options.subsets = 4;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    const auto result = pipeline.process(squareSnapshot(0.01));
    EXPECT_EQ(result->sequence.fields.size(), 4U);
    EXPECT_EQ(result->sequence.modulation.fieldRate_Hz, 85.5);
    EXPECT_EQ(countOf(*result,
                      "fields in turn follow each other at 85.5 a second, not 1000: the device "
                      "carries 85.5"),
              1);
}

TEST(SlowLine, IsNoneForWhatADeviceStores)
{
    haptics::ModulatorOptions modulation;
    const auto stored = [&](const haptics::LineRate& line, double frequency_Hz, int fields = 1)
    {
        modulation = {};
        return line.fit(modulation, frequency_Hz, fields);
    };
    const haptics::LineRate swaps(88.0, true, 2);
    EXPECT_EQ(stored(swaps, 200.0), 200.0);
    EXPECT_EQ(modulation.fieldRate_Hz, 400.0);
    EXPECT_EQ(stored(swaps, 40.0), 40.0);
    EXPECT_EQ(modulation.fieldRate_Hz, 80.0);
    EXPECT_THROW(stored(swaps, 200.0, 3), base::InputError) << "more fields than two";
    EXPECT_EQ(stored(swaps, 0.0), 0.0);
    EXPECT_EQ(modulation.fieldRate_Hz, 88.0);

    const haptics::LineRate patterns(57.0, false, 32, 40e3);
    EXPECT_EQ(stored(patterns, 200.0), 200.0);
    EXPECT_EQ(modulation.fieldRate_Hz, 1000.0); // 40 periods each
    EXPECT_EQ(stored(patterns, 5.0), 5.0);
    EXPECT_GE(modulation.fieldRate_Hz * 255, 40e3) << "a step lasts 255 periods at most";
    for (double frequency_Hz = 5.0; frequency_Hz <= 500.0; frequency_Hz += 1.7)
    {
        const double played_Hz = stored(patterns, frequency_Hz);
        const double steps = modulation.fieldRate_Hz / played_Hz;
        EXPECT_NEAR(played_Hz, frequency_Hz, 1e-4 * frequency_Hz * frequency_Hz);
        EXPECT_NEAR(steps, std::round(steps), 1e-9);
        EXPECT_LE(steps, 32.0);
        const double periods = 40e3 / modulation.fieldRate_Hz;
        EXPECT_NEAR(periods, std::round(periods), 1e-9);
    }
    EXPECT_EQ(stored(patterns, 2.0), 2.0);
    EXPECT_LE(modulation.fieldRate_Hz, 57.0) << "which the line carries";
}

TEST(SlowLine, OfASimulatedBoardIsTheBoards)
{
    HologramOptions options = slowOptions(std::make_shared<FakeLog>());
    options.deviceFactory = {};
    options.array = haptics::TransducerArray::load("sonicsurface");
    options.deviceUri = "sim:?board=sonicsurface";
    options.modulation.amplitudeRate_Hz = 60.0;
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].pose.translation().z() = 0.12;
    // With a limit that needs time the host plays each field, and the line is too slow.
    options.deviceUri = "sim:?board=sonicsurface&ramp=20ms";
    const std::string message = HologramPipeline(options).process(snapshot)->report().message;
    EXPECT_EQ(message.find("modulation of 60 Hz needs 120 fields/s; the device carries "), 0U)
        << message;
    options.deviceUri = "sim:?board=sonicsurface&hold=1s";
    for (const double frequency_Hz : {60.0, 200.0})
    {
        options.modulation.amplitudeRate_Hz = frequency_Hz;
        HologramPipeline pipeline(options);
        const auto fast = pipeline.process(snapshot);
        EXPECT_TRUE(fast->playing) << fast->report().message;
        EXPECT_EQ(fast->sequence.modulation.fieldRate_Hz, 2 * frequency_Hz);
    }
    options.deviceUri = "sim:?board=sonicsurface";
    options.modulation.amplitudeRate_Hz = 40.0;
    const auto result = HologramPipeline(options).process(snapshot);
    EXPECT_NE(result->report().stop, haptics::StopReason::REFUSED) << result->report().message;
}
