#pragma once

#include "device/drive/DriveEncoder.h"
#include "device/limits/GuardedDevice.h"

#include <complex>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

/// What reached the device, with times.
struct SendLog
{
    struct Event
    {
        double time_s;
        double amplitude; ///< of the first transducer; 0 for silence
        bool silence;
    };
    explicit SendLog(const midair::base::Clock& itsClock = midair::base::steadyClock()) :
        clock(itsClock)
    {
    }

    const midair::base::Clock& clock;
    std::mutex mutex;
    std::vector<Event> events;

    void add(double amplitude, bool silence)
    {
        std::lock_guard<std::mutex> lock(mutex);
        events.push_back({clock.now_s(), amplitude, silence});
    }
    std::vector<Event> all()
    {
        std::lock_guard<std::mutex> lock(mutex);
        return events;
    }
};

/// Stands in for hardware; can refuse.
class LoggedDevice : public midair::device::ArrayDevice
{
public:
    explicit LoggedDevice(SendLog& log) : _log(log) {}
    bool send(const midair::device::DriveSignal& signal) override
    {
        _log.add(midair::device::amplitudeLevels()[signal.duty[0]], false);
        return true;
    }
    void silence() override { _log.add(0, true); }
    std::string status() const override { return "logged"; }
    midair::device::DeviceReport report() const override { return {}; }
    std::vector<std::complex<float>> played() const override { return {}; }

private:
    SendLog& _log;
};

inline std::unique_ptr<midair::device::GuardedDevice>
guarded(SendLog& log, const midair::device::SafetyLimits& limits, int transducers = 4)
{
    return std::make_unique<midair::device::GuardedDevice>(
        std::make_unique<LoggedDevice>(log),
        limits,
        transducers,
        std::unique_ptr<midair::device::DeviceClaim>(),
        log.clock);
}
