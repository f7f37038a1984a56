#include "device/LastWill.h"

#include <csignal>

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

} // namespace

TEST(LastWill, is_written_when_the_program_dies)
{
    Pipe board;
    const pid_t program = ::fork();
    if (program == 0)
    {
        const LastWill will({board.ends[1], 0}, kSilence);
        ::raise(SIGKILL);
    }
    ::waitpid(program, nullptr, 0);
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes)); // so the child has ended too
    EXPECT_EQ(bytes, kSilence);
}

TEST(LastWill, is_not_written_after_a_farewell)
{
    Pipe board;
    {
        const LastWill will({board.ends[1], 0}, kSilence);
    }
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_TRUE(bytes.empty());
}

TEST(LastWill, holds_nothing_of_the_program_but_the_board)
{
    Pipe before;
    Pipe board;
    Pipe after;
    const LastWill will({board.ends[1], 0}, kSilence);
    std::vector<std::uint8_t> bytes;
    before.closeIn();
    after.closeIn();
    EXPECT_TRUE(before.readToEnd(bytes));
    EXPECT_TRUE(after.readToEnd(bytes));
}

TEST(LastWill, gives_up_where_the_descriptor_takes_nothing)
{
    Pipe board; // no device of usbfs
    const pid_t program = ::fork();
    if (program == 0)
    {
        const LastWill will({board.ends[1], 2}, kSilence);
        ::raise(SIGKILL);
    }
    ::waitpid(program, nullptr, 0);
    board.closeIn();
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(board.readToEnd(bytes));
    EXPECT_TRUE(bytes.empty());
}
