#pragma once

#include "haptics/array/Medium.h"

#include <string>

namespace midair::bridge
{

/// How hard a contact presses; isValid() names the first setting that is out of its range.
///
/// The defaults are those of a finger pad on an object that feels soft: 20 mN, which foci turning
/// slowly make feel like 0.24 N (Morisaki et al., arXiv 2301.11572), at 2 mm depth.
struct ContactForceOptions
{
    double stiffness_N_m = 10.0; ///< 0 .. 1e4; applied force over depth
    double mostForce_N = 0.02;   ///< 0 .. 1; where the force stops growing
    /// 1e-6 .. 1e-3; area that a focus presses on: 4.3 x 9.2 mm at half pressure, of the octagon
    double focusArea_m2 = 22e-6;
    double alpha = 2.0;   ///< 1 .. 2; reflection by skin; 2: total
    double ramp_s = 0.02; ///< 0 .. 1; a contact's pressure grows over this time, so as not to click

    bool isValid(std::string* error = nullptr) const;
};

/// From depth to pressure: F = stiffness depth, clipped, shared out among the foci; the peak
/// pressure of each is sqrt(2 rho c^2 F / (alpha A)), as radiation pressure is alpha p^2 / (2 rho
/// c^2) (Inoue, Makino, Shinoda 2015, equation 1).
class ContactForce
{
public:
    /// Throws InputError for options or a medium that are not valid.
    explicit ContactForce(const ContactForceOptions& options = {},
                          const haptics::Medium& medium = {});

    /// N; 0 for depths that aren't above 0 or not finite.
    double force_N(double depth_m) const;
    /// Pa, peak; of each of \a foci (>= 1) foci \a age_s after the contact began. Of foci of which
    /// some fade it is the sum of their weights' squares, so that the force stays. 0 for numbers
    /// that aren't finite.
    double pressure_Pa(double depth_m, double foci, double age_s) const;

    const ContactForceOptions& options() const { return _options; }

private:
    ContactForceOptions _options;
    double _rhoCC_Pa = 0.0; ///< rho c^2
};

} // namespace midair::bridge
