#include "haptics/sequence/LineRate.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"

#include <cmath>

namespace midair::haptics
{

namespace
{

// Rounds down, so that the text never promises too much.
std::string downToTenth(double value)
{
    return base::shortNumber(std::floor(10.0 * value) / 10.0);
}

} // namespace

void LineRate::fit(ModulatorOptions& modulation, double frequency_Hz) const
{
    if (_carried <= 0.0) return;
    if (_carried < _aPeriod * frequency_Hz)
        throw base::InputError("modulation of " + base::shortNumber(frequency_Hz) + " Hz needs " +
                               base::shortNumber(_aPeriod * frequency_Hz) +
                               " fields/s; the device carries " + downToTenth(_carried) +
                               ": at most " + downToTenth(_carried / _aPeriod) + " Hz");
    if (!isSlowerThan(modulation.fieldRate_Hz)) return;
    modulation.fieldRate_Hz =
        frequency_Hz > 0.0 ? frequency_Hz * std::floor(_carried / frequency_Hz) : _carried;
}

std::string LineRate::message(const ModulatorOptions& played, const ModulatorOptions& asked) const
{
    return "fields in turn follow each other at " + base::shortNumber(played.fieldRate_Hz) +
           " a second, not " + base::shortNumber(asked.fieldRate_Hz) + ": the device carries " +
           downToTenth(_carried);
}

} // namespace midair::haptics
