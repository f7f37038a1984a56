#include "device/FieldCounters.h"

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
    return text;
}

} // namespace midair::device
