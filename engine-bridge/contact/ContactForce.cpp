#include "engine-bridge/contact/ContactForce.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

bool ContactForceOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactForceOptions: ")
        .within("stiffness_N_m", stiffness_N_m, 0.0, 1e4)
        .within("mostForce_N", mostForce_N, 0.0, 1.0)
        .within("focusArea_m2", focusArea_m2, 1e-6, 1e-3)
        .within("alpha", alpha, 1.0, 2.0)
        .within("ramp_s", ramp_s, 0.0, 1.0)
        .passed(error);
}

ContactForce::ContactForce(const ContactForceOptions& options, const haptics::Medium& medium) :
    _options(options)
{
    std::string error;
    if (!options.isValid(&error) || !medium.isValid(&error)) throw base::InputError(error);
    _rhoCC_Pa = medium.density() * medium.soundSpeed() * medium.soundSpeed();
}

double ContactForce::force_N(double depth_m) const
{
    if (!(depth_m > 0.0) || !std::isfinite(depth_m)) return 0.0;
    return std::min(_options.stiffness_N_m * depth_m, _options.mostForce_N);
}

// The ramp is of the pressure's amplitude, s^2 (3 - 2 s), so that it begins and ends without a
// kink.
double ContactForce::pressure_Pa(double depth_m, double foci, double age_s) const
{
    if (!(foci >= 1.0) || !std::isfinite(foci) || !(age_s >= 0.0)) return 0.0;
    const double s = _options.ramp_s > 0.0 ? std::min(age_s / _options.ramp_s, 1.0) : 1.0;
    const double whole = std::sqrt(2.0 * _rhoCC_Pa * force_N(depth_m) / foci /
                                   (_options.alpha * _options.focusArea_m2));
    return s * s * (3.0 - 2.0 * s) * whole;
}

} // namespace midair::bridge
