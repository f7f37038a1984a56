// The matrix of QuieterMatrixTest, with the array on the USB: what its firmware has of the bytes.
#include "device/ArrayDevice.h"
#include "tests/Eventually.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device/limits/QuieterTrial.h"

#include <atomic>
#include <mutex>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using quieter::Failure;
using quieter::FarSide;
using quieter::Way;

namespace
{

constexpr int kTransducers = 249;
constexpr int kForever = 1000000;

device::DeviceLayout layout()
{
    return {kTransducers, std::vector<int>(kTransducers, 0)};
}

void fail(EmulatedArray& array, Failure how, bool isOn)
{
    if (how == Failure::DROPS) array.mute = isOn; // the answers
    if (how == Failure::REFUSES) array.stalls = array.stalledCommits = isOn ? kForever : 0;
    if (how == Failure::HANGS) array.hangs = isOn ? kForever : 0;
    if (!isOn) array.letGo();
}

// A mute comes by the control endpoint, whatever becomes of fields.
FarSide
farSideOf(EmulatedArray& array, std::atomic<int>& mutes, bool isListed, Failure how, Way way)
{
    FarSide far;
    far.transducers = kTransducers;
    array.onControl = [&](const std::uint8_t*) { ++mutes; };
    far.device = device::openDevice(isListed ? "null:,usb:" : "usb:", layout());
    far.loudness = [&] { return quieter::loudnessOf(array.playing()); };
    far.silences = [&] { return mutes.load(); };
    far.fail = [&array, how] { fail(array, how, true); };
    far.recover = [&array, how] { fail(array, how, false); };
    far.quiet_s = quieter::kConfirm_s;
    far.staysFaulty = how == Failure::DROPS;
    far.isTold = how == Failure::DROPS || way == Way::CAP || way == Way::FIELD;
    return far;
}

class UsbQuieter : public testing::TestWithParam<std::tuple<bool, Failure, Way>>
{
};

TEST_P(UsbQuieter, field_that_is_not_confirmed_is_silence)
{
    const auto [isListed, how, way] = GetParam();
    EmulatedArray array(layout());
    std::atomic<int> mutes{0};
    EXPECT_EQ(quieter::trial(way, farSideOf(array, mutes, isListed, how, way)), "");
}

INSTANTIATE_TEST_SUITE_P(Matrix,
                         UsbQuieter,
                         testing::Combine(testing::Bool(),
                                          testing::ValuesIn(quieter::allFailures()),
                                          testing::ValuesIn(quieter::allWays())),
                         [](const auto& info)
                         {
                             return fmt::format("usb{}_{}_{}",
                                                std::get<0>(info.param) ? "_in_a_list" : "",
                                                quieter::nameOf(std::get<1>(info.param)),
                                                quieter::nameOf(std::get<2>(info.param)));
                         });

// An answer that comes late is that of the first.
TEST(UsbSilence, that_is_asked_for_again_keeps_its_number)
{
    EmulatedArray array(layout());
    std::mutex mutex;
    int count = 0;
    std::set<std::vector<std::uint8_t>> packets;
    array.onControl = [&](const std::uint8_t* bytes)
    {
        const std::lock_guard<std::mutex> lock(mutex);
        ++count;
        packets.insert(std::vector<std::uint8_t>(bytes, bytes + 12));
    };
    const auto device = device::openDevice("usb:", layout());
    ASSERT_TRUE(device->send(quieter::fieldOf(kTransducers, false)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    {
        const std::lock_guard<std::mutex> lock(mutex);
        count = 0; // without those of the greeting
        packets.clear();
    }
    array.mute = true;
    device->silence(); // it is asked for again after 100 ms, 200 ms, .., and sent every 20 ms
    EXPECT_TRUE(eventually(
        [&]
        {
            const std::lock_guard<std::mutex> lock(mutex);
            return count > 5;
        }));
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_EQ(packets.size(), 1U);
}

} // namespace
