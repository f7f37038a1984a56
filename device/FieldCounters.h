#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <complex>
#include <vector>

namespace midair::device
{

/// A thread-safe DeviceReport. Any thread may call any member.
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

    /// Counts a field as played and handed over now, for devices that take fields at once. \a
    /// sentAt_s: steadySeconds() at send().
    void countPlayed(double sentAt_s) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.sent;
        ++_report.played;
        _report.lastHandedOver_s = base::steadySeconds();
        _report.latency_s = _report.lastHandedOver_s - sentAt_s;
    }
    void noteHandedOver(double now_s, double sentAt_s) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        _report.lastHandedOver_s = now_s;
        _report.latency_s = now_s - sentAt_s;
    }
    /// Counts a fault and stores \a what as the report's message.
    void countFault(const std::string& what) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.faults;
        _report.message = what;
    }
    /// Counts a fault and marks the device as lost, in one step.
    void countLoss(const std::string& why) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.faults;
        _report.message = why;
        _report.state = DeviceState::LOST;
    }
    /// Marks the device as back.
    void countReturn() MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.reconnects;
        _report.state = DeviceState::READY;
    }
    void countRefused() MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.sent;
        ++_report.refused;
    }

private:
    mutable base::Mutex _mutex;
    DeviceReport _report MIDAIR_GUARDED_BY(_mutex);
};

/// Returns "12 sent, 11 played, 1 dropped", then other non-zero counters, the fault of a lost
/// device or the last fault of another, and the shortfall.
std::string countersText(const DeviceReport& report);

/// Returns "3 of 1000 fields were played" if less than half of the fields that no newer one
/// replaced were played; otherwise empty.
std::string shortfallOf(const DeviceReport& report);

/// Field that a device holds between two sends; initially silent. Any thread may call any member.
class HeldField
{
public:
    explicit HeldField(int transducers) :
        _transducers(transducers),
        _signal(silentSignal(transducers))
    {
    }

    int transducers() const { return _transducers; }
    void replace(const DriveSignal& signal); ///< \a signal has transducers() entries
    void clear();                            ///< sets all duties to 0
    bool silent() const;                     ///< true if all duties are 0
    std::vector<std::complex<float>> activations() const;

private:
    const int _transducers;
    mutable base::Mutex _mutex;
    DriveSignal _signal MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
