#include "device/autd3/Autd3Options.h"

#include "device/DeviceUri.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kLeastLead_s = 0.5e-3;
constexpr double kMostLead_s = 0.1;
constexpr double kLeastFailsafe_s = 0.02;
constexpr double kMostFailsafe_s = 10;
constexpr double kLeastHeartbeat_s = 1e-3;
constexpr int kBeatsPerFailsafe = 3; ///< two may be lost

double takeTime(DeviceUri& uri, const char* key, double fallback_s, double low_s, double high_s)
{
    const double value_s = uri.takeSeconds(key, fallback_s);
    if (value_s < low_s || value_s > high_s)
        throw uri.error(fmt::format(
            "{}={:g}ms should be {:g}ms .. {:g}ms", key, value_s * 1e3, low_s * 1e3, high_s * 1e3));
    return value_s;
}

/// Takes one of two words: true for the first.
bool takeEither(DeviceUri& uri, const char* key, const char* first, const char* second)
{
    const std::string word = uri.takeText(key, first);
    if (word != first && word != second)
        throw uri.error(fmt::format("{}={} should be {} or {}", key, word, first, second));
    return word == first;
}

int takeUnits(DeviceUri& uri, const DeviceLayout& layout)
{
    const bool isNamed = uri.has("units");
    const double units = uri.takeNumber(
        "units", std::ceil(layout.transducers / double(kTransducersPerUnit)), 1, kMostUnits);
    if (units != std::floor(units))
        throw uri.error(
            fmt::format("units={:g} should be a whole number, 1 .. {}", units, kMostUnits));
    if (units > kMostUnits) // not given: the number that the array needs
        throw uri.error(
            fmt::format("the array has {} transducers, {:g} units; at most {} are supported",
                        layout.transducers,
                        units,
                        kMostUnits));
    const int transducers = static_cast<int>(units) * kTransducersPerUnit;
    if (transducers == layout.transducers) return static_cast<int>(units);
    if (isNamed)
        throw uri.error(fmt::format("units={:g} are {} transducers, but the array has {}",
                                    units,
                                    transducers,
                                    layout.transducers));
    throw uri.error(fmt::format("the array has {} transducers; units have {} each: the array "
                                "\"autd3\" is one unit, \"octagon-autd3\" sixteen",
                                layout.transducers,
                                kTransducersPerUnit));
}

std::vector<int> takeOrder(DeviceUri& uri, int units)
{
    std::vector<int> order(static_cast<std::size_t>(units));
    std::iota(order.begin(), order.end(), 0);
    const std::string text = uri.takeText("order", "");
    if (text.empty()) return order;
    std::vector<int> read;
    for (const std::string& part : base::splitAt(text, ','))
    {
        int board = 0;
        if (!base::parseWhole(part, board) || board < 0 || board >= units ||
            std::find(read.begin(), read.end(), board) != read.end())
            throw uri.error(
                fmt::format("order={}: \"{}\" should be a board, 0 .. {}, that isn't listed before",
                            text,
                            part,
                            units - 1));
        read.push_back(board);
    }
    if (read.size() != order.size())
        throw uri.error(
            fmt::format("order={} has {} boards; there are {} units", text, read.size(), units));
    return read;
}

Silencer takeSilencer(DeviceUri& uri)
{
    Silencer silencer;
    const std::string text = uri.takeText("silencer", "");
    if (text.empty()) return silencer;
    const std::vector<std::string> parts = base::splitAt(text, ',');
    const auto read = [](const std::string& part, int& steps)
    { return base::parseWhole(part, steps) && steps >= 1 && steps <= 65535; };
    if (parts.size() != 2 || !read(parts[0], silencer.phaseSteps) ||
        !read(parts[1], silencer.intensitySteps))
        throw uri.error(fmt::format("silencer={} should be two numbers of periods, 1 .. 65535, for "
                                    "phase and intensity: 40,10; 1,1 turns it off",
                                    text));
    return silencer;
}

} // namespace

CpuConfig Autd3Options::cpu() const
{
    constexpr double kMostMargin_s = 1e-3;
    CpuConfig config;
    config.switchMargin_ns =
        static_cast<std::uint32_t>(std::lround(std::min(kMostMargin_s, lead_s / 3) * 1e9));
    config.failsafe_ms = static_cast<std::uint16_t>(std::lround(failsafe_s * 1e3));
    return config;
}

// A lost unit should be detected soon, even with a long fail-safe.
double Autd3Options::restBeat_s() const
{
    constexpr double kSlowestBeat_s = 0.1;
    if (isHeartbeatNamed) return heartbeat_s;
    return std::max(heartbeat_s, std::min(failsafe_s / kBeatsPerFailsafe, kSlowestBeat_s));
}

Autd3Options takeAutd3Options(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    Autd3Options options;
    options.units = takeUnits(uri, layout);
    options.interface = uri.takeText("interface", "");
    options.group = uri.takeText("group", "");
    if (!options.interface.empty() && !options.group.empty())
        throw uri.error("interface and group exclude each other: the system's routes decide how to "
                        "reach a group");
    options.order = takeOrder(uri, options.units);
    options.timed = takeEither(uri, "sync", "time", "now");
    options.lead_s = takeTime(uri, "lead", options.lead_s, kLeastLead_s, kMostLead_s);
    options.failsafe_s =
        takeTime(uri, "failsafe", options.failsafe_s, kLeastFailsafe_s, kMostFailsafe_s);
    const double slowest_s = options.failsafe_s / kBeatsPerFailsafe;
    options.isHeartbeatNamed = !uri.takeText("heartbeat", "").empty();
    options.heartbeat_s = takeTime(
        uri, "heartbeat", std::min(options.heartbeat_s, slowest_s), kLeastHeartbeat_s, slowest_s);
    options.silencer = takeSilencer(uri);
    options.whenLost =
        takeEither(uri, "lost", "all", "one") ? WhenLost::ALL_FALL_SILENT : WhenLost::ONE_IS_MISSED;
    options.silent.resize(static_cast<std::size_t>(options.units));
    for (const int i : layout.dead)
    {
        const auto unit =
            std::find(options.order.begin(), options.order.end(), i / kTransducersPerUnit);
        options.silent[static_cast<std::size_t>(unit - options.order.begin())].push_back(
            i % kTransducersPerUnit);
    }
    return options;
}

} // namespace midair::device::autd3
