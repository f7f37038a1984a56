#pragma once

#include "device/autd3/Autd3Device.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/autd3/protocol/Commands.h"

#include <algorithm>
#include <future>
#include <memory>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

/// Fields on emulated units in virtual time: minutes pass as fast as the processor plays them, and
/// pause for nothing but what is asked for.
class VirtualRehearsal
{
public:
    using Chain = midair::device::emulation::EmulatedChain;
    using Time_ns = midair::device::emulation::Time_ns;

    /// What is played, on what.
    struct Plan
    {
        midair::device::autd3::Autd3Options options;
        midair::device::emulation::ChainOptions chain;
        midair::device::emulation::ChainFaults faults; ///< from when the units are open
        midair::device::emulation::VirtualTime::Host host;
        double fields_Hz = 600; ///< that are sent
        double duration_s = 1;
        bool isEven = false; ///< fields of one intensity
        /// What happens after eventAfter_s > 0, and what follows is measured to the millisecond.
        midair::device::emulation::ChainFaults::Event event;
        double eventAfter_s = -1;
        double silenceAfter_s = -1; ///< > 0: the device is silenced then, and gets no more
    };
    /// What became of it.
    struct Outcome
    {
        midair::device::DeviceReport device;
        midair::device::autd3::Autd3Device::Figures figures;
        midair::device::emulation::ChainReport units;
        std::vector<double> latencies_s; ///< from send() until the switch is sent
        double lostAfter_s = -1;         ///< from the event until the device says so; < 0: never
        double silentAfter_s = -1;       ///< from the event, or silence(), until no unit sounds
        double latency_s(double share) const
        {
            if (latencies_s.empty()) return 0;
            const double at = share * static_cast<double>(latencies_s.size());
            return latencies_s[std::min(latencies_s.size() - 1, static_cast<std::size_t>(at))];
        }
    };

    static Plan planOf(int units, bool isTimed, double lead_s)
    {
        Plan plan;
        plan.chain = midair::device::emulation::ChainOptions::realistic(units);
        plan.chain.boot_ns = 0;
        plan.chain.settle_ns = 20'000'000;
        plan.chain.tolerance_ns = isTimed ? 50'000 : 1'500'000;
        plan.options.units = units;
        plan.options.silencer = {1, 1};
        plan.options.timed = isTimed;
        plan.options.lead_s = lead_s;
        plan.options.order.resize(static_cast<std::size_t>(units));
        std::iota(plan.options.order.begin(), plan.options.order.end(), 0);
        plan.options.silent.resize(static_cast<std::size_t>(units));
        return plan;
    }

    static Outcome play(const Plan& plan) { return VirtualRehearsal(plan).run(); }

private:
    static constexpr Time_ns kDrain_ns = 300'000'000; ///< until all is counted

    explicit VirtualRehearsal(const Plan& plan) : _plan(plan) {}

    Outcome run()
    {
        using namespace midair::device;
        const auto time = std::make_shared<emulation::VirtualTime>(
            _plan.host, period_ns(), [this](Time_ns now_ns) { call(now_ns); });
        _units = std::make_shared<emulation::EmulatedUnits>(_plan.chain, time);
        _device = std::make_unique<autd3::Autd3Device>(
            DeviceLayout{_plan.options.units * autd3::kTransducersPerUnit, {}},
            _plan.options,
            false,
            [this](const std::function<bool()>&)
            { return std::make_unique<emulation::EmulatedLink>(_units); });
        _isOpen.set_value();
        _isDone.get_future().wait();
        _device.reset();
        std::sort(_outcome.latencies_s.begin(), _outcome.latencies_s.end());
        return std::move(_outcome);
    }

