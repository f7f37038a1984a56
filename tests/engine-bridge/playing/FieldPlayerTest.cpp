#include "engine-bridge/playing/FieldPlayer.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/InputError.h"
#include "tests/engine-bridge/playing/PlayerDevices.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <cmath>

#include <gtest/gtest.h>

namespace
{

using midair::bridge::FieldPlayer;
using midair::device::DriveSignal;
using midair::test::SetClock;

TEST(FieldPlayer, PlaysTheFieldsInTurn)
{
    SetClock clock;
    Collector device;
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    clock.pass(0.0401); // steps 0 to 20
    const std::vector<DriveSignal> signals = device.signals();
    ASSERT_EQ(signals.size(), 21u);
    for (std::size_t k = 0; k < signals.size(); ++k)
    {
        EXPECT_EQ(signals[k].phase[0], 10 * (k % 4));
        EXPECT_EQ(signals[k].duty[0], 255);
    }
    player.stop();
    clock.pass(0.02);
    EXPECT_EQ(device.signals().size(), signals.size()) << "after stop() nothing comes any more";
    const FieldPlayer::Counters counters = player.counters();
    EXPECT_EQ(counters.sent, signals.size());
    EXPECT_EQ(counters.leftOut, 0u);
    EXPECT_LT(counters.worstLateness_s, 1e-9);
}

/// Takes a while for each field, by the clock.
class LateCollector : public Collector
{
public:
    LateCollector(SetClock& clock, double late_s) : _clock(clock), _late_s(late_s) {}
    bool send(const DriveSignal& signal) override
    {
        _clock.jump(_late_s);
        return Collector::send(signal);
    }

private:
    SetClock& _clock;
    const double _late_s;
};

TEST(FieldPlayer, LeavesOutStepsThatAreLateAndKeepsTime)
{
    SetClock clock;
    constexpr double kLate_s = 0.0051234; // two steps and a half
    LateCollector device(clock, kLate_s);
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitFor(20));
    player.stop();
    const std::vector<DriveSignal> signals = device.signals();
    // The one that is due when the last one has gone.
    const auto stepOf = [&](std::size_t k)
    { return static_cast<std::uint64_t>(static_cast<double>(k) * kLate_s * options.fieldRate_Hz); };
    for (std::size_t k = 0; k < signals.size(); ++k)
        EXPECT_EQ(signals[k].phase[0], 10 * (stepOf(k) % 4)) << k;
    const FieldPlayer::Counters counters = player.counters();
    EXPECT_EQ(counters.sent, signals.size());
    EXPECT_EQ(counters.sent + counters.leftOut, stepOf(signals.size() - 1) + 1);
    EXPECT_GT(counters.worstLateness_s, 0.001);
    EXPECT_LT(counters.worstLateness_s, 0.002);
}

TEST(FieldPlayer, ASingleFieldIsSentOnce)
{
    SetClock clock;
    Collector device;
    FieldPlayer player(device, clock);
    clock.await(1);
    player.play(numberedFields(1));
    clock.pass(1.0);
    EXPECT_EQ(device.signals().size(), 1u);
    player.play(numberedFields(1));
    clock.pass(1.0);
    EXPECT_EQ(device.signals().size(), 2u);
}

TEST(FieldPlayer, OneThatIsRefusedIsSentAgain)
{
    SetClock clock;
    Collector device;
    device.refusing = true;
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 100.0;
    player.play(numberedFields(1), options);
    clock.pass(0.0201);
    EXPECT_EQ(player.counters().refused, 3u) << "at the rate of the fields";
    device.refusing = false;
    clock.pass(0.1);
    EXPECT_EQ(player.counters().sent, 1u);
    EXPECT_EQ(player.counters().refused, 3u);
}

TEST(FieldPlayer, TheAmplitudeIsModulatedWithinALevelOfWhatEncodingGives)
{
    Collector device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 1000.0;
    options.amplitudeRate_Hz = 250.0; // amplitudes 1, sqrt(1/2), 0, sqrt(1/2)
    Eigen::VectorXcf q(3);
    q << 1.0f, 0.5f, 0.1f;
    DriveSignal full;
    midair::device::encode(q.data(), 3, full);
    player.play({full}, options);
    ASSERT_TRUE(device.waitFor(40));
    player.stop();
    int seen[3] = {0, 0, 0};
    for (const DriveSignal& signal : device.signals())
    {
        int matches = -1;
        int k = 0;
        for (const float amplitude : {1.0f, std::sqrt(0.5f), 0.0f})
        {
            const Eigen::VectorXcf scaled = q * amplitude;
            DriveSignal expected;
            midair::device::encode(scaled.data(), 3, expected);
            bool all = true;
            // Rounded twice, to the level of q and then to that of the product.
            for (int i = 0; i < 3; ++i)
                all = all && std::abs(signal.duty[i] - expected.duty[i]) <= 1;
            if (all) matches = k;
            ++k;
        }
        ASSERT_GE(matches, 0);
        ++seen[matches];
    }
    for (const int times : seen)
        EXPECT_GT(times, 0);
}

TEST(FieldPlayer, SaysWhatIsWrongAndGoesOn)
{
    Collector device;
    FieldPlayer player(device);
    const auto failing = [&](const std::vector<DriveSignal>& cycle)
    {
        try
        {
            player.play(cycle);
        }
        catch (const midair::base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(failing({}), "field player: there are no fields; there must be at least one");
    std::vector<DriveSignal> fields = numberedFields(2);
    fields[1].phase.resize(4);
    fields[1].duty.resize(4);
    EXPECT_EQ(failing(fields), "field player: field 1 is for 4 transducers, the first one for 5");
    fields = numberedFields(2);
    fields[1].duty.resize(3);
    EXPECT_EQ(failing(fields), "field player: field 1 is for 5 transducers, the first one for 5");
    EXPECT_TRUE(device.signals().empty());
    player.play(numberedFields(1));
    EXPECT_TRUE(device.waitFor(1));
}

} // namespace
