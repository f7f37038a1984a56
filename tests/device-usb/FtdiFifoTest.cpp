#include "../device/Fields.h"
#include "EmulatedArray.h"
#include "device/ArrayDevice.h"
#include "device/VirtualBoard.h"

#include <functional>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

/// An OpenMPD board behind the emulated chip.
struct Board
{
    std::mutex mutex;
    std::unique_ptr<VirtualBoard> board = makeVirtualBoard("openmpd", 256);
    EmulatedArray chip{[this](const std::uint8_t* bytes, std::size_t count)
                       {
                           std::lock_guard<std::mutex> lock(mutex);
                           board->receive(bytes, count);
                       }};

    bool plays(const std::vector<std::complex<float>>& wanted)
    {
        std::lock_guard<std::mutex> lock(mutex);
        const auto q = board->playing();
        bool same = q.size() == wanted.size();
        for (std::size_t i = 0; same && i < q.size(); ++i)
            same = std::abs(q[i] - wanted[i]) < 1e-6F; // single precision
        return same;
    }
};

bool eventually(const std::function<bool()>& condition)
{
    for (int i = 0; i < 5000 && !condition(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return condition();
}

std::string openError(const std::string& uri)
{
    try
    {
        openDevice(uri, {256, {}});
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

TEST(FtdiFifo, carries_fields_to_an_OpenMPD_board)
{
    Board peer;
    auto device = openDevice("openmpd:A0001", {256, {}});
    EXPECT_EQ(device->ability().phaseLevels, 128);
    for (unsigned seed = 1; seed < 4; ++seed)
    {
        ASSERT_TRUE(device->send(randomField(256, seed)));
        ASSERT_TRUE(eventually([&] { return device->report().played == seed; }));
        EXPECT_TRUE(eventually([&] { return peer.plays(device->played()); }));
    }
    device.reset();
    EXPECT_TRUE(eventually([&] { return peer.plays(std::vector<std::complex<float>>(256)); }));
}

TEST(FtdiFifo, is_lost_when_unplugged_and_taken_up_again)
{
    Board peer;
    const auto device = openDevice("openmpd:", {256, {}});
    ASSERT_TRUE(device->send(randomField(256, 1)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    peer.chip.unplug();
    ASSERT_TRUE(eventually(
        [&]
        {
            device->send(randomField(256, 2));
            return device->report().state == DeviceState::LOST;
        }));
    peer.chip.plug();
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
    EXPECT_TRUE(eventually([&] { return peer.plays(std::vector<std::complex<float>>(256)); }));
    ASSERT_TRUE(device->send(randomField(256, 3)));
    EXPECT_TRUE(
        eventually([&] { return device->report().pending == 0 && peer.plays(device->played()); }));
}

TEST(FtdiFifo, names_a_chip_that_is_not_there)
{
    Board peer;
    const std::string error = openError("openmpd:B0002");
    EXPECT_EQ(error.find("FT232H \"B0002\": none is plugged in"), 0U) << error;
}
