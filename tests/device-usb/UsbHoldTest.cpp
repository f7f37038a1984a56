// The matrix of HoldMatrixTest, with the array on the USB: what its firmware has of the bytes.
#include "device/ArrayDevice.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/engine-bridge/playing/HoldTrial.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

using midair::holds::Mode;

class UsbHold : public testing::TestWithParam<Mode>
{
};

TEST_P(UsbHold, silences_what_plays_by_itself)
{
    constexpr int kTransducers = 249;
    EmulatedArray array({kTransducers, std::vector<int>(kTransducers, 0)});
    const auto open = [](const midair::device::DeviceLayout&)
    {
        return midair::device::openDevice("usb:?hold=300ms",
                                          {kTransducers, std::vector<int>(kTransducers, 0)});
    };
    const auto sounds = [&]
    {
        const midair::device::DriveSignal field = array.playing();
        return std::any_of(
            field.duty.begin(), field.duty.end(), [](std::uint8_t duty) { return duty > 0; });
    };
    const auto show =
        std::filesystem::temp_directory_path() /
        fmt::format("midair-usb-hold-{}-{}", ::getpid(), midair::holds::nameOf(GetParam()));
    EXPECT_EQ(midair::holds::trial(GetParam(), open, kTransducers, show, sounds), "");
    std::filesystem::remove(show);
}

INSTANTIATE_TEST_SUITE_P(Matrix,
                         UsbHold,
                         testing::ValuesIn(midair::holds::allModes()),
                         [](const auto& info) { return midair::holds::nameOf(info.param); });
