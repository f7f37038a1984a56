// Runs inside the virtual machine of run.sh: the USB path on the kernel's own stack.

#include "UsbIpServer.h"
#include "device/ArrayDevice.h"

#include <cstdio>
#include <functional>

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

} // namespace

int main()
{
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
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
    std::printf(failures == 0 ? "VM TEST PASSED\n" : "VM TEST FAILED\n");
    return failures == 0 ? 0 : 1;
}
