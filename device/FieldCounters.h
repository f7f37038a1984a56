#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <complex>
#include <vector>

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
    /// Counts a fault and keeps \a what as the report's message.
    void countFault(const std::string& what) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.faults;
        _report.message = what;
    }
    /// The same, and the device is lost for that reason: nobody sees the one without the other.
    void countLoss(const std::string& why) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        ++_report.faults;
        _report.message = why;
        _report.state = DeviceState::LOST;
    }
    /// The device is there again.
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

/// "12 sent, 11 played, 1 dropped", then the other counters that are not 0, the fault that a lost
/// device has or the last one of another, and the shortfall.
std::string countersText(const DeviceReport& report);

/// "3 of 1000 fields were played" if less than half of those were played that no newer field
/// replaced; else empty.
std::string shortfallOf(const DeviceReport& report);

/// The field that a device holds between two sends; starts silent. All members may be called from
/// any thread.
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