    // The device's thread waits, so this is called by it; by the other one while it is opened.
    // The other one looks at the time no more: it would pass by when the two threads get to run.
    void call(Time_ns now_ns)
    {
        if (std::this_thread::get_id() == _opener || _end_ns < 0) return;
        if (_end_ns == 0)
        {
            _isOpen.get_future().wait();
            setFaults();
            _end_ns = now_ns + static_cast<Time_ns>(_plan.duration_s * 1e9);
        }
        const midair::device::DeviceReport report = _device->report();
        if (report.lastHandedOver_s > _handedOver_s)
            _outcome.latencies_s.push_back(report.latency_s);
        _handedOver_s = report.lastHandedOver_s;
        if (isMeasured()) measure(report, now_ns);
        if (now_ns < _end_ns) return sendInTime(now_ns);
        if (now_ns < _end_ns + kDrain_ns) return;
        _end_ns = -1; // time goes on until the device is closed, and isn't looked at
        _outcome.device = report;
        _outcome.figures = _device->figures();
        _outcome.units =
            _units->with([](Chain& chain, Time_ns time_ns) { return chain.report(time_ns); });
        _isDone.set_value();
    }

    bool isMeasured() const { return _plan.eventAfter_s > 0 || _plan.silenceAfter_s > 0; }
    Time_ns period_ns() const
    {
        return isMeasured() ? 1'000'000 : static_cast<Time_ns>(1e9 / _plan.fields_Hz);
    }

    void measure(const midair::device::DeviceReport& report, Time_ns now_ns)
    {
        const double after_s = std::max(_plan.eventAfter_s, _plan.silenceAfter_s);
        const double since_s =
            static_cast<double>(now_ns - _end_ns) * 1e-9 + _plan.duration_s - after_s;
        if (since_s < 0) return;
        if (!std::exchange(_hasHappened, true))
        {
            if (_plan.silenceAfter_s > 0) _device->silence();
            if (_plan.eventAfter_s > 0)
                _units->with(
                    [&](Chain& chain, Time_ns at_ns)
                    {
                        chain.happen(_plan.event.kind, _plan.event.unit, at_ns);
                        return 0;
                    });
        }
        if (_outcome.lostAfter_s < 0 && report.state == midair::device::DeviceState::LOST)
            _outcome.lostAfter_s = since_s;
        const std::vector<std::uint8_t> duty =
            _units->with([](Chain& chain, Time_ns at_ns) { return chain.field(at_ns).duty; });
        const bool isSilent =
            std::all_of(duty.begin(), duty.end(), [](std::uint8_t level) { return level == 0; });
        if (!isSilent)
            _outcome.silentAfter_s = -1;
        else if (_outcome.silentAfter_s < 0)
            _outcome.silentAfter_s = since_s;
    }

    void sendInTime(Time_ns now_ns)
    {
        if (isMeasured() && (now_ns < _next_ns || _hasHappened)) return;
        _next_ns = now_ns + static_cast<Time_ns>(1e9 / _plan.fields_Hz);
        send();
    }

    void setFaults()
    {
        _units->with(
            [&](Chain& chain, Time_ns)
            {
                chain.setFaults(_plan.faults);
                return 0;
            });
    }

    void send()
    {
        const unsigned n = ++_sent;
        midair::device::DriveSignal signal = midair::device::silentSignal(
            _plan.options.units * midair::device::autd3::kTransducersPerUnit);
        for (std::size_t i = 0; i < signal.phase.size(); ++i)
        {
            signal.phase[i] = static_cast<std::uint8_t>(7 * i + 11 * n + n / 256);
            signal.duty[i] =
                _plan.isEven ? std::uint8_t{255} : static_cast<std::uint8_t>(1 + (i + n) % 255);
        }
        _units->with(
            [&](Chain& chain, Time_ns)
            {
                chain.watch().expect(n, signal);
                return 0;
            });
        _device->send(signal);
    }

    const Plan _plan;
    const std::thread::id _opener = std::this_thread::get_id();
    std::promise<void> _isOpen;
    std::promise<void> _isDone;
    std::shared_ptr<midair::device::emulation::EmulatedUnits> _units;
    std::unique_ptr<midair::device::autd3::Autd3Device> _device;
    // Of the device's thread.
    Time_ns _end_ns = 0;  ///< 0: not begun; -1: done
    Time_ns _next_ns = 0; ///< when the next field is sent
    bool _hasHappened = false;
    unsigned _sent = 0;
    double _handedOver_s = 0;
    Outcome _outcome;
};
