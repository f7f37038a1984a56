// How long encoding takes, how many fields a second the simulated array and the emulated USB array
// take, and how long a field and a mute are under way to the wire, how far apart two arrays get one
// field; beside it what the emulation costs by itself and how late the host wakes any thread.
#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/drive/DriveEncoder.h"
#include "device/usb/Protocol.h"
#include "device/usb/UsbTransferPool.h"
#include "haptics/base/Percentile.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#ifdef MIDAIR_HAS_UMOCKDEV
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device-usb/Preload.h"
#endif

using namespace midair::device;
using midair::base::percentile;

namespace
{

constexpr int kTransducers = 3984;

DeviceLayout octagon()
{
    DeviceLayout layout{kTransducers, {}};
    for (int i = 0; i < kTransducers; ++i)
        layout.board.push_back(i / 249);
    return layout;
}

void encoding()
{
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    std::vector<std::complex<float>> q(kTransducers);
    for (auto& value : q)
        value = {normal(random), normal(random)};
    DriveSignal signal;
    std::vector<double> times_us;
    for (int i = 0; i < 3000; ++i)
    {
        const double start_s = midair::base::steadySeconds();
        encode(q.data(), kTransducers, signal);
        times_us.push_back((midair::base::steadySeconds() - start_s) * 1e6);
    }
    std::printf("encode_us,%d,median,%.2f,p99,%.2f\n",
                kTransducers,
                percentile(times_us, 0.5),
                percentile(times_us, 0.99));
}

void simulation(double seconds)
{
    const auto device = openDevice("sim:", octagon());
    DriveSignal signal;
    signal.phase.assign(kTransducers, 0);
    signal.duty.assign(kTransducers, 255);
    const double start_s = midair::base::steadySeconds();
    while (midair::base::steadySeconds() < start_s + seconds)
    {
        ++signal.phase[0];
        device->send(signal);
    }
    const DeviceReport report = device->report();
    std::printf("sim,fields_per_s,%.0f\n",
                static_cast<double>(report.played) / (midair::base::steadySeconds() - start_s));
}

#ifdef MIDAIR_HAS_UMOCKDEV
void printTimes(const char* what, std::vector<double>& times_ms)
{
    std::printf("%s,median,%.3f,p99,%.3f,worst,%.3f\n",
                what,
                percentile(times_ms, 0.5),
                percentile(times_ms, 0.99),
                percentile(times_ms, 1));
}

void sleepUntil(double time_s)
{
    const double wait_s = time_s - midair::base::steadySeconds();
    if (wait_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait_s));
}

/// How late the host wakes a thread that asks for it every millisecond, while the others work: what
/// no program can do better.
class HostProbe
{
public:
    HostProbe() : _thread([this] { run(); }) {}
    ~HostProbe()
    {
        _stop = true;
        _thread.join();
        printTimes("host,wakes_late_ms", _late_ms);
    }

private:
    void run()
    {
        double due_s = midair::base::steadySeconds();
        while (!_stop)
        {
            due_s = std::max(due_s + 1e-3, midair::base::steadySeconds());
            sleepUntil(due_s);
            _late_ms.push_back((midair::base::steadySeconds() - due_s) * 1e3);
        }
    }
    std::atomic<bool> _stop{false};
    std::vector<double> _late_ms;
    std::thread _thread;
};

/// When each field was sent and when it came to the device; the first two phases count the fields.
class WireClock
{
public:
    explicit WireClock(EmulatedArray& array)
    {
        array.onField = [this](const std::uint8_t* bytes)
        {
            std::lock_guard<std::mutex> lock(_mutex);
            _latencies_ms.push_back(
                (midair::base::steadySeconds() - _sent_s[bytes[16] + 256U * bytes[17]]) * 1e3);
        };
    }
    void stamp(DriveSignal& signal, unsigned i)
    {
        signal.phase[0] = static_cast<std::uint8_t>(i);
        signal.phase[1] = static_cast<std::uint8_t>(i >> 8);
        std::lock_guard<std::mutex> lock(_mutex);
        _sent_s[i & 0xFFFF] = midair::base::steadySeconds();
    }
    std::vector<double> take()
    {
        std::lock_guard<std::mutex> lock(_mutex);
        return std::exchange(_latencies_ms, {});
    }

private:
    std::mutex _mutex;
    std::vector<double> _sent_s = std::vector<double>(1 << 16);
    std::vector<double> _latencies_ms;
};

