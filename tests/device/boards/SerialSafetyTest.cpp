#include "device/ArrayDevice.h"
#include "device/SilenceOnCrash.h"
#include "device/boards/BoardDevice.h"
#include "device/boards/BoardKind.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/boards/BoardEmulator.h"

#include <atomic>
#include <chrono>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::device;

// Whether a board is silent when its device says so, and plays what its device says.

namespace
{

constexpr const char* kPlaysOn = "cut its power";

/// An Ultraino board: an Arduino Mega.
struct Mega
{
    BoardEmulator board;

    explicit Mega(bool answers = true) : board("ultraino", 64, {115200, true, 0.05, 1.8, answers})
    {
        board.start();
    }
    std::unique_ptr<ArrayDevice> open() const
    {
        return openDevice("ultraino:" + board.name() + "?settle=700ms", {64, {}});
    }
    bool playsItsOwnPattern()
    {
        return !board.starting() && near(board.playing(), std::vector<std::complex<float>>(64, 1));
    }
};

/// One whose sketch plays a field.
struct PlayingMega : Mega
{
    std::unique_ptr<ArrayDevice> device = open();

    explicit PlayingMega(bool answers = true) : Mega(answers)
    {
        device->send(randomField(64, 1));
        EXPECT_TRUE(eventually([&] { return near(board.playing(), hears()); }));
    }
    static std::vector<std::complex<float>> hears()
    {
        std::vector<std::complex<float>> q;
        makeBoardCodec("ultraino")->played(randomField(64, 1), q);
        return q;
    }
};

struct Sonic
{
    BoardEmulator board{"sonicsurface", 256};
    std::unique_ptr<ArrayDevice> device;

    Sonic()
    {
        board.start();
        device = openDevice("sonicsurface:" + board.name(), {256, {}});
    }
    bool plays()
    {
        return device->send(randomField(256, 1)) &&
               eventually([&] { return device->report().played == 1; }) &&
               eventually([&] { return near(board.playing(), device->played()); });
    }
};

} // namespace

TEST(EmulatedMega, starts_its_own_pattern_by_itself)
{
    Mega mega;
    ::close(::open(mega.board.name().c_str(), O_RDWR | O_NOCTTY));
    const int port = ::open(mega.board.name().c_str(), O_RDWR | O_NOCTTY);
    ASSERT_TRUE(eventually([&] { return mega.board.resets() > 0; }));
    EXPECT_TRUE(eventually([&] { return mega.playsItsOwnPattern(); }));
    ::close(port);
}

TEST(EmulatedMega, stays_in_its_bootloader_while_bytes_arrive)
{
    Mega mega;
    const int port = ::open(mega.board.name().c_str(), O_RDWR | O_NOCTTY);
    ASSERT_TRUE(eventually([&] { return mega.board.resets() == 1; }));
    // Where the first byte comes too late, since the machine is busy, it is switched on again.
    double since_s = midair::base::steadySeconds();
    EXPECT_TRUE(eventually(
        [&]
        {
            if (!mega.board.starting())
            {
                mega.board.powerCycle();
                since_s = midair::base::steadySeconds();
            }
            mega.board.inject(1);
            return midair::base::steadySeconds() >= since_s + 0.6 && mega.board.eaten() > 10;
        }));
    EXPECT_TRUE(eventually([&] { return mega.playsItsOwnPattern(); }));
    ::close(port);
}

