#include "engine-bridge/playing/LineRate.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"

#include <cmath>

namespace midair::bridge
{

namespace
{

// Never more than it is.
std::string downToTenth(double value)
{
    return base::shortNumber(std::floor(10.0 * value) / 10.0);
}

} // namespace

LineRate::LineRate(const device::DriveAbility& ability) :
    _carried(ability.fieldsPerSecond),
    _aPeriod(ability.amplitudes.size() == 2 ? 2 : 4)
{
}

void LineRate::fit(haptics::ModulatorOptions& modulation, double frequency_Hz) const
{
    if (_carried <= 0.0) return;
    if (_carried < _aPeriod * frequency_Hz)
        throw base::InputError("modulation of " + base::shortNumber(frequency_Hz) + " Hz needs " +
                               base::shortNumber(_aPeriod * frequency_Hz) +
                               " fields/s; the device carries " + text() + ": at most " +
                               downToTenth(_carried / _aPeriod) + " Hz");
    if (!isSlowerThan(modulation.fieldRate_Hz)) return;
    modulation.fieldRate_Hz =
        frequency_Hz > 0.0 ? frequency_Hz * std::floor(_carried / frequency_Hz) : _carried;
}

std::string LineRate::text() const
{
    return downToTenth(_carried);
}

} // namespace midair::bridge
