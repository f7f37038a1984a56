#include "tests/benchmarks/autd3/VirtualFields.h"

#include "tests/device/autd3/VirtualRehearsal.h"

#include <cstdio>

namespace
{

/// One line of the table.
struct Case
{
    const char* name;
    bool isTimed = true;
    double lead_s = 1e-3;
    double fields_Hz = 600;
    double loss = 0;
    bool isRealistic = false; ///< a cable of 100 Mbit/s, and units' processors that take time
    bool isEven = false;
    double pausesPerSecond = 0; ///< of the computer, of 5 ms
};

void print(const Case& what, double duration_s, const VirtualRehearsal::Outcome& outcome)
{
    std::printf("%-38s %5.0f %6.1f %5llu %7.2f %4llu %5llu %5llu %4llu %7.2f %7.2f %7.2f\n",
                what.name,
                what.fields_Hz,
                static_cast<double>(outcome.device.played) / duration_s,
                static_cast<unsigned long long>(outcome.units.fields.torn),
                static_cast<double>(outcome.units.fields.longestTear_ns) * 1e-6,
                static_cast<unsigned long long>(outcome.figures.torn),
                static_cast<unsigned long long>(outcome.device.dropped),
                static_cast<unsigned long long>(outcome.device.lost),
                static_cast<unsigned long long>(outcome.units.writesIntoBanks +
                                                outcome.units.writesIntoSlots +
                                                outcome.units.fields.unknown),
                outcome.latency_s(0.5) * 1e3,
                outcome.latency_s(0.99) * 1e3,
                outcome.figures.lead_s * 1e3);
    std::fflush(stdout);
}

} // namespace

void playVirtualFields(int units, double duration_s, double loss)
{
    std::printf("fields/s sent and played; torn ones, the longest, and how many the device knows "
                "of; dropped for newer\nones; lost; bad: writes into a bank that plays or waits "
                "to, and what nobody sent; from send() until the\nswitch is sent, ms; the lead "
                "at the end\n");
    std::printf("%-38s %5s %6s %5s %7s %4s %5s %5s %4s %7s %7s %7s\n",
                "",
                "sent",
                "played",
                "torn",
                "ms",
                "told",
                "drop",
                "lost",
                "bad",
                "p50",
                "p99",
                "lead/ms");
    const Case cases[] = {
        {"timed, lead 1 ms"},
        {"timed, lead 1 ms, with loss", true, 1e-3, 600, loss},
        {"timed, lead 3 ms", true, 3e-3},
        {"timed, lead 3 ms, with loss", true, 3e-3, 600, loss},
        {"at once", false, 1e-3, 1000},
        {"at once, with loss", false, 1e-3, 1000, loss},
        {"timed, lead 1 ms, 100 Mbit/s", true, 1e-3, 600, 0, true},
        {"timed, lead 1 ms, 100 Mbit/s, even", true, 1e-3, 600, 0, true, true},
        {"timed, lead 3 ms, 100 Mbit/s", true, 3e-3, 600, 0, true},
        {"at once, 100 Mbit/s", false, 1e-3, 1000, 0, true},
        {"timed, lead 1 ms, a pause a second", true, 1e-3, 600, 0, false, false, 1},
        {"timed, lead 3 ms, a pause a second", true, 3e-3, 600, 0, false, false, 1},
        {"timed, lead 10 ms, a pause a second", true, 10e-3, 600, 0, false, false, 1},
        {"timed, lead 3 ms, loss and pauses", true, 3e-3, 600, loss, false, false, 1},
    };
    for (const Case& one : cases)
    {
        VirtualRehearsal::Plan plan = VirtualRehearsal::planOf(units, one.isTimed, one.lead_s);
        if (!one.isRealistic)
            plan.chain.wirePerByte_ns = plan.chain.perFrame_ns = plan.chain.perWord_ns = 0;
        plan.faults.drop = one.loss;
        plan.host.pausesPerSecond = one.pausesPerSecond;
        plan.host.pause_ns = 5'000'000;
        plan.fields_Hz = one.fields_Hz;
        plan.duration_s = duration_s;
        plan.isEven = one.isEven;
        print(one, duration_s, VirtualRehearsal::play(plan));
    }
}
