#include "device/SilenceOnCrash.h"

#include "haptics/base/threads/SteadyClock.h"
#include "tests/Emulator.h"
#include "tests/Eventually.h"
#include "tests/device/Guards.h"

#include <csignal>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

const std::vector<std::uint8_t> kSilence = {1, 2, 3};

/// A pipe whose ends are closed in the end, or before.
struct Pipe
{
    int ends[2] = {-1, -1};

    Pipe() { EXPECT_EQ(::pipe(ends), 0); }
    ~Pipe()
    {
        ::close(ends[0]);
        closeIn();
    }
    void closeIn()
    {
        if (ends[1] >= 0) ::close(ends[1]);
        ends[1] = -1;
    }
    /// All bytes until nobody holds the end for writing; a deadline only stops a test that fails.
    bool readToEnd(std::vector<std::uint8_t>& bytes)
    {
        std::uint8_t buffer[64];
        pollfd wait{ends[0], POLLIN, 0};
        while (::poll(&wait, 1, 20000) == 1)
        {
            const ssize_t count = ::read(ends[0], buffer, sizeof buffer);
            if (count <= 0) return count == 0;
            bytes.insert(bytes.end(), buffer, buffer + count);
        }
        return false;
    }
};

} // namespace

TEST(SilenceOnCrash, is_written_when_the_program_dies)
{
    Pipe board;
    const pid_t program = ::fork();
    if (program == 0)
    {
        const SilenceOnCrash will({board.ends[1], 0}, kSilence);
        ::raise(SIGKILL);
    }
    ::waitpid(program, nullptr, 0);
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes)); // so the child has ended too
    EXPECT_EQ(bytes, kSilence);
}

TEST(SilenceOnCrash, is_not_written_after_a_farewell)
{
    Pipe board;
    {
        const SilenceOnCrash will({board.ends[1], 0}, kSilence);
    }
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_TRUE(bytes.empty());
}

TEST(SilenceOnCrash, holds_nothing_of_the_program_but_the_board)
{
    Pipe before;
    Pipe board;
    Pipe after;
    const SilenceOnCrash will({board.ends[1], 0}, kSilence);
    std::vector<std::uint8_t> bytes;
    before.closeIn();
    after.closeIn();
    EXPECT_TRUE(before.readToEnd(bytes));
    EXPECT_TRUE(after.readToEnd(bytes));
}

TEST(SilenceOnCrash, is_written_when_the_program_stops_giving_signs_of_life)
{
    Pipe board;
    SilenceOnCrash will({board.ends[1], 0}, kSilence);
    will.beat();
    std::uint8_t bytes[3] = {};
    EXPECT_EQ(::read(board.ends[0], bytes, sizeof bytes), 3);
    EXPECT_EQ(std::vector<std::uint8_t>(bytes, bytes + 3), kSilence);
    EXPECT_EQ(::read(board.ends[0], bytes, sizeof bytes), 3); // again, as long as that lasts
}

// Or a killall of the program's name would end a guard that has just begun.
TEST(SilenceOnCrash, has_its_own_name_before_the_program_goes_on)
{
    for (int i = 0; i < 20; ++i)
    {
        Pipe board;
        const SilenceOnCrash will({board.ends[1], 0}, kSilence);
        EXPECT_EQ(guardsOf(::getpid()).size(), 1U);
    }
}

// A stopped program's silence is repeated, twice a second. Each drops what the program had left in
// the port, but not the silence before it, or a slow line would never carry a whole one.
TEST(SilenceOnCrash, is_not_cut_off_by_its_repetition)
{
    const int line = ::posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_TRUE(line >= 0 && ::grantpt(line) == 0 && ::unlockpt(line) == 0);
    const int port = ::open(::ptsname(line), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios raw{};
    ::tcgetattr(port, &raw);
    ::cfmakeraw(&raw);
    ASSERT_EQ(::tcsetattr(port, TCSANOW, &raw), 0);
    std::vector<std::uint8_t> silence(10000); // more than a terminal's 4096 bytes
    for (std::size_t i = 0; i < silence.size(); ++i)
        silence[i] = static_cast<std::uint8_t>(i % 251);
    {
        SilenceOnCrash will({port, 0}, silence);
        will.beat();
        letPass(1.3); // written twice by now
    }
    std::vector<std::uint8_t> bytes(silence.size());
    for (std::size_t done = 0; done < bytes.size();)
    {
        const ssize_t count = ::read(line, bytes.data() + done, bytes.size() - done);
        ASSERT_GT(count, 0);
        done += static_cast<std::size_t>(count);
    }
    EXPECT_EQ(bytes, silence);
    ::close(port);
    ::close(line);
}

TEST(SilenceOnCrash, is_written_on_request)
{
    Pipe board;
    SilenceOnCrash will({board.ends[1], 0}, kSilence);
    will.beat();
    EXPECT_TRUE(will.execute());
    EXPECT_FALSE(will.execute()); // nobody is there any more
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_EQ(bytes, kSilence);
}

TEST(SilenceOnCrash, tells_when_it_cant_be_written)
{
    Pipe board;
    SilenceOnCrash will({board.ends[0], 0}, kSilence); // the end to read from
    EXPECT_FALSE(will.execute());
}

TEST(SilenceOnCrash, waits_until_the_board_takes_it)
{
    Pipe board;
    const double notBefore_s = midair::base::steadySeconds() + 0.3;
    SilenceOnCrash will({board.ends[1], 0}, kSilence, notBefore_s);
    EXPECT_TRUE(will.execute());
    EXPECT_GE(midair::base::steadySeconds(), notBefore_s);
}

TEST(SilenceOnCrash, waits_for_a_board_that_is_held_in_its_bootloader)
{
    Pipe board;
    SilenceOnCrash will({board.ends[1], 0}, kSilence, 0, 0.3);
    const double held_s = midair::base::steadySeconds();
    will.beat(true);
    EXPECT_TRUE(will.execute());
    EXPECT_GE(midair::base::steadySeconds(), held_s + 0.3);
}

TEST(SilenceOnCrash, takes_no_signals)
{
    if (emulatorOfTests() != nullptr)
        GTEST_SKIP() << "the emulator acts on some signals, whatever its program blocks";
    Pipe board;
    const pid_t program = ::fork();
    if (program == 0)
    {
        ::setpgid(0, 0);
        const SilenceOnCrash will({board.ends[1], 0}, kSilence);
        // Less the two that libc keeps for itself: the thread sanitizer's own thread takes those.
        for (int signal = 1; signal <= SIGRTMAX; ++signal)
            if (signal != SIGKILL && signal != SIGSTOP && (signal <= SIGSYS || signal >= SIGRTMIN))
                for (const pid_t guard : guardsOf(::getpid()))
                    ::kill(guard, signal);
        ::raise(SIGKILL);
    }
    ::waitpid(program, nullptr, 0);
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_EQ(bytes, kSilence);
}

TEST(SilenceOnCrash, gives_up_where_the_descriptor_takes_nothing)
{
    Pipe board; // no device of usbfs
    const pid_t program = ::fork();
    if (program == 0)
    {
        const SilenceOnCrash will({board.ends[1], 2}, kSilence);
        ::raise(SIGKILL);
    }
    ::waitpid(program, nullptr, 0);
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_TRUE(bytes.empty());
}
