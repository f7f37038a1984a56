#pragma once

#include "device/ArrayDevice.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

namespace midair::device
{

/// A DeviceReport that several threads may read and write. All members may be called from any
/// thread.
class FieldCounters
{
public:
    template<typename Change>
    void change(Change&& change) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        change(_report);
    }

    DeviceReport report() const MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        return _report;
    }

    /// For devices that take a field at once: counts one as played and handed over now.
    /// \a sentAt_s: steadySeconds() at send().
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
    /// Counts a fault and keeps \a what as the report's message.
    void countFault(const std::string& what)
    {
        change(
            [&](DeviceReport& report)
            {
                ++report.faults;
                report.message = what;
            });
    }
    /// The same, and the device is lost for that reason: nobody sees the one without the other.
    void countLoss(const std::string& why)
    {
        change(
            [&](DeviceReport& report)
            {
                ++report.faults;
                report.message = why;
                report.state = DeviceState::LOST;
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
    mutable base::Mutex _mutex;
    DeviceReport _report MIDAIR_GUARDED_BY(_mutex);
};

/// "12 sent, 11 played, 1 dropped", then the other counters that are not 0, the fault that a lost
/// device has or the last one of another, and the shortfall.
std::string countersText(const DeviceReport& report);

/// "3 of 1000 fields were played" if less than half of those were played that no newer field
/// replaced; else empty.
std::string shortfallOf(const DeviceReport& report);

} // namespace midair::device
