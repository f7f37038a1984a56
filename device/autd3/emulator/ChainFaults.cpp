#include "device/autd3/emulator/ChainFaults.h"

#include "device/DeviceUri.h"

#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace midair::device::emulation
{

namespace
{

constexpr double kLatest_s = 1e6;

Time_ns nanoseconds(double time_s)
{
    return static_cast<Time_ns>(std::llround(time_s * 1e9));
}

void takeVersion(DeviceUri& uri, const std::string& key, int (&version)[3])
{
    const std::string text = uri.takeText(key, "");
    if (text.empty()) return;
    int read[3] = {0, 0, 0};
    int end = 0;
    const int found =
        std::sscanf(text.c_str(), "%3d.%3d.%3d%n", &read[0], &read[1], &read[2], &end);
    bool good = found == 3 && static_cast<std::size_t>(end) == text.size();
    for (const int part : read)
        good = good && part >= 0 && part <= 255;
    if (!good) throw uri.error(fmt::format("{}={} should be a version such as 0.10.0", key, text));
    std::copy(read, read + 3, version);
}

// "reboot_at=5s&reboot_unit=3", each kind once; programs have as many as they like.
void takeEvent(DeviceUri& uri, ChainOptions& options, const char* name, ChainFaults::Kind kind)
{
    const std::string at = std::string(name) + "_at";
    const bool ofUnit = kind != ChainFaults::Kind::UNPLUG && kind != ChainFaults::Kind::REPLUG &&
                        kind != ChainFaults::Kind::HANG;
    const double time_s = uri.takeSeconds(at, kLatest_s);
    double unit = 0;
    if (ofUnit) unit = uri.takeNumber(std::string(name) + "_unit", 0, 0, options.units - 1);
    if (time_s < kLatest_s)
        options.faults.events.push_back({nanoseconds(time_s), kind, static_cast<int>(unit)});
}

} // namespace

ChainOptions ChainOptions::realistic(int units)
{
    ChainOptions options;
    options.units = units;
    options.wirePerByte_ns = 80;
    options.perFrame_ns = 10'000;
    options.perWord_ns = 200; // twice 249 words in 0.1 ms
    options.settle_ns = 1'000 * kMillisecond_ns;
    options.boot_ns = 2'000 * kMillisecond_ns;
    options.drift_ppm = 20;
    options.clockError_ns = 125;
    return options;
}

ChainOptions takeChainOptions(DeviceUri& uri, const ChainOptions& defaults)
{
    ChainOptions options = defaults;
    ChainFaults& faults = options.faults;
    options.units = static_cast<int>(uri.takeNumber("units", options.units, 1, 64));
    options.protocolVersion = static_cast<int>(uri.takeNumber("version", 2, 0, 255));
    takeVersion(uri, "firmware", options.firmware);
    takeVersion(uri, "gateware", options.gateware);
    options.settle_ns = nanoseconds(uri.takeSeconds("settle", double(options.settle_ns) / 1e9));
    options.drift_ppm = static_cast<std::int64_t>(
        uri.takeNumber("drift_ppm", double(options.drift_ppm), -500, 500));
    options.tolerance_ns =
        nanoseconds(uri.takeSeconds("tolerance", double(options.tolerance_ns) / 1e9));
    faults.drop = uri.takeNumber("drop", 0, 0, 1);
    faults.duplicate = uri.takeNumber("duplicate", 0, 0, 1);
    faults.reorder = uri.takeNumber("reorder", 0, 0, 1);
    faults.garbage = uri.takeNumber("garbage", 0, 0, 1);
    faults.error = uri.takeNumber("error", 0, 0, 1);
    faults.errorResult = static_cast<std::uint8_t>(uri.takeNumber("error_result", 7, 1, 255));
    faults.latency_ns = nanoseconds(uri.takeSeconds("latency", 0));
    faults.jitter_ns = nanoseconds(uri.takeSeconds("jitter", 0));
    faults.seed = static_cast<unsigned>(uri.takeNumber("seed", 1, 0, 1e9));
    faults.lostAssignments = static_cast<int>(uri.takeNumber("lost_assignments", 0, 0, 1000));
    takeEvent(uri, options, "reboot", ChainFaults::Kind::REBOOT);
    takeEvent(uri, options, "sync_lost", ChainFaults::Kind::SYNC_LOST);
    takeEvent(uri, options, "sync_back", ChainFaults::Kind::SYNC_BACK);
    takeEvent(uri, options, "failsafe", ChainFaults::Kind::FAILSAFE);
    takeEvent(uri, options, "hot", ChainFaults::Kind::HOT);
    takeEvent(uri, options, "unplug", ChainFaults::Kind::UNPLUG);
    takeEvent(uri, options, "replug", ChainFaults::Kind::REPLUG);
    takeEvent(uri, options, "hang", ChainFaults::Kind::HANG);
    return options;
}

} // namespace midair::device::emulation
