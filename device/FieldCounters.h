#pragma once

#include "device/ArrayDevice.h"
#include "haptics/base/threads/SteadyClock.h"

#include <mutex>

namespace midair::device
{

/// A DeviceReport that several threads write to.
class FieldCounters
{
public:
    template<typename Change>
    void change(Change&& change)
    {
        std::lock_guard<std::mutex> lock(_mutex);
        change(_report);
    }

    DeviceReport report() const
    {
        std::lock_guard<std::mutex> lock(_mutex);
        return _report;
    }

    /// For devices that take a field at once: counts it as played, handed over now.
    void countPlayed(double sentAt_s)
    {
        change(
            [&](DeviceReport& report)
            {
                ++report.sent;
                ++report.played;
                report.lastHandedOver_s = base::steadySeconds();
                report.latency_s = report.lastHandedOver_s - sentAt_s;
            });
    }
    /// The last one is told.
    void countFault(const std::string& what)
    {
        change(
            [&](DeviceReport& report)
            {
                ++report.faults;
                report.message = what;
            });
    }
    void countRefused()
    {
        change(
            [](DeviceReport& report)
            {
                ++report.sent;
                ++report.refused;
            });
    }

private:
    mutable std::mutex _mutex;
    DeviceReport _report;
};

/// "12 sent, 11 played, 1 dropped", then what else is not 0, then the last fault and the shortfall.
std::string countersText(const DeviceReport& report);

/// "3 of 1000 fields were played" where it was none, or less than half of those that no newer one
/// overtook; else empty.
std::string shortfallOf(const DeviceReport& report);

} // namespace midair::device