DriveSignal fullDrive()
{
    DriveSignal signal;
    signal.phase.assign(kTransducers, 0);
    signal.duty.assign(kTransducers, 255);
    return signal;
}

struct NobodyListens : UsbTransferPool::Listener
{
    void onSent(std::uint64_t, UsbTransferPool::Outcome) override {}
    void onReceived(const std::uint8_t*, std::size_t) override {}
    void onReceiveFailed(UsbTransferPool::Outcome) override {}
};

// The same bytes straight into libusb: what the emulation and libusb cost by themselves.
void emulation(double seconds, double rate_Hz)
{
    EmulatedArray array(octagon());
    WireClock clock(array);
    NobodyListens nobody;
    UsbTransferPool pool({}, nobody);
    DriveSignal signal = fullDrive();
    const std::vector<protocol::Range> ranges = protocol::ranges(octagon());
    std::vector<std::uint8_t> bytes;
    const double start_s = midair::base::steadySeconds();
    const auto fields = static_cast<unsigned>(seconds * rate_Hz);
    for (unsigned i = 0; i < fields; ++i)
    {
        clock.stamp(signal, i);
        bytes.clear();
        protocol::appendField(bytes, signal, ranges, i + 1);
        pool.send(1, bytes);
        sleepUntil(start_s + (i + 1) / rate_Hz);
    }
    std::vector<double> latencies_ms = clock.take();
    printTimes("usb,emulation_alone_ms", latencies_ms);
}

void stream(ArrayDevice& device, WireClock& clock, double seconds, double rate_Hz)
{
    DriveSignal signal = fullDrive();
    const DeviceReport before = device.report();
    const double start_s = midair::base::steadySeconds();
    const auto fields = static_cast<unsigned>(seconds * rate_Hz);
    for (unsigned i = 0; i < fields; ++i)
    {
        clock.stamp(signal, i);
        device.send(signal);
        sleepUntil(start_s + (i + 1) / rate_Hz);
    }
    const double passed_s = midair::base::steadySeconds() - start_s;
    const DeviceReport report = device.report();
    std::vector<double> latencies_ms = clock.take();
    std::printf("usb,sent_per_s,%.0f,played_per_s,%.0f,dropped,%llu,lost,%llu\n",
                fields / passed_s,
                static_cast<double>(report.played - before.played) / passed_s,
                static_cast<unsigned long long>(report.dropped - before.dropped),
                static_cast<unsigned long long>(report.lost - before.lost));
    printTimes("usb,submit_to_wire_ms", latencies_ms);
}

// As many as it takes: the next as soon as the one before is on its way.
void flatOut(ArrayDevice& device, WireClock& clock, double seconds)
{
    DriveSignal signal = fullDrive();
    const std::uint64_t before = device.report().played;
    const double start_s = midair::base::steadySeconds();
    for (unsigned i = 0; midair::base::steadySeconds() < start_s + seconds;)
    {
        if (device.report().pending < 4)
        {
            clock.stamp(signal, i++);
            device.send(signal);
        }
        else
            std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    const double passed_s = midair::base::steadySeconds() - start_s;
    std::printf("usb,flat_out_played_per_s,%.0f\n",
                static_cast<double>(device.report().played - before) / passed_s);
    clock.take();
}

// From silence() to the wire while fields wait.
void mutes(EmulatedArray& array, ArrayDevice& device)
{
    constexpr int kMutes = 300;
    // Outlives this function, since mutes are repeated until they are answered.
    const auto arrival = std::make_shared<std::atomic<double>>(0);
    std::atomic<double>& arrived_s = *arrival;
    array.onControl = [arrival](const std::uint8_t*)
    {
        double none = 0;
        arrival->compare_exchange_strong(none, midair::base::steadySeconds()); // the first counts
    };
    const DriveSignal signal = fullDrive();
    std::vector<double> times_ms;
    for (int i = 0; i < kMutes; ++i)
    {
        for (int k = 0; k < 6; ++k)
        {
            device.send(signal);
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        arrived_s = 0;
        const double start_s = midair::base::steadySeconds();
        device.silence();
        while (arrived_s == 0 && midair::base::steadySeconds() < start_s + 1)
            std::this_thread::sleep_for(std::chrono::microseconds(20));
        times_ms.push_back((arrived_s - start_s) * 1e3);
    }
    printTimes("usb,mute_to_wire_ms", times_ms);
}

/// When the commit of each field came to each of two arrays; the first two phases count the fields.
class CommitClock
{
public:
    explicit CommitClock(EmulatedArray* const (&arrays)[2])
    {
        for (int i = 0; i < 2; ++i)
        {
            arrays[i]->onField = [this, i](const std::uint8_t* bytes)
            {
                _field[i] = bytes[16] + 256U * bytes[17];
                note(i);
            };
            // Later, where it comes by itself.
            arrays[i]->onCommit = [this, i](const std::uint8_t*) { note(i); };
        }
    }
    std::vector<double> skews_ms()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        std::vector<double> skews;
        for (const auto& [field, time_s] : _came_s[0])
            if (_came_s[1].count(field) != 0)
                skews.push_back(std::abs(_came_s[1][field] - time_s) * 1e3);
        return skews;
    }

private:
    void note(int i)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _came_s[i][_field[i]] = midair::base::steadySeconds();
    }
    std::mutex _mutex;
    unsigned _field[2] = {}; ///< umockdev's thread's
    std::map<unsigned, double> _came_s[2];
};

