#include "Fields.h"
#include "device/ArrayDevice.h"
#include "device/BoardCodec.h"
#include "device/VirtualBoard.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

bool eventually(const std::function<bool()>& condition, double seconds = 10)
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition())
    {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

/// A board at the other end of a pseudo-terminal.
class Terminal
{
public:
    Terminal(const std::string& board, int transducers) :
        _board(makeVirtualBoard(board, transducers))
    {
        char path[128] = {};
        if (::openpty(&_master, &_slave, path, nullptr, nullptr) != 0)
            throw std::runtime_error("no pseudo-terminal");
        name = path;
    }
    ~Terminal() { unplug(); }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    void start()
    {
        _thread = std::thread([this] { read(); });
    }
    void unplug()
    {
        _stop = true;
        if (_thread.joinable()) _thread.join();
        for (int* end : {&_master, &_slave})
            if (*end >= 0) ::close(std::exchange(*end, -1));
    }
    void read()
    {
        std::uint8_t bytes[512];
        while (!_stop)
        {
            pollfd wait{_master, POLLIN, 0};
            if (::poll(&wait, 1, 10) <= 0 || (wait.revents & POLLIN) == 0) continue;
            const ssize_t count = ::read(_master, bytes, sizeof bytes);
            std::lock_guard<std::mutex> lock(_mutex);
            if (count > 0) _board->receive(bytes, static_cast<std::size_t>(count));
        }
    }
    std::vector<std::complex<float>> playing()
    {
        std::lock_guard<std::mutex> lock(_mutex);
        return _board->playing();
    }
    bool silent()
    {
        for (const std::complex<float> q : playing())
            if (std::abs(q) > 0) return false;
        return true;
    }

    std::string name;

private:
    std::unique_ptr<VirtualBoard> _board;
    std::mutex _mutex;
    int _master = -1;
    int _slave = -1;
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

bool near(const std::vector<std::complex<float>>& a, const std::vector<std::complex<float>>& b)
{
    bool same = a.size() == b.size();
    for (std::size_t i = 0; same && i < a.size(); ++i)
        same = std::abs(a[i] - b[i]) < 1e-6F; // single precision
    return same;
}

std::string openError(const std::string& uri, int transducers)
{
    try
    {
        openDevice(uri, {transducers, {}});
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

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
    const std::string kind = GetParam().first;
    const int transducers = GetParam().second;
};

TEST_P(SerialBoard, plays_what_it_is_sent_through_a_serial_port)
{
    Terminal terminal(kind, transducers);
    terminal.start();
    const auto device = openDevice(kind + ":" + terminal.name, {transducers, {}});
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
    Terminal terminal(kind, transducers);
    terminal.start();
    const auto device = openDevice(kind + ":" + terminal.name, {transducers, {}});
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
    Terminal terminal(kind, transducers);
    terminal.start();
    auto device = openDevice(kind + ":" + terminal.name, {transducers, {}});
    ASSERT_TRUE(device->send(evenField(transducers, 0, 255)));
    ASSERT_TRUE(eventually([&] { return !terminal.silent(); }));
    device.reset();
    EXPECT_TRUE(eventually([&] { return terminal.silent(); }));
}

TEST_P(SerialBoard, is_silent_after_a_SIGKILL_of_the_host)
{
    Terminal terminal(kind, transducers);
    const pid_t host = ::fork();
    if (host == 0)
    {
        const auto device = openDevice(kind + ":" + terminal.name, {transducers, {}});
        device->send(evenField(transducers, 0, 255));
        ::pause();
        ::_exit(0);
    }
    terminal.start();
    ASSERT_TRUE(eventually([&] { return !terminal.silent(); }));
    ::kill(host, SIGKILL);
    ::waitpid(host, nullptr, 0);
    EXPECT_TRUE(eventually([&] { return terminal.silent(); }));
}

TEST_P(SerialBoard, is_lost_when_unplugged)
{
    auto terminal = std::make_unique<Terminal>(kind, transducers);
    terminal->start();
    const auto device = openDevice(kind + ":" + terminal->name, {transducers, {}});
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
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(device->played().size()));
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
        openError("sonicsurface:", 256),
        "device \"sonicsurface:\": the name of a serial port is missing: \"sonicsurface:NAME\"");
    EXPECT_EQ(openError("sonicsurface:/dev/null", 100),
              "device \"sonicsurface:/dev/null\": a sonicsurface has 256 transducers, but the "
              "array has 100");
    EXPECT_EQ(openError("ultraino:/dev/null", 100),
              "device \"ultraino:/dev/null\": a ultraino has 64 transducers a board, 1 to 14 "
              "boards, but the array has 100");
    EXPECT_EQ(openError("sonicsurface:/dev/ttyNONE", 256),
              "serial port \"/dev/ttyNONE\": can't be opened: No such file or directory");
    EXPECT_EQ(openError("sonicsurface:/dev/null", 256),
              "serial port \"/dev/null\": isn't a serial port: Inappropriate ioctl for device");
    EXPECT_EQ(openError("sonicsurface:/dev/null?baud=7", 256),
              "device \"sonicsurface:/dev/null?baud=7\": baud=7 should be 9600, 57600, 115200, "
              "230400, 460800 "
              "or 921600");
    EXPECT_NE(openError("sonicsurface:/dev/null?baud=12345", 256).find("should be 9600, 57600"),
              std::string::npos);
}
