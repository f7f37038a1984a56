#include "device/ArrayDevice.h"
#include "device/simulation/VirtualBoard.h"
#include "tests/Eventually.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device-usb/Host.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <mutex>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

/// An OpenMPD board behind the emulated chip.
struct Board
{
    std::mutex mutex;
    std::unique_ptr<VirtualBoard> board = makeVirtualBoard("openmpd", 256);
    bool sounded = false;
    EmulatedArray chip{[this](const std::uint8_t* bytes, std::size_t count)
                       {
                           std::lock_guard<std::mutex> lock(mutex);
                           board->receive(bytes, count);
                           for (const std::complex<float> q : board->playing())
                               sounded = sounded || std::abs(q) > 0;
                       }};

    bool hasSounded()
    {
        std::lock_guard<std::mutex> lock(mutex);
        return sounded;
    }
    std::uint64_t swaps()
    {
        std::lock_guard<std::mutex> lock(mutex);
        return board->swaps();
    }

    bool plays(const std::vector<std::complex<float>>& wanted)
    {
        std::lock_guard<std::mutex> lock(mutex);
        const auto q = board->playing();
        bool same = q.size() == wanted.size();
        for (std::size_t i = 0; same && i < q.size(); ++i)
            same = std::abs(q[i] - wanted[i]) < 1e-6F; // single precision
        return same;
    }

    bool isSilent() { return plays(std::vector<std::complex<float>>(256)); }
};

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
    EXPECT_TRUE(eventually([&] { return peer.isSilent(); }));
}

TEST(FtdiFifo, is_lost_when_unplugged_and_taken_up_again)
{
    Board peer;
    const auto device = openDevice("openmpd:A0001", {256, {}});
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
    EXPECT_TRUE(eventually([&] { return peer.isSilent(); }));
    ASSERT_TRUE(device->send(randomField(256, 3)));
    EXPECT_TRUE(
        eventually([&] { return device->report().pending == 0 && peer.plays(device->played()); }));
}

TEST(FtdiFifo, names_a_chip_that_is_not_there)
{
    Board peer;
    const std::string error = openError("openmpd:B0002", {256, {}});
    EXPECT_EQ(error.find("FT232H \"B0002\": none is plugged in"), 0U) << error;
}

TEST(FtdiFifo, is_not_taken_by_chance)
{
    EXPECT_NE(openError("openmpd:", {256, {}}).find("no FT232H"), std::string::npos);
    Board peer;
    EXPECT_NE(openError("openmpd:", {256, {}}).find("openmpd:A0001 (free)"), std::string::npos);
    EXPECT_EQ(openError("openmpd:A0001", {256, {}}), "no error");
}

TEST(FtdiFifo, is_silent_after_a_SIGKILL_of_the_host)
{
    Board peer;
    Host host("--fifo-host");
    ASSERT_TRUE(host.waitUntilStopped());
    ASSERT_TRUE(peer.hasSounded());
    host.kill();
    EXPECT_TRUE(eventually([&] { return peer.isSilent(); }));
    // The child that silenced it has ended too: another program can have the board.
    EXPECT_TRUE(eventually([] { return openError("openmpd:A0001", {256, {}}) == "no error"; }));
}

TEST(FtdiFifo, is_silent_while_the_host_is_stopped)
{
    Board peer;
    Host host("--fifo-host");
    ASSERT_TRUE(host.waitUntilStopped());
    ASSERT_TRUE(peer.hasSounded());
    EXPECT_TRUE(eventually([&] { return peer.isSilent(); }));
}

TEST(FtdiFifo, is_written_again_and_again)
{
    Board peer;
    const auto device = openDevice("openmpd:A0001", {256, {}});
    ASSERT_TRUE(device->send(randomField(256, 1)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    const std::uint64_t before = peer.swaps();
    EXPECT_TRUE(eventually([&] { return peer.swaps() >= before + 3; }));
    EXPECT_TRUE(peer.plays(device->played()));
    EXPECT_EQ(device->report().played, 1U);
}

TEST(FtdiFifo, says_that_it_may_play_on_when_it_is_unplugged)
{
    Board peer;
    const auto device = openDevice("openmpd:A0001", {256, {}});
    ASSERT_TRUE(device->send(randomField(256, 1)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    peer.chip.unplug(); // and nothing is sent
    EXPECT_TRUE(eventually(
        [&] { return device->report().message.find("cut its power") != std::string::npos; }))
        << device->report().message;
    EXPECT_EQ(device->report().state, DeviceState::LOST);
}

TEST(FtdiFifo, is_free_for_another_program_as_soon_as_it_is_closed)
{
    Board peer;
    for (unsigned seed = 1; seed < 4; ++seed)
    {
        const auto device = openDevice("openmpd:A0001", {256, {}});
        ASSERT_TRUE(device->send(randomField(256, seed)));
        ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
        const std::string error = openError("openmpd:A0001", {256, {}});
        EXPECT_NE(error.find("another program or the kernel's serial driver uses it"),
                  std::string::npos)
            << error;
    }
    EXPECT_EQ(openError("openmpd:A0001", {256, {}}), "no error");
}
