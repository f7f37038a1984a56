#include "device/limits/UserLimits.h"

#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "haptics/base/Limits.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Range.h"

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

void checkLimits(const SafetyLimits& limits)
{
    std::string error;
    const bool good =
        base::RangeCheck("device limits: ")
            .within("maxAmplitude", limits.maxAmplitude, 0, 1)
            .within("ramp", limits.ramp_s, 0, 10, " s")
            .within("meanDrive", limits.meanDrive, 0, 1)
            .above("meanDriveTime", limits.meanDriveTime_s, 0, " s")
            .atLeast("hold", limits.hold_s, 0, " s")
            .within("maxPressure", limits.maxPressure_Pa, 0, base::kMostPressure_Pa, " Pa")
            .passed(&error);
    if (!good) throw DeviceError(error);
}

SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits)
{
    SafetyLimits strict = limits;
    strict.maxAmplitude = std::min(limits.maxAmplitude, uri.takeNumber("max-amplitude", 1, 0, 1));
    strict.ramp_s = std::max(limits.ramp_s, uri.takeSeconds("ramp", 0));
    strict.meanDrive = std::min(limits.meanDrive, uri.takeNumber("mean-drive", 1, 0, 1));
    strict.meanDriveTime_s = uri.takeSeconds("mean-drive-time", limits.meanDriveTime_s);
    strict.maxPressure_Pa = stricterPressure(
        limits.maxPressure_Pa, uri.takeNumber("max-pressure", 0, 1, base::kMostPressure_Pa));
    const double hold_s = uri.takeSeconds("hold", 0);
    if (hold_s > 0) strict.hold_s = limits.hold_s > 0 ? std::min(limits.hold_s, hold_s) : hold_s;
    return strict;
}

double stricterPressure(double a_Pa, double b_Pa)
{
    return a_Pa > 0 && b_Pa > 0 ? std::min(a_Pa, b_Pa) : std::max(a_Pa, b_Pa);
}

} // namespace midair::device
