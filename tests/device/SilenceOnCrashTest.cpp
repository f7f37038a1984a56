#include "device/SilenceOnCrash.h"

#include "haptics/base/threads/SteadyClock.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
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

// To the children of this process that are called as the guard is.
void signalGuards(int signal)
{
    for (const auto& entry : std::filesystem::directory_iterator("/proc"))
    {
        std::ifstream file(entry.path() / "stat");
        std::string pid;
        std::string name;
        std::string state;
        int parent = 0;
        file >> pid >> name >> state >> parent;
        if (parent == ::getpid() && name == "(midair-guard)") ::kill(std::stoi(pid), signal);
    }
}

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
    Pipe board;
    const pid_t program = ::fork();
    if (program == 0)
    {
        ::setpgid(0, 0);
        const SilenceOnCrash will({board.ends[1], 0}, kSilence);
        ::usleep(100000); // the guard has a group of its own by then, or the signals below reach it
                          // in its first moments
        // Less the two that libc keeps for itself: the thread sanitizer's own thread takes those.
        for (int signal = 1; signal <= SIGRTMAX; ++signal)
            if (signal != SIGKILL && signal != SIGSTOP && (signal <= SIGSYS || signal >= SIGRTMIN))
                signalGuards(signal);
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
