#include "haptics/sequence/LineRate.h"

#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Rounds down, so that a text never promises more than there is.
double downToTenth(double value)
{
    return std::floor(10.0 * value) / 10.0;
}

// Boards count the ticks of their clock that a step lasts in a byte.
constexpr double kMostTicks = 255.0;

} // namespace

// Returns the frequency that is played; 0: it can't be stored. Of the numbers of steps to a period
// that fit, the one whose frequency is nearest, and of those the largest.
double LineRate::store(ModulatorOptions& modulation, double frequency_Hz, int fields) const
{
    double best_Hz = 0.0;
    double stored_Hz = 0.0;
    for (int steps = _aPeriod; steps <= _stored; ++steps)
    {
        if (std::lcm(steps, fields) > _stored) continue;
        double rate_Hz = steps * frequency_Hz;
        if (steps > _aPeriod && rate_Hz > modulation.fieldRate_Hz) break;
        if (_clock_Hz > 0.0) rate_Hz = _clock_Hz / std::max(1.0, std::round(_clock_Hz / rate_Hz));
        if (_clock_Hz > 0.0 && rate_Hz * kMostTicks < _clock_Hz) continue;
        const double played_Hz = rate_Hz / steps;
        if (best_Hz > 0.0 && std::abs(played_Hz - frequency_Hz) >
                                 std::abs(best_Hz - frequency_Hz) + 1e-9 * frequency_Hz)
            continue;
        best_Hz = played_Hz;
        stored_Hz = rate_Hz;
    }
    if (best_Hz > 0.0) modulation.fieldRate_Hz = stored_Hz;
    return best_Hz;
}

double LineRate::fit(ModulatorOptions& modulation, double frequency_Hz, int fields) const
{
    if (_carried <= 0.0) return frequency_Hz;
    const bool isTooSlow =
        _carried < _aPeriod * frequency_Hz || isSlowerThan(modulation.fieldRate_Hz);
    if (isTooSlow && frequency_Hz > 0.0)
        if (const double stored_Hz = store(modulation, frequency_Hz, fields); stored_Hz > 0.0)
            return stored_Hz;
    if (_carried < _aPeriod * frequency_Hz)
        throw base::InputError(fmt::format(
            "modulation of {:g} Hz needs {:g} fields/s; the device carries {:g}: at most {:g} Hz",
            frequency_Hz,
            _aPeriod * frequency_Hz,
            downToTenth(_carried),
            downToTenth(_carried / _aPeriod)));
    if (isSlowerThan(modulation.fieldRate_Hz))
        modulation.fieldRate_Hz =
            frequency_Hz > 0.0 ? frequency_Hz * std::floor(_carried / frequency_Hz) : _carried;
    return frequency_Hz;
}

std::string LineRate::message(const ModulatorOptions& played, const ModulatorOptions& asked) const
{
    return fmt::format(
        "fields in turn follow each other at {:g} a second, not {:g}: the device carries {:g}",
        played.fieldRate_Hz,
        asked.fieldRate_Hz,
        downToTenth(_carried));
}

} // namespace midair::haptics
