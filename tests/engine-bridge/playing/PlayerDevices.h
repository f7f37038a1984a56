#pragma once

#include "device/ArrayDevice.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"

#include <atomic>
#include <complex>
#include <cstdint>
#include <mutex>
#include <vector>

/// Keeps what it is sent.
class Collector : public midair::device::ArrayDevice
{
public:
    explicit Collector(const midair::base::Clock& itsClock = midair::base::steadyClock()) :
        clock(itsClock)
    {
    }

    bool send(const midair::device::DriveSignal& signal) override
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _signals.push_back(signal);
        return !refusing;
    }
    void silence() override {}
    std::string status() const override { return "collects"; }
    midair::device::DeviceReport report() const override { return {}; }
    std::vector<std::complex<float>> played() const override { return {}; }

    std::vector<midair::device::DriveSignal> signals() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _signals;
    }
    /// Until \a count signals are there.
    bool waitFor(std::size_t count) const
    {
        return eventually([&] { return signals().size() >= count; });
    }

    std::atomic<bool> refusing{false};
    const midair::base::Clock& clock;

private:
    mutable std::mutex _mutex;
    std::vector<midair::device::DriveSignal> _signals;
};

/// One that keeps sequences of up to four fields, and the times at which they came.
class Keeper : public Collector
{
public:
    using Collector::Collector;
    struct Kept
    {
        midair::device::DriveSequence sequence;
        double time_s = 0;
    };
    bool sendSequence(const midair::device::DriveSequence& sequence) override
    {
        const std::lock_guard<std::mutex> lock(_keeping);
        _kept.push_back({sequence, clock.now_s()});
        return !refusing;
    }
    midair::device::DriveAbility ability() const override
    {
        midair::device::DriveAbility ability;
        ability.sequenceFields = 4;
        ability.sequenceClock_Hz = clock_Hz;
        return ability;
    }
    double clock_Hz = 0; ///< to be set before it is used
    std::vector<Kept> kept() const
    {
        const std::lock_guard<std::mutex> lock(_keeping);
        return _kept;
    }
    bool waitForSequences(std::size_t count) const
    {
        return eventually([&] { return kept().size() >= count; });
    }

private:
    mutable std::mutex _keeping;
    std::vector<Kept> _kept;
};

// Field k has all phases at level 10 k, and full amplitude.
inline std::vector<midair::device::DriveSignal> numberedFields(int count)
{
    std::vector<midair::device::DriveSignal> fields(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k)
    {
        fields[static_cast<std::size_t>(k)].phase.assign(5, static_cast<std::uint8_t>(10 * k));
        fields[static_cast<std::size_t>(k)].duty.assign(5, 255);
    }
    return fields;
}
