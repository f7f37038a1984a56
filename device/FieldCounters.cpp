#include "device/FieldCounters.h"

#include "device/drive/DriveEncoder.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device
{

std::string countersText(const DeviceReport& report)
{
    std::string text = fmt::format("{} sent, {} played", report.sent, report.played);
    const auto add = [&](std::uint64_t count, const char* what)
    {
        if (count > 0) text += fmt::format(", {} {}", count, what);
    };
    add(report.dropped, "dropped");
    add(report.lost, "lost");
    add(report.refused, "refused");
    add(report.faults, "faults");
    add(report.reconnects, "reconnects");
    if (!report.message.empty())
        text += (report.state >= DeviceState::HANGING ? "; " : "; last fault: ") + report.message;
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
    return fmt::format("{} of {} fields were played", report.played, settled);
}

void HeldField::replace(const DriveSignal& signal)
{
    const base::Lock lock(_mutex);
    _signal = signal;
}

void HeldField::clear()
{
    const base::Lock lock(_mutex);
    std::fill(_signal.duty.begin(), _signal.duty.end(), std::uint8_t(0));
}

bool HeldField::silent() const
{
    const base::Lock lock(_mutex);
    return std::all_of(
        _signal.duty.begin(), _signal.duty.end(), [](std::uint8_t duty) { return duty == 0; });
}

std::vector<std::complex<float>> HeldField::activations() const
{
    std::vector<std::complex<float>> q;
    const base::Lock lock(_mutex);
    decode(_signal, q);
    return q;
}

} // namespace midair::device
