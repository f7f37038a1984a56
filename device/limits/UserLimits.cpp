#include "device/limits/UserLimits.h"

#include "device/limits/GuardedDevice.h"
#include "haptics/base/Limits.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Quantity.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

/// Calls \a keep with each value that the variable \a name has, in \a unit.
template<typename Keep>
void readCap(const char* name, const char* unit, double most, Keep keep)
{
    for (const auto& text : {base::userVariable(name), base::variableNow(name)})
    {
        if (!text) continue;
        double value = 0;
        if (!base::parseQuantity(*text, unit, value) || !(value >= 0) || value > most)
            throw DeviceError(
                fmt::format("{} is \"{}\", should be 0 .. {:g}{}{}; nothing is played",
                            name,
                            *text,
                            most,
                            *unit ? " " : "",
                            unit));
        keep(value);
    }
}

} // namespace

SafetyLimits limitsOfUser()
{
    SafetyLimits limits;
    readCap("OSG_MIDAIR_MAX_AMPLITUDE",
            "",
            1,
            [&](double value) { limits.maxAmplitude = std::min(limits.maxAmplitude, value); });
    readCap("OSG_MIDAIR_MAX_PRESSURE",
            "Pa",
            base::kMostPressure_Pa,
            [&](double value)
            { limits.maxPressure_Pa = stricterPressure(limits.maxPressure_Pa, value); });
    return limits;
}

} // namespace midair::device
