// Runs inside the virtual machine of run.sh: the USB path on the kernel's own stack.

#include "device/ArrayDevice.h"
#include "device/simulation/VirtualBoard.h"
#include "tests/vm/UsbIpServer.h"

#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <mutex>

#include <sys/wait.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

int failures = 0;

void check(bool good, const char* what)
{
    std::printf("VM %s: %s\n", good ? "ok    " : "FAILED", what);
    failures += good ? 0 : 1;
}

bool eventually(const std::function<bool()>& condition, double seconds = 10)
{
    const double end_s = UsbIpServer::now_s() + seconds;
    while (!condition())
    {
        if (UsbIpServer::now_s() > end_s) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

DriveSignal even(std::uint8_t phase)
{
    DriveSignal signal;
    signal.phase.assign(3984, phase);
    signal.duty.assign(3984, 255);
    return signal;
}

std::unique_ptr<ArrayDevice> open(const DeviceLayout& layout)
{
    std::unique_ptr<ArrayDevice> device;
    std::string error;
    const bool opened = eventually(
        [&]
        {
            try
            {
                device = openDevice("usb:", layout);
            }
            catch (const DeviceError& refusal)
            {
                error = refusal.what();
            }
            return device != nullptr;
        });
    if (!opened) std::printf("VM        %s\n", error.c_str());
    return device;
}

bool silent(const DriveSignal& signal)
{
    return signal.duty == std::vector<std::uint8_t>(signal.duty.size(), 0);
}

void stream(ArrayDevice& device, VirtualFirmware& firmware)
{
    constexpr int kFields = 300;
    bool whole = true;
    const double start_s = UsbIpServer::now_s();
    for (int i = 0; i < kFields; ++i)
    {
        const std::uint64_t before = device.report().played;
        device.send(even(static_cast<std::uint8_t>(i)));
        eventually([&] { return device.report().played > before; });
        const DriveSignal playing = firmware.playing(UsbIpServer::now_s());
        whole = whole && playing.phase == std::vector<std::uint8_t>(3984, playing.phase[0]);
    }
    const double each_ms = (UsbIpServer::now_s() - start_s) / kFields * 1e3;
    const DeviceReport report = device.report();
    std::printf("VM        a field of 8 kB, sent and confirmed: %.2f ms\n", each_ms);
    check(whole, "every field is whole");
    check(report.lost == 0 && report.faults == 0, "none is lost");
}

/// An OpenMPD board behind an FT232H.
struct Board
{
    std::mutex mutex;
    std::unique_ptr<VirtualBoard> board = makeVirtualBoard("openmpd", 256);
    UsbIpServer chip{[this](const std::uint8_t* bytes, std::size_t count)
                     {
                         std::lock_guard<std::mutex> lock(mutex);
                         board->receive(bytes, count);
                     }};

    bool isSilent()
    {
        std::lock_guard<std::mutex> lock(mutex);
        const auto q = board->playing();
        return q == std::vector<std::complex<float>>(q.size());
    }
};

bool opensBoard()
{
    try
    {
        return openDevice("openmpd:A0001", {256, {}}) != nullptr;
    }
    catch (const DeviceError& refusal)
    {
        std::printf("VM        %s\n", refusal.what());
        return false;
    }
}

// A program of its own that is killed: plays on the board for ever.
int boardHostThatNeverCloses()
{
    const auto device = openDevice("openmpd:A0001", {256, {}});
    DriveSignal field;
    field.phase.assign(256, 1);
    field.duty.assign(256, 255);
    while (true)
    {
        device->send(field);
        ::usleep(2000);
    }
}

void killBoardHost()
{
    Board board;
    check(board.chip.plug(), "vhci-hcd takes the FT232H");
    check(eventually([] { return opensBoard(); }), "it is enumerated and opened");
    check(opensBoard(), "it is free again as soon as it is closed");
    const pid_t host = ::fork();
    if (host == 0)
    {
        ::execl("/proc/self/exe", "midair_vm_test", "--board-host", nullptr);
        ::_exit(1);
    }
    check(eventually([&] { return !board.isSilent(); }), "another program plays on it");
    board.chip.hold();
    check(eventually([&] { return board.chip.held() == 1; }), "a field is in flight");
    ::kill(host, SIGKILL);
    ::waitpid(host, nullptr, 0);
    check(eventually([&] { return board.chip.held() == 2; }),
          "after a SIGKILL of that program its child's silence is in flight behind the field");
    board.chip.letGo();
    check(eventually([&] { return board.isSilent(); }), "the board is silent");
    check(board.chip.unlinkedHeld() == 0, "the kernel has taken back neither");
    check(eventually([] { return opensBoard(); }), "another program can have the board");
}

} // namespace

int main(int argc, char** argv)
{
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    if (argc > 1 && std::strcmp(argv[1], "--board-host") == 0) return boardHostThatNeverCloses();
    DeviceLayout layout{3984, {}};
    for (int i = 0; i < 3984; ++i)
        layout.board.push_back(i / 249);
    VirtualFirmware firmware(layout);
    UsbIpServer server(firmware);
    check(server.plug(), "vhci-hcd takes the device");
    auto device = open(layout);
    check(device != nullptr, "it is enumerated and opened");
    if (device == nullptr) return 1;
    stream(*device, firmware);
    device->silence();
    check(eventually([&] { return silent(firmware.playing(UsbIpServer::now_s())); }),
          "a mute mutes");
    device->send(even(7));
    check(eventually([&] { return device->report().pending == 0; }), "the next field plays");

    server.unplug();
    check(eventually([&] { return device->report().state == DeviceState::LOST; }),
          "an unplug is noticed");
    std::printf("VM        %s\n", device->status().c_str());
    check(eventually([&] { return server.plug(); }), "it is plugged in again");
    check(eventually([&] { return device->report().state == DeviceState::READY; }),
          "it is taken up again");
    check(silent(firmware.playing(UsbIpServer::now_s())), "it is silent until the next field");
    device->send(even(9));
    check(eventually([&] { return !silent(firmware.playing(UsbIpServer::now_s())); }),
          "it plays again");
    device.reset();
    check(silent(firmware.playing(UsbIpServer::now_s())), "closing silences it");
    killBoardHost();
    std::printf(failures == 0 ? "VM TEST PASSED\n" : "VM TEST FAILED\n");
    return failures == 0 ? 0 : 1;
}