// Both halves of the octagon.
void twoArrays(double seconds, double rate_Hz)
{
    DeviceLayout half = octagon();
    half.transducers /= 2;
    half.board.resize(static_cast<std::size_t>(half.transducers));
    EmulatedArray first(half, {}, 1);
    EmulatedArray second(half, {}, 2);
    CommitClock clock({&first, &second});
    const auto device = openDevice("usb:A0001?boards=0-7,usb:A0002?boards=8-15", octagon());
    DriveSignal signal = fullDrive();
    std::vector<double> handedOver_ms;
    double skew_s = 0;
    const double start_s = midair::base::steadySeconds();
    const auto fields = static_cast<unsigned>(seconds * rate_Hz);
    for (unsigned i = 0; i < fields; ++i)
    {
        for (const int begin : {0, kTransducers / 2})
        {
            signal.phase[begin] = static_cast<std::uint8_t>(i);
            signal.phase[begin + 1] = static_cast<std::uint8_t>(i >> 8);
        }
        device->send(signal);
        sleepUntil(start_s + (i + 1) / rate_Hz);
        const DeviceReport report = device->report();
        if (report.skew_s != skew_s) handedOver_ms.push_back(report.skew_s * 1e3);
        skew_s = report.skew_s;
    }
    const DeviceReport report = device->report();
    std::printf("two_usb,sent,%u,played_by_each,%llu,lost,%llu\n",
                fields,
                static_cast<unsigned long long>(report.played / 2),
                static_cast<unsigned long long>(report.lost));
    printTimes("two_usb,skew_handed_over_ms", handedOver_ms);
    std::vector<double> onTheWire_ms = clock.skews_ms();
    printTimes("two_usb,skew_on_the_wire_ms", onTheWire_ms);
}

void usb(double seconds, double rate_Hz)
{
    emulation(seconds, rate_Hz);
    EmulatedArray array(octagon());
    WireClock clock(array);
    const auto device = openDevice("usb:", octagon());
    stream(*device, clock, seconds, rate_Hz);
    flatOut(*device, clock, seconds);
    mutes(array, *device);
}
#endif

} // namespace

int main(int argc, char** argv)
{
    double seconds = 3;
    double rate_Hz = 1000;
    CLI::App app("Timings of the device library.");
    app.add_option("--seconds", seconds, "for each of the streams")->capture_default_str();
    app.add_option("--rate", rate_Hz, "fields a second, USB")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
#ifdef MIDAIR_HAS_UMOCKDEV
    if (!restartWithUmockdev(argv)) return 1;
#endif
    encoding();
    simulation(seconds);
#ifdef MIDAIR_HAS_UMOCKDEV
    const HostProbe probe;
    usb(seconds, rate_Hz);
    for (const double slower_Hz : {100.0, 300.0, 500.0})
        twoArrays(seconds, slower_Hz);
#else
    std::printf("usb: built without umockdev, left out\n");
#endif
    return 0;
}
