#include "device/FieldCounters.h"

#include <algorithm>

namespace midair::device
{

std::string countersText(const DeviceReport& report)
{
    std::string text =
        std::to_string(report.sent) + " sent, " + std::to_string(report.played) + " played";
    const auto add = [&](std::uint64_t count, const char* what)
    {
        if (count > 0) text += ", " + std::to_string(count) + " " + what;
    };
    add(report.dropped, "dropped");
    add(report.lost, "lost");
    add(report.refused, "refused");
    add(report.faults, "faults");
    add(report.reconnects, "reconnects");
    if (!report.message.empty()) text += "; " + report.message;
    const std::string shortfall = shortfallOf(report);
    if (!shortfall.empty()) text += "; " + shortfall;
    return text;
}

// A field that a newer one replaced doesn't count as lost.
std::string shortfallOf(const DeviceReport& report)
{
    const std::uint64_t settled = report.sent - std::min(report.sent, report.pending);
    const std::uint64_t due = settled - std::min(settled, report.dropped);
    if (due == 0 || 2 * report.played >= due) return "";
    return std::to_string(report.played) + " of " + std::to_string(settled) + " fields were played";
}

} // namespace midair::device
