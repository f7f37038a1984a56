#include "device/ArrayDevice.h"
#include "device/boards/BoardKind.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/boards/BoardEmulator.h"
#include "tests/device/boards/BoardHost.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::device;

// What a board does when the program that plays on it can't do anything any more.

namespace
{

std::vector<std::complex<float>> hostsField(const std::string& board, int transducers)
{
    std::vector<std::complex<float>> q;
    makeBoardCodec(board)->played(randomField(transducers, 1), q);
    return q;
}

bool has(const char* program)
{
    return std::system((std::string("command -v ") + program + " > /dev/null").c_str()) == 0;
}

} // namespace

TEST(BoardHost, DISABLED_plays_until_it_is_ended)
{
    const char* uri = std::getenv("MIDAIR_TEST_HOST");
    if (uri == nullptr) GTEST_SKIP() << "is run by other tests";
    const int transducers = std::atoi(std::getenv("MIDAIR_TEST_HOST_TRANSDUCERS"));
    const auto device = openDevice(uri, {transducers, {}});
    const DriveSignal field = randomField(transducers, 1);
    DriveSignal off = field;
    std::fill(off.duty.begin(), off.duty.end(), std::uint8_t(0));
    if (std::getenv("MIDAIR_TEST_HOST_MODULATED") == std::string("yes"))
        device->sendSequence({{field, off}, 400.0});
    else
        device->send(field);
    while (true)
        ::pause();
}

class BoardGuard : public ::testing::TestWithParam<std::pair<const char*, int>>
{
protected:
    void SetUp() override { begin(false); }
    void begin(bool isModulated)
    {
        board.start();
        host = std::make_unique<BoardHost>(
            kind + ":" + board.name() + "?settle=0s", transducers, isModulated);
        ASSERT_TRUE(eventually([&] { return near(board.playing(), field); }));
    }
    bool silencesBothBuffers()
    {
        return eventually([&] { return board.silentInBothBuffers(); });
    }
    const std::string kind = GetParam().first;
    const int transducers = GetParam().second;
    const std::vector<std::complex<float>> field = hostsField(kind, transducers);
    BoardEmulator board{kind, transducers, {kind == "ultraino" ? 115200 : 230400}};
    std::unique_ptr<BoardHost> host;
};

TEST_P(BoardGuard, silences_when_the_program_is_killed)
{
    host->send(SIGKILL);
    EXPECT_TRUE(silencesBothBuffers());
}

TEST_P(BoardGuard, silences_while_the_program_is_stopped)
{
    host->send(SIGSTOP);
    EXPECT_TRUE(silencesBothBuffers());
    host->send(SIGCONT);
    EXPECT_TRUE(eventually([&] { return near(board.playing(), field); }));
    host->send(SIGSTOP);
    EXPECT_TRUE(eventually([&] { return board.silent(); }));
    host->send(SIGKILL);
    EXPECT_TRUE(silencesBothBuffers());
}

TEST_P(BoardGuard, survives_those_who_end_the_program_by_its_name)
{
    if (!has("killall")) GTEST_SKIP() << "psmisc isn't installed";
    ASSERT_EQ(std::system(("killall -KILL " + host->name).c_str()), 0);
    EXPECT_TRUE(silencesBothBuffers());
}

TEST_P(BoardGuard, survives_those_who_end_the_program_by_its_command_line)
{
    if (!has("pkill")) GTEST_SKIP() << "procps isn't installed";
    if (emulatorOfTests() != nullptr)
        GTEST_SKIP() << "the command line is the emulator's, which its program can't change";
    // Not to be found in the command line of the shell.
    const std::string pattern = "[" + host->name.substr(0, 1) + "]" + host->name.substr(1);
    ASSERT_EQ(std::system(("pkill -KILL -f '" + pattern + "'").c_str()), 0);
    EXPECT_TRUE(silencesBothBuffers());
}

TEST_P(BoardGuard, leaves_the_port_to_the_next_program)
{
    host->send(SIGKILL);
    EXPECT_TRUE(eventually(
        [&]
        {
            try
            {
                openDevice(kind + ":" + board.name() + "?settle=0s", {transducers, {}});
                return true;
            }
            catch (const DeviceError& error)
            {
                EXPECT_NE(std::string(error.what()).find("another program has it"),
                          std::string::npos)
                    << error.what();
                return false;
            }
        }));
}

/// The same while the board, or the line that is written ahead, modulates by itself.
class BoardGuardOfAModulation : public BoardGuard
{
protected:
    void SetUp() override { begin(true); }
    void TearDown() override { EXPECT_GT(board.swaps(), 0U); }
};

TEST_P(BoardGuardOfAModulation, silences_when_the_program_is_killed)
{
    host->send(SIGKILL);
    EXPECT_TRUE(silencesBothBuffers());
}

TEST_P(BoardGuardOfAModulation, silences_while_the_program_is_stopped)
{
    host->send(SIGSTOP);
    EXPECT_TRUE(silencesBothBuffers());
    host->send(SIGCONT);
    EXPECT_TRUE(eventually([&] { return near(board.playing(), field); }));
    host->send(SIGKILL);
    EXPECT_TRUE(silencesBothBuffers());
}

INSTANTIATE_TEST_SUITE_P(Boards,
                         BoardGuardOfAModulation,
                         ::testing::Values(std::make_pair("sonicsurface", 256),
                                           std::make_pair("ultraino", 64)),
                         [](const auto& board) { return std::string(board.param.first); });

INSTANTIATE_TEST_SUITE_P(Boards,
                         BoardGuard,
                         ::testing::Values(std::make_pair("sonicsurface", 256),
                                           std::make_pair("ultraino", 64)),
                         [](const auto& board) { return std::string(board.param.first); });

TEST(BoardGuardOfAMega, waits_for_the_bootloader)
{
    BoardEmulator board("ultraino", 64, {115200, true});
    board.start();
    BoardHost host("ultraino:" + board.name() + "?settle=500ms", 64);
    ASSERT_TRUE(eventually([&] { return board.resets() == 1 && host.guarded(); }));
    host.send(SIGKILL); // before anything was written
    EXPECT_TRUE(eventually([&] { return board.silentInBothBuffers(); }));
    EXPECT_EQ(board.eaten(), 0U);
}