TEST(Mega, is_silenced_after_its_bootloader_and_then_plays)
{
    Mega mega;
    const double opened_s = midair::base::steadySeconds();
    const auto device = mega.open();
    const std::string status = device->status();
    // A busy machine may take longer than the board does.
    if (midair::base::steadySeconds() - opened_s < 0.6)
    {
        EXPECT_NE(status.find("starting"), std::string::npos) << status;
    }
    ASSERT_TRUE(device->send(randomField(64, 1))); // waits
    ASSERT_TRUE(device->send(randomField(64, 2)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    EXPECT_EQ(device->report().dropped, 1U);
    EXPECT_TRUE(eventually([&] { return near(mega.board.playing(), device->played()); }));
    EXPECT_EQ(mega.board.eaten(), 0U);
    EXPECT_EQ(device->status().find("starting"), std::string::npos) << device->status();
    device->silence();
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
}

TEST(Mega, is_waited_for_by_default)
{
    BoardEmulator board("ultraino", 64, {115200, true, 1.0, 6.5}); // as it is in truth
    board.start();
    openDevice("ultraino:" + board.name(), {64, {}});
    EXPECT_FALSE(board.starting());
    EXPECT_TRUE(eventually([&] { return board.silentInBothBuffers(); }));
    EXPECT_EQ(board.eaten(), 0U);
}

TEST(Mega, is_silent_after_a_mute_that_opens_and_closes)
{
    Mega mega;
    mega.open()->setMuted(true);
    // It has waited for the sketch, which would have begun to play after it had gone.
    EXPECT_FALSE(mega.board.starting());
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
    EXPECT_EQ(mega.board.eaten(), 0U);
}

TEST(Mega, isnt_reset_when_it_is_opened_again)
{
    Mega mega;
    mega.open();
    ASSERT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
    ASSERT_TRUE(eventually([&] { return !mega.board.isOpened(); }));
    mega.open();
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
    EXPECT_EQ(mega.board.resets(), 1);
}

TEST(Mega, is_silenced_after_its_bootloader_when_it_comes_back)
{
    Mega mega;
    const auto device = mega.open();
    ASSERT_TRUE(device->send(randomField(64, 1)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    mega.board.unplug();
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::LOST; }));
    EXPECT_FALSE(device->send(randomField(64, 2)));
    mega.board.plug();
    ASSERT_TRUE(eventually([&] { return mega.board.resets() == 2; }));
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
    EXPECT_EQ(mega.board.eaten(), 0U);
    EXPECT_EQ(device->report().reconnects, 1U);
}

// By its button: the bootloader would take the repeats for a reason to stay, and start the pattern
// when they end.
TEST(Mega, is_left_to_its_bootloader_and_silenced_when_it_is_reset)
{
    PlayingMega mega;
    mega.board.powerCycle();
    mega.board.inject(1); // the bootloader has a byte in its first moment
    ASSERT_TRUE(eventually([&] { return mega.device->report().faults == 1; }));
    EXPECT_NE(mega.device->report().message.find("bootloader"), std::string::npos);
    EXPECT_GT(mega.board.eaten(), 0U);
    ASSERT_TRUE(eventually([&] { return mega.device->report().state == DeviceState::READY; }));
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
    ASSERT_TRUE(mega.device->send(randomField(64, 1)));
    EXPECT_TRUE(eventually([&] { return near(mega.board.playing(), mega.hears()); }));
}

TEST(Mega, is_silent_after_a_closing_while_its_bootloader_listens)
{
    PlayingMega mega;
    mega.board.powerCycle();
    mega.board.inject(1); // the bootloader has a byte in its first moment
    mega.device.reset();
    EXPECT_FALSE(mega.board.starting()); // so nothing begins after it has gone
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
}

TEST(Mega, plays_also_where_its_answers_dont_arrive)
{
    PlayingMega mega(false);
    ASSERT_TRUE(eventually([&] { return mega.device->report().reconnects == 1; })); // once lost
    ASSERT_TRUE(mega.device->send(randomField(64, 1)));
    EXPECT_TRUE(eventually([&] { return near(mega.board.playing(), mega.hears()); }));
    mega.device.reset();
    EXPECT_TRUE(eventually([&] { return mega.board.silentInBothBuffers(); }));
}

TEST(SonicSurfaceBoard, has_its_field_back_after_damaged_bytes)
{
    Sonic sonic;
    ASSERT_TRUE(sonic.plays());
    for (const std::uint8_t noise : {253, 150, 193, 254, 7})
    {
        sonic.board.inject(noise);
        sonic.board.damage(100); // and a delay of the next repeat
        const std::uint64_t before = sonic.board.swaps();
        EXPECT_TRUE(eventually([&] { return sonic.board.swaps() > before + 1; }));
        EXPECT_TRUE(eventually([&] { return near(sonic.board.playing(), sonic.device->played()); }))
            << int(noise);
    }
    EXPECT_EQ(sonic.device->report().played, 1U); // repeats aren't counted
    EXPECT_EQ(sonic.device->report().sent, 1U);
}

TEST(SonicSurfaceBoard, has_its_field_back_after_its_power_was_cut)
{
    Sonic sonic;
    ASSERT_TRUE(sonic.plays());
    sonic.board.powerCycle();
    EXPECT_TRUE(eventually([&] { return near(sonic.board.playing(), sonic.device->played()); }));
}

TEST(SonicSurfaceBoard, has_its_silence_back_after_its_power_was_cut)
{
    Sonic sonic;
    ASSERT_TRUE(eventually([&] { return sonic.board.silent(); }));
    sonic.board.powerCycle();
    EXPECT_TRUE(eventually([&] { return sonic.board.silent(); }));
}

TEST(SonicSurfaceBoard, is_lost_without_anything_being_sent)
{
    Sonic sonic;
    ASSERT_TRUE(sonic.plays());
    const auto field = sonic.device->played();
    sonic.board.unplug();
    ASSERT_TRUE(eventually([&] { return sonic.device->report().state == DeviceState::LOST; }));
    ASSERT_TRUE(eventually(
        [&] { return sonic.device->report().message.find(kPlaysOn) != std::string::npos; }))
        << sonic.device->report().message;
    EXPECT_FALSE(sonic.board.silent());
    sonic.device->silence(); // nobody hears it
    EXPECT_TRUE(near(sonic.device->played(), field));
    sonic.board.plug();
    ASSERT_TRUE(eventually([&] { return sonic.device->report().state == DeviceState::READY; }));
    EXPECT_TRUE(eventually([&] { return sonic.board.silent(); }));
    EXPECT_EQ(sonic.device->played(), std::vector<std::complex<float>>(256));
}

TEST(SonicSurfaceBoard, is_refused_to_a_second_program)
{
    Sonic sonic; // also to root, whom TIOCEXCL doesn't stop
    std::string text = "no error";
    try
    {
        openDevice("ultraino:" + sonic.board.name(), {64, {}});
    }
    catch (const DeviceError& error)
    {
        text = error.what();
    }
    EXPECT_EQ(text, "serial port \"" + sonic.board.name() + "\": another program has it");
}

namespace
{

/// A way to a board that this process can't write to any more, while its guard can.
class BrokenSink : public ByteSink
{
public:
    BrokenSink(int end,
               const std::vector<std::uint8_t>& lastWill,
               const std::atomic<bool>& broken) :
        _end(end),
        _broken(broken)
    {
        _lastWill = std::make_unique<SilenceOnCrash>(SilenceOnCrash::Way{end, 0}, lastWill);
    }
    bool write(const std::vector<std::uint8_t>& bytes) override
    {
        _error = "broken";
        return !_broken &&
               ::write(_end, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
    }

private:
    const int _end;
    const std::atomic<bool>& _broken;
};

} // namespace

TEST(BoardDevice, lets_the_guard_silence_what_it_cant_silence_itself)
{
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_NONBLOCK), 0);
    const auto virtualBoard = makeVirtualBoard("sonicsurface", 256);
    const auto drain = [&]
    {
        std::uint8_t bytes[4096];
        for (ssize_t count = 0; (count = ::read(ends[0], bytes, sizeof bytes)) > 0;)
            virtualBoard->receive(bytes, static_cast<std::size_t>(count));
        const auto q = virtualBoard->playing();
        return q == std::vector<std::complex<float>>(256);
    };
    std::atomic<bool> broken{false};
    {
        BoardDevice device(
            "sonicsurface:test",
            makeBoardCodec("sonicsurface"),
            256,
            [&](const std::vector<std::uint8_t>& lastWill) -> std::unique_ptr<ByteSink>
            {
                if (broken) throw DeviceError("gone");
                return std::make_unique<BrokenSink>(ends[1], lastWill, broken);
            });
        ASSERT_TRUE(device.send(randomField(256, 1)));
        ASSERT_TRUE(eventually([&] { return device.report().played == 1 && !drain(); }));
        broken = true;
        ASSERT_TRUE(eventually([&] { return drain(); }));
        ASSERT_TRUE(eventually(
            [&]
            { return device.report().message.find("silence was written") != std::string::npos; }));
        EXPECT_EQ(device.report().message.find("broken; "), 0U) << device.report().message;
        EXPECT_EQ(device.report().state, DeviceState::LOST);
        EXPECT_EQ(device.played(), std::vector<std::complex<float>>(256));
    }
    for (const int end : ends)
        ::close(end);
}
