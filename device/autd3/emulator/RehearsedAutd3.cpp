#include "device/autd3/emulator/RehearsedAutd3.h"

#include "device/DeviceUri.h"
#include "device/autd3/Autd3Device.h"
#include "device/autd3/emulator/EmulatedLink.h"
#include "device/opening/DeviceRegistry.h"

#include <utility>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

// Opening should be as fast as for other simulations; real clocks settle within a second.
constexpr emulation::Time_ns kSettle_ns = 50 * emulation::kMillisecond_ns;

using emulation::EmulatedChain;
using emulation::EmulatedUnits;
using emulation::Time_ns;

/// The driver and its units.
class RehearsedAutd3 : public autd3::Autd3Device
{
public:
    RehearsedAutd3(const DeviceLayout& layout,
                   const autd3::Autd3Options& options,
                   bool wait,
                   const std::shared_ptr<EmulatedUnits>& units) :
        Autd3Device(layout,
                    options,
                    wait,
                    [units](const std::function<bool()>&)
                    { return std::make_unique<emulation::EmulatedLink>(units); }),
        _transducers(layout.transducers),
        _order(options.order),
        _units(units)
    {
    }

    std::string status() const override
    {
        const emulation::ChainReport seen =
            _units->with([](EmulatedChain& chain, Time_ns now_ns) { return chain.report(now_ns); });
        return fmt::format("sim: {}; the units saw {} changes together, {} torn, {} writes into a "
                           "bank that plays, {} tripped failsafes",
                           Autd3Device::status(),
                           seen.fields.whole,
                           seen.fields.torn,
                           seen.writesIntoBanks,
                           seen.trips);
    }

    std::vector<std::complex<float>> played() const override
    {
        const std::vector<std::complex<float>> byUnit =
            _units->with([](EmulatedChain& chain, Time_ns now_ns) { return chain.output(now_ns); });
        std::vector<std::complex<float>> q(static_cast<std::size_t>(_transducers));
        for (std::size_t unit = 0; unit < _order.size(); ++unit)
            std::copy_n(byUnit.begin() + unit * emulation::kUnitTransducers,
                        emulation::kUnitTransducers,
                        q.begin() + _order[unit] * emulation::kUnitTransducers);
        return q;
    }

private:
    const int _transducers;
    const std::vector<int> _order; ///< the board of each unit
    const std::shared_ptr<EmulatedUnits> _units;
};

std::unique_ptr<ArrayDevice> openRehearsedAutd3(DeviceUri& uri, const DeviceLayout& layout)
{
    for (const char* way : {"interface", "group"})
        if (uri.has(way))
            throw uri.error(fmt::format("\"{}\" is for units over UDP: \"autd3:?{}=..\"; those of "
                                        "sim: are in this program",
                                        way,
                                        way));
    const autd3::Autd3Options options = autd3::takeAutd3Options(uri, layout);
    const bool wait = uri.takeFlag("wait", false);
    emulation::ChainOptions defaults = emulation::ChainOptions::realistic(options.units);
    defaults.settle_ns = kSettle_ns;
    if (!options.timed) defaults.tolerance_ns = emulation::kMillisecond_ns;
    const emulation::ChainOptions chain = emulation::takeChainOptions(uri, defaults);
    uri.takeText("board", "");
    uri.rejectUnknown();
    return std::make_unique<RehearsedAutd3>(
        layout, options, wait, std::make_shared<EmulatedUnits>(chain));
}

} // namespace

void registerRehearsedAutd3()
{
    setRehearsedAutd3(openRehearsedAutd3);
}

} // namespace midair::device
