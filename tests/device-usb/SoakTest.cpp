#include "device/ArrayDevice.h"
#include "tests/Eventually.h"
#include "tests/LongTests.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device/Fields.h"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

double residentMegabytes()
{
    std::ifstream file("/proc/self/statm");
    double total = 0;
    double resident = 0;
    file >> total >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// How long this machine at most didn't let a thread run that wanted to, every 5 ms.
class HostProbe
{
public:
    HostProbe() : _thread([this] { run(); }) {}
    ~HostProbe() { stop(); }
    HostProbe(const HostProbe&) = delete;
    HostProbe& operator=(const HostProbe&) = delete;

    double stop()
    {
        _stop = true;
        if (_thread.joinable()) _thread.join();
        return _worst_s;
    }

private:
    void run()
    {
        double before_s = EmulatedArray::now_s();
        while (!_stop)
        {
            letPass(5e-3);
            const double now_s = EmulatedArray::now_s();
            _worst_s = std::max(_worst_s, now_s - before_s);
            before_s = now_s;
        }
    }
    std::atomic<bool> _stop{false};
    double _worst_s = 0;
    std::thread _thread;
};

// 500 fields/s for so long: memory doesn't grow, no commit is lost, the counters of host and device
// add up.
void soak(double seconds)
{
    DeviceLayout layout{3984, {}};
    for (int i = 0; i < 3984; ++i)
        layout.board.push_back(i / 249);
    EmulatedArray array(layout);
    const auto device = openDevice("usb:", layout);
    HostProbe probe;
    DriveSignal field = evenField(3984, 0, 255);
    const double start_s = EmulatedArray::now_s();
    const auto fields = static_cast<int>(500 * seconds);
    double atFirst_MB = 0;
    for (int i = 0; i < fields; ++i)
    {
        std::fill(field.phase.begin(), field.phase.end(), static_cast<std::uint8_t>(i));
        ASSERT_TRUE(device->send(field));
        if (i == fields / 10) atFirst_MB = residentMegabytes(); // when all buffers have their size
        letPass(start_s + (i + 1) / 500.0 - EmulatedArray::now_s());
    }
    EXPECT_TRUE(eventually([&] { return device->report().pending == 0; }));
    const double worst_s = probe.stop();
    const DeviceReport report = device->report();
    const protocol::Status status = array.firmware().status(EmulatedArray::now_s());
    std::cout << fields << " fields in " << EmulatedArray::now_s() - start_s
              << " s: " << report.played << " played, " << report.dropped << " dropped, "
              << report.lost << " lost; memory " << atFirst_MB << " MB, then "
              << residentMegabytes() << " MB; the host stood still for at most " << worst_s * 1e3
              << " ms, the watchdog muted " << status.watchdogs << " times\n";
    EXPECT_EQ(report.sent, static_cast<std::uint64_t>(fields));
    EXPECT_EQ(report.sent, report.played + report.dropped);
    EXPECT_EQ(report.lost, 0U);
    // A machine that is too busy to keep up stops some of this program's threads for long, whether
    // or not the probe is among them.
    const bool keptUp = 4 * report.dropped < report.sent;
    if (keptUp && worst_s < 0.5 * protocol::kWatchdog_s)
    {
        EXPECT_EQ(report.faults, 0U);
        EXPECT_EQ(status.watchdogs, 0U);
        EXPECT_EQ(status.played, report.played);
    }
    else
    {
        // A machine that stops this program for so long makes the watchdog mute and transfers time
        // out, which are then sent again: the device may have played more than was counted, never
        // less.
        EXPECT_GE(status.played, report.played);
        EXPECT_GE(report.faults, status.watchdogs);
    }
    EXPECT_EQ(status.incomplete, 0U);
    EXPECT_EQ(status.stale, 0U);
    EXPECT_EQ(array.playing(), field); // the last one plays
#if !defined(                                                                                      \
    __SANITIZE_ADDRESS__) // which keeps what was freed for a while, and looks for leaks itself
    // 300,000 fields of 8 kB that stayed would be 2.4 GB.
    EXPECT_LT(residentMegabytes(), atFirst_MB + 4);
#endif
}

} // namespace

TEST(Soak, seconds_at_500_fields_a_second)
{
    soak(2);
}

TEST(Soak, DISABLED_ten_minutes_at_500_fields_a_second)
{
    if (!longTestsAsked()) GTEST_SKIP() << "only with tests/run.sh --long";
    soak(600);
}
