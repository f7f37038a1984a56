#include "haptics/sequence/LineRate.h"

#include "haptics/base/InputError.h"

#include <cmath>

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

} // namespace

void LineRate::fit(ModulatorOptions& modulation, double frequency_Hz) const
{
    if (_carried <= 0.0) return;
    if (_carried < _aPeriod * frequency_Hz)
        throw base::InputError(fmt::format(
            "modulation of {:g} Hz needs {:g} fields/s; the device carries {:g}: at most {:g} Hz",
            frequency_Hz,
            _aPeriod * frequency_Hz,
            downToTenth(_carried),
            downToTenth(_carried / _aPeriod)));
    if (!isSlowerThan(modulation.fieldRate_Hz)) return;
    modulation.fieldRate_Hz =
        frequency_Hz > 0.0 ? frequency_Hz * std::floor(_carried / frequency_Hz) : _carried;
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
