// What a simulated array says that it has played, and when.
#include "device/drive/DriveEncoder.h"
#include "device/opening/MultiDevice.h"
#include "device/simulation/SimulatedArray.h"
#include "device/simulation/VirtualFirmware.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"

#include <chrono>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

const DeviceLayout kFour = {4, {}};

void play(VirtualFirmware& firmware, std::uint32_t sequence, std::uint8_t phase, double now_s)
{
    std::vector<std::uint8_t> bytes;
    protocol::appendField(bytes, evenField(4, phase, 200), protocol::ranges(kFour), sequence);
    firmware.receive(bytes.data(), bytes.size(), now_s);
}

VirtualFirmware::Options withHistory()
{
    VirtualFirmware::Options options;
    options.hasHistory = true;
    return options;
}

std::string openError(const std::string& uri)
{
    try
    {
        openDevice(uri, kFour);
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(PlayedHistory, KeepsWhatSoundsAndATenthOfASecondBefore)
{
    PlayedHistory<int> history;
    EXPECT_TRUE(history.since(0.0).empty());
    for (int k = 0; k < 10; ++k)
        history.note(0.05 * k, k);
    const auto all = history.since(-1.0);
    ASSERT_EQ(all.size(), 4U) << "0.30 sounds until 0.35, 0.11 s before the newest";
    EXPECT_EQ(all.front(), std::make_pair(0.05 * 6, 6));
    const auto later = history.since(0.42);
    ASSERT_EQ(later.size(), 2U);
    EXPECT_EQ(later.front().second, 8) << "it has begun before, and sounds then";
    EXPECT_EQ(history.since(9.0).size(), 1U) << "the newest sounds on";
}

TEST(PlayedHistory, HasAMostOfAllRates)
{
    PlayedHistory<int> history;
    for (int k = 0; k < 5000; ++k)
        history.note(1e-6 * k, k);
    EXPECT_EQ(history.since(-1.0).size(), PlayedHistory<int>::kMost);
    EXPECT_EQ(history.since(-1.0).back().second, 4999);
}

TEST(PlayedSince, HasEachFieldFromWhenItSoundsAndTheWatchdogsSilence)
{
    VirtualFirmware::Options options = withHistory();
    options.latency_s = 5e-3;
    VirtualFirmware firmware(kFour, options);
    play(firmware, 1, 10, 1.0);
    play(firmware, 2, 20, 1.02);
    const auto played = firmware.playedSince(0.95, 1.2);
    ASSERT_EQ(played.size(), 3U);
    EXPECT_DOUBLE_EQ(played[0].first, 1.005);
    EXPECT_EQ(played[0].second, evenField(4, 10, 200));
    EXPECT_DOUBLE_EQ(played[1].first, 1.025);
    EXPECT_EQ(played[1].second, evenField(4, 20, 200));
    EXPECT_DOUBLE_EQ(played[2].first, 1.12) << "0.1 s after the last packet";
    EXPECT_EQ(played[2].second.duty, std::vector<std::uint8_t>(4, 0));
}

TEST(PlayedSince, IsNotKeptWhereNobodyAsks)
{
    VirtualFirmware firmware(kFour);
    play(firmware, 1, 10, 1.0);
    EXPECT_TRUE(firmware.playedSince(0.0, 1.01).empty());
}

TEST(PlayedSince, OfADeviceIsWhatItPlayedInTimeOfTheSteadyClock)
{
    for (const std::string uri : {"sim:", "sim:?max-amplitude=0.5", "sim:,null:"})
    {
        SCOPED_TRACE(uri);
        const auto device = openDevice(uri, kFour);
        const double begin_s = midair::base::steadySeconds();
        ASSERT_TRUE(device->send(evenField(4, 64, 255)));
        const double sent_s = midair::base::steadySeconds();
        EXPECT_TRUE(eventually([&] { return midair::base::steadySeconds() > sent_s; }));
        const double silenced_s = midair::base::steadySeconds();
        device->silence();
        const auto played = device->playedSince(begin_s);
        ASSERT_GE(played.size(), 2U);
        const PlayedField& field = played[played.size() - 2];
        EXPECT_GE(field.since_s, begin_s);
        EXPECT_LE(field.since_s, sent_s);
        const float amplitude = uri.find("max") == std::string::npos ? 1.0F : 0.5F;
        ASSERT_EQ(field.q.size(), 4U);
        EXPECT_NEAR(field.q[0].imag(), amplitude, 0.01F);
        EXPECT_GE(played.back().since_s, silenced_s);
        EXPECT_EQ(played.back().q, std::vector<std::complex<float>>(4));
    }
}

TEST(PlayedSince, OfABoardIsWhatItsLevelsMakeOfAField)
{
    const auto device = openDevice("sim:?board=openmpd", {256, {}});
    const double begin_s = midair::base::steadySeconds();
    ASSERT_TRUE(device->send(evenField(256, 64, 255)));
    const auto played = device->playedSince(begin_s);
    ASSERT_FALSE(played.empty());
    EXPECT_EQ(played.back().q, device->played());
}

TEST(PlayedSince, OfSeveralPartsChangesWithEachOfThem)
{
    std::vector<MultiDevice::Part> parts;
    const auto part = [&](int first)
    {
        parts.push_back({openDevice("sim:", {2, {}}), first, 2});
        return parts.back().device.get();
    };
    ArrayDevice* const left = part(0);
    ArrayDevice* const right = part(2);
    const MultiDevice both(std::move(parts), 4);
    const double begin_s = midair::base::steadySeconds();
    left->send(evenField(2, 0, 255));
    right->send(evenField(2, 64, 255));
    left->silence();
    const auto played = both.playedSince(begin_s);
    ASSERT_GE(played.size(), 3U);
    const auto amplitudes = [&](std::size_t fromEnd)
    {
        const auto& q = played[played.size() - fromEnd].q;
        return std::make_pair(std::lround(std::abs(q[1])), std::lround(std::abs(q[2])));
    };
    EXPECT_EQ(amplitudes(3), std::make_pair(1L, 0L));
    EXPECT_EQ(amplitudes(2), std::make_pair(1L, 1L));
    EXPECT_EQ(amplitudes(1), std::make_pair(0L, 1L));
}

TEST(PlayedSince, OthersDoNotKnow)
{
    const auto device = openDevice("null:", kFour);
    device->send(evenField(4, 0, 255));
    EXPECT_TRUE(device->playedSince(0.0).empty());
}

TEST(PlayedSince, RingingIsToldOn)
{
    EXPECT_EQ(openDevice("sim:?ringing=190us", kFour)->ability().ringing_s, 190e-6);
    EXPECT_EQ(openDevice("sim:?ringing=0us", kFour)->ability().ringing_s, 0.0);
    EXPECT_LT(openDevice("sim:", kFour)->ability().ringing_s, 0.0);
    EXPECT_EQ(openDevice("null:,sim:?ringing=1ms", kFour)->ability().ringing_s, 1e-3);
    EXPECT_NE(openError("sim:?ringing=11ms")
                  .find("ringing is 0.011 s; it should be 0s to 10ms, the time constant of the "
                        "transducers"),
              std::string::npos)
        << openError("sim:?ringing=11ms");
    EXPECT_NE(openError("sim:?ringing=190").find("should be a time such as"), std::string::npos);
}
