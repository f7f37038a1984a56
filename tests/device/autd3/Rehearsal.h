#pragma once

#include "device/autd3/Autd3Device.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/autd3/protocol/Commands.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"

#include <memory>

/// An Autd3Device on units that are emulated in this program.
class Rehearsal
{
public:
    using Chain = midair::device::emulation::EmulatedChain;
    using Time_ns = midair::device::emulation::Time_ns;

    explicit Rehearsal(int units) : chain(midair::device::emulation::ChainOptions())
    {
        chain.units = units;
        chain.settle_ns = 20'000'000;
        options.units = units;
        options.silencer = {1, 1};
        options.lead_s = 15e-3; // tests are run where much else is
        options.failsafe_s = 3;
        for (int k = 0; k < units; ++k)
            options.order.push_back(k);
        options.silent.resize(static_cast<std::size_t>(units));
    }

    void open()
    {
        using namespace midair::device;
        if (!units) units = std::make_shared<emulation::EmulatedUnits>(chain);
        device = std::make_unique<autd3::Autd3Device>(
            DeviceLayout{transducers(), {}},
            options,
            false,
            [this](const std::function<bool()>&)
            { return std::make_unique<emulation::EmulatedLink>(units); });
    }

    int transducers() const { return options.units * midair::device::autd3::kTransducersPerUnit; }

    /// A field of full drive that has \a level as phase everywhere.
    midair::device::DriveSignal even(int level) const
    {
        midair::device::DriveSignal signal = midair::device::silentSignal(transducers());
        signal.phase.assign(signal.phase.size(), static_cast<std::uint8_t>(level));
        signal.duty.assign(signal.duty.size(), 255);
        return signal;
    }
    /// One in which all levels occur, other ones for each \a number.
    midair::device::DriveSignal mixed(int number) const
    {
        midair::device::DriveSignal signal = midair::device::silentSignal(transducers());
        for (std::size_t i = 0; i < signal.phase.size(); ++i)
        {
            signal.phase[i] = static_cast<std::uint8_t>(7 * i + 13 * static_cast<unsigned>(number));
            signal.duty[i] =
                static_cast<std::uint8_t>(1 + (i + static_cast<unsigned>(number)) % 255);
        }
        return signal;
    }

    template<typename Use>
    auto with(const Use& use)
    {
        return units->with(use);
    }
    midair::device::DriveSignal field()
    {
        return with([](Chain& c, Time_ns now_ns) { return c.field(now_ns); });
    }
    midair::device::emulation::ChainReport report()
    {
        return with([](Chain& c, Time_ns now_ns) { return c.report(now_ns); });
    }
    /// Those that were published wholly after this was asked for: the processor's time in them
    /// tells one publication from the next.
    midair::device::autd3::Autd3Device::Figures figures() const
    {
        for (int publications = 0; publications < 2; ++publications)
            eventually([&, before_s = device->figures().cpu_s]
                       { return device->figures().cpu_s > before_s; });
        return device->figures();
    }
    /// Switches that the device knows to have come too late.
    std::uint64_t torn() const { return figures().torn; }
    /// Waits until \a count more datagrams came from the host, which sends some all the time.
    bool hears(std::uint64_t count)
    {
        return eventually([this, wanted = report().fromHost + count]
                          { return report().fromHost >= wanted; });
    }
    void happen(midair::device::emulation::ChainFaults::Kind kind, int unit = 0)
    {
        with(
            [&](Chain& c, Time_ns now_ns)
            {
                c.happen(kind, unit, now_ns);
                return 0;
            });
    }
    void setFaults(const midair::device::emulation::ChainFaults& faults)
    {
        with(
            [&](Chain& c, Time_ns)
            {
                c.setFaults(faults);
                return 0;
            });
    }
    bool plays(const midair::device::DriveSignal& signal)
    {
        const midair::device::DriveSignal now = field();
        return now.phase == signal.phase && now.duty == signal.duty;
    }
    bool isSilent()
    {
        const midair::device::DriveSignal now = field();
        return now.duty == std::vector<std::uint8_t>(now.duty.size(), 0);
    }

    bool eventuallyPlays(const midair::device::DriveSignal& signal)
    {
        return eventually([&] { return plays(signal); });
    }
    /// Tells the watch of the field mixed(\a n) and sends it; returns what the device does.
    bool sendWatched(int n)
    {
        const midair::device::DriveSignal signal = mixed(n);
        with(
            [&](Chain& watched, Time_ns)
            {
                watched.watch().expect(static_cast<std::uint64_t>(n), signal);
                return 0;
            });
        return device->send(signal);
    }
    bool settles()
    {
        return eventually([&] { return device->report().pending == 0; });
    }

    midair::device::emulation::ChainOptions chain;
    midair::device::autd3::Autd3Options options;
    std::shared_ptr<midair::device::emulation::EmulatedUnits> units;
    std::unique_ptr<midair::device::autd3::Autd3Device> device;
};
