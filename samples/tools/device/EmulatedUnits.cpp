#include "device/DeviceUri.h"
#include "device/autd3/emulator/UdpUnits.h"
#include "samples/tools/device/DeviceTool.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using device::emulation::ChainReport;
using device::emulation::Time_ns;
using device::emulation::UdpUnits;

constexpr Time_ns kSecond_ns = 1'000'000'000;

device::emulation::ChainOptions optionsOf(const DeviceOptions& options)
{
    device::DeviceUri uri("autd3:?" + options.faults + (options.faults.empty() ? "" : "&") +
                              fmt::format("units={}", options.units),
                          "emulated units");
    auto defaults = device::emulation::ChainOptions::realistic(options.units);
    // Here cables and CPUs are those of this machine, which is no faster.
    defaults.wirePerByte_ns = 0;
    defaults.perFrame_ns = defaults.perWord_ns = 0;
    defaults.tolerance_ns = device::emulation::kMillisecond_ns;
    const auto chain = device::emulation::takeChainOptions(uri, defaults);
    uri.rejectUnknown();
    return chain;
}

void printState(UdpUnits& units, const ChainReport& before, const ChainReport& now, double time_s)
{
    int assigned = 0;
    int locked = 0;
    int gated = 0;
    for (int place = 0; place < units.chain().units(); ++place)
    {
        const auto& unit = units.chain().unit(place);
        assigned += unit.id() != device::emulation::kNoId ? 1 : 0;
        locked += unit.isLocked() ? 1 : 0;
        gated += unit.fpga().gated() ? 1 : 0;
    }
    double power = 0;
    const auto output = units.chain().output(UdpUnits::now_ns());
    for (const std::complex<float>& q : output)
        power += std::norm(q);
    std::cout << fmt::format("{:.0f} s: ids {}, clocks {}, failsafe {} of {} units; {} fields "
                             "changed, {} torn; {} datagrams in, {} out; amplitude {:.3f} rms\n",
                             time_s,
                             assigned,
                             locked,
                             gated,
                             units.chain().units(),
                             now.fields.whole - before.fields.whole,
                             now.fields.torn - before.fields.torn,
                             now.fromHost - before.fromHost,
                             now.toHost - before.toHost,
                             std::sqrt(power / static_cast<double>(output.size())))
              << std::flush;
}

void printReport(const ChainReport& report)
{
    std::cout << fmt::format(
        "fields: {} changed on all units together, at most {:.3f} ms apart; {} torn, the longest "
        "for {:.3f} ms\n"
        "writes into a bank that plays or waits to: {}, into the slot that was heard: {}\n"
        "datagrams: {} in, {} out, {} lost by faults, {} to ids that nobody has, {} too many\n"
        "commands: {} done, {} errors, {} out of turn, {} repeats, {} more than 7 at once; {} of a "
        "firmware update\n"
        "failsafe tripped: {} times; clocks that came back: {}\n",
        report.fields.whole,
        double(report.fields.worstSkew_ns) / 1e6,
        report.fields.torn,
        double(report.fields.longestTear_ns) / 1e6,
        report.writesIntoBanks,
        report.writesIntoSlots,
        report.fromHost,
        report.toHost,
        report.dropped,
        report.unheard,
        report.tooMany,
        report.telemetry.done,
        report.telemetry.errors,
        report.telemetry.outOfTurn,
        report.telemetry.repeats,
        report.telemetry.queueFull,
        report.updateCommands,
        report.trips,
        report.telemetry.resync);
}

} // namespace

int emulateUnits(const DeviceOptions& options)
{
    UdpUnits units(optionsOf(options), static_cast<std::uint16_t>(options.port));
    std::cout << fmt::format("{} emulated units: autd3:?units={}&group=[::1]:{}\n",
                             options.units,
                             options.units,
                             units.port())
              << std::flush;
    const Time_ns began_ns = UdpUnits::now_ns();
    const Time_ns end_ns = options.hasSeconds
                               ? began_ns + static_cast<Time_ns>(options.seconds * 1e9)
                               : device::emulation::kNever_ns;
    ChainReport before;
    for (Time_ns second_ns = began_ns; !interrupted && UdpUnits::now_ns() < end_ns;)
    {
        second_ns = std::min(second_ns + kSecond_ns, end_ns);
        while (!interrupted && UdpUnits::now_ns() < second_ns)
            units.run(second_ns);
        const ChainReport now = units.chain().report(UdpUnits::now_ns());
        printState(units, before, now, double(UdpUnits::now_ns() - began_ns) / 1e9);
        before = now;
    }
    printReport(units.chain().report(UdpUnits::now_ns()));
    return FINE;
}

} // namespace midair::samples
