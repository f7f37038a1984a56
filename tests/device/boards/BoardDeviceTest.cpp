#include "device/ArrayDevice.h"
#include "device/boards/BoardKind.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"
#include "tests/device/boards/BoardEmulator.h"

#include <cerrno>
#include <cstring>

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

using namespace midair::device;

class SerialBoard : public ::testing::TestWithParam<std::pair<const char*, int>>
{
protected:
    void SetUp() override
    {
        int master = -1;
        int slave = -1;
        if (::openpty(&master, &slave, nullptr, nullptr, nullptr) != 0)
            GTEST_SKIP() << "there are no pseudo-terminals here: " << std::strerror(errno);
        ::close(master);
        ::close(slave);
    }
    // Without its bootloader, which has tests of its own.
    std::string uri(const BoardEmulator& board) const
    {
        return kind + ":" + board.name() + (kind == "ultraino" ? "?settle=0s" : "");
    }
    BoardEmulator::Options options() const
    {
        BoardEmulator::Options options;
        options.baud = kind == "ultraino" ? 115200 : 230400;
        return options;
    }
    const std::string kind = GetParam().first;
    const int transducers = GetParam().second;
};

TEST_P(SerialBoard, plays_what_it_is_sent_through_a_serial_port)
{
    BoardEmulator terminal(kind, transducers, options());
    terminal.start();
    const auto device = openDevice(uri(terminal), {transducers, {}});
    EXPECT_EQ(device->ability().phaseLevels, kind == "ultraino" ? 10 : 32);
    for (unsigned seed = 1; seed < 4; ++seed)
    {
        ASSERT_TRUE(device->send(randomField(transducers, seed)));
        ASSERT_TRUE(eventually([&] { return device->report().played == seed; }));
        ASSERT_TRUE(eventually([&] { return near(terminal.playing(), device->played()); }));
        EXPECT_FALSE(terminal.silent());
    }
    device->silence();
    EXPECT_TRUE(eventually([&] { return terminal.silent(); }));
}

TEST_P(SerialBoard, drops_fields_that_come_too_fast_for_the_line)
{
    BoardEmulator terminal(kind, transducers, options());
    terminal.start();
    const auto device = openDevice(uri(terminal), {transducers, {}});
    for (int i = 0; i < 100; ++i)
        ASSERT_TRUE(device->send(evenField(transducers, static_cast<std::uint8_t>(2 * i), 255)));
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    const DeviceReport report = device->report();
    EXPECT_GT(report.dropped, 0U);
    EXPECT_EQ(report.sent, report.played + report.dropped);
    EXPECT_TRUE(eventually([&] { return near(terminal.playing(), device->played()); }));
    std::vector<std::complex<float>> newest;
    makeBoardCodec(kind)->played(evenField(transducers, 198, 255), newest);
    EXPECT_TRUE(near(device->played(), newest));
}

TEST_P(SerialBoard, is_silent_after_closing)
{
    BoardEmulator terminal(kind, transducers, options());
    terminal.start();
    auto device = openDevice(uri(terminal), {transducers, {}});
    ASSERT_TRUE(device->send(randomField(transducers, 1)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    ASSERT_TRUE(eventually([&] { return near(terminal.playing(), device->played()); }));
    device.reset();
    EXPECT_TRUE(eventually([&] { return terminal.silent(); }));
}

TEST_P(SerialBoard, is_lost_when_unplugged)
{
    auto terminal = std::make_unique<BoardEmulator>(kind, transducers, options());
    terminal->start();
    const auto device = openDevice(uri(*terminal), {transducers, {}});
    ASSERT_TRUE(device->send(evenField(transducers, 0, 255)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    terminal->unplug();
    ASSERT_TRUE(eventually(
        [&]
        {
            device->send(evenField(transducers, 0, 255));
            return device->report().state == DeviceState::LOST;
        }));
    EXPECT_FALSE(device->send(evenField(transducers, 0, 255)));
    EXPECT_NE(device->report().message, "");
    const DeviceReport report = device->report();
    EXPECT_EQ(report.sent,
              report.played + report.dropped + report.lost + report.refused + report.pending);
}

INSTANTIATE_TEST_SUITE_P(Boards,
                         SerialBoard,
                         ::testing::Values(std::make_pair("sonicsurface", 256),
                                           std::make_pair("ultraino", 128)),
                         [](const auto& board) { return std::string(board.param.first); });

TEST(BoardDevice, names_what_keeps_it_from_opening)
{
    EXPECT_EQ(
        openError("sonicsurface:", {256, {}}),
        "device \"sonicsurface:\": the name of a serial port is missing: \"sonicsurface:NAME\"");
    EXPECT_EQ(openError("sonicsurface:/dev/null", {100, {}}),
              "device \"sonicsurface:/dev/null\": a sonicsurface has 256 transducers, but the "
              "array has 100");
    EXPECT_EQ(openError("ultraino:/dev/null", {100, {}}),
              "device \"ultraino:/dev/null\": a ultraino has 64 transducers a board, 1 to 14 "
              "boards, but the array has 100");
    EXPECT_EQ(openError("sonicsurface:/dev/ttyNONE", {256, {}}),
              "serial port \"/dev/ttyNONE\": can't be opened: No such file or directory");
    EXPECT_EQ(openError("sonicsurface:/dev/null", {256, {}}),
              "serial port \"/dev/null\": isn't a serial port: Inappropriate ioctl for device");
    EXPECT_EQ(openError("sonicsurface:/dev/null?baud=7", {256, {}}),
              "device \"sonicsurface:/dev/null?baud=7\": baud=7 should be 9600, 57600, 115200, "
              "230400, 460800 "
              "or 921600");
    EXPECT_NE(
        openError("sonicsurface:/dev/null?baud=12345", {256, {}}).find("should be 9600, 57600"),
        std::string::npos);
}
