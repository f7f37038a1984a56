// How long encoding takes, how many fields a second the simulated array and the emulated USB array take, and how long a field
// is under way from send() to the wire.
#include "device/ArrayDevice.h"
#include "device/DriveEncoder.h"
#include "device/FieldCounters.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#ifdef MIDAIR_HAS_UMOCKDEV
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device-usb/Preload.h"
#endif

using namespace midair::device;

namespace
{

constexpr int kTransducers = 3984;

double percentile(std::vector<double>& values, double share)
{
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

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
        const double start_s = steadySeconds();
        encode(q.data(), kTransducers, signal);
        times_us.push_back((steadySeconds() - start_s) * 1e6);
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
    const double start_s = steadySeconds();
    while (steadySeconds() < start_s + seconds)
    {
        ++signal.phase[0];
        device->send(signal);
    }
    const DeviceReport report = device->report();
    std::printf("sim,fields_per_s,%.0f\n",
                static_cast<double>(report.played) / (steadySeconds() - start_s));
}

#ifdef MIDAIR_HAS_UMOCKDEV
// The first two phases count the fields, so that the one on the wire is known.
void usb(double seconds, double rate_Hz)
{
    EmulatedArray array(octagon());
    std::mutex mutex;
    std::vector<double> sent_s(1 << 16);
    std::vector<double> latencies_ms;
    array.onField = [&](const std::uint8_t* bytes)
    {
        std::lock_guard<std::mutex> lock(mutex);
        latencies_ms.push_back((steadySeconds() - sent_s[bytes[16] + 256U * bytes[17]]) * 1e3);
    };
    auto device = openDevice("usb:", octagon());
    DriveSignal signal;
    signal.phase.assign(kTransducers, 0);
    signal.duty.assign(kTransducers, 255);
    const double start_s = steadySeconds();
    const auto fields = static_cast<unsigned>(seconds * rate_Hz);
    for (unsigned i = 0; i < fields; ++i)
    {
        signal.phase[0] = static_cast<std::uint8_t>(i);
        signal.phase[1] = static_cast<std::uint8_t>(i >> 8);
        {
            std::lock_guard<std::mutex> lock(mutex);
            sent_s[i & 0xFFFF] = steadySeconds();
        }
        device->send(signal);
        const double wait_s = start_s + (i + 1) / rate_Hz - steadySeconds();
        if (wait_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait_s));
    }
    const double passed_s = steadySeconds() - start_s;
    const DeviceReport report = device->report();
    device.reset();
    std::lock_guard<std::mutex> lock(mutex);
    std::printf("usb,sent_per_s,%.0f,played_per_s,%.0f,dropped,%llu,lost,%llu\n",
                fields / passed_s,
                static_cast<double>(report.played) / passed_s,
                static_cast<unsigned long long>(report.dropped),
                static_cast<unsigned long long>(report.lost));
    std::printf("usb,submit_to_wire_ms,median,%.3f,p99,%.3f,worst,%.3f\n",
                percentile(latencies_ms, 0.5),
                percentile(latencies_ms, 0.99),
                percentile(latencies_ms, 1));
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
    usb(seconds, rate_Hz);
#else
    std::printf("usb: built without umockdev, left out\n");
#endif
    return 0;
}
