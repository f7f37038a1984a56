#pragma once

#include <string>

namespace midair::bridge
{

/// How an object feels where it is touched; isValid() names the first number that is out of its
/// range. The defaults are those of a soft thing without a texture.
struct HapticMaterial
{
    double stiffness_N_m = 10.0; ///< 0 .. 1e4; applied force over depth
    double mostForce_N = 0.02;   ///< 0 .. 1; where the force stops growing
    /// m; 0: foci circle on the patch's own ellipse; 1e-3 .. 0.02: on a circle of this radius where
    /// the touch begins, which grows with the depth
    double radius_m = 0.0;
    double radiusGrowth = 0.0; ///< 0 .. 10; metres of radius a metre of depth; it ends at 10 mm
    /// 0 .. 1e4, Hz/m; turns a second that a metre of depth adds; they end at 10 Hz
    double rateGrowth_Hz_m = 0.0;
    double roughness = 0.0;        ///< 0 .. 1; share of the pressure that the texture takes away
    double texturePeriod_m = 1e-3; ///< 1e-5 .. 1; wavelength of the texture
    double lowVibration = 0.0;     ///< 0 .. 1; share that a vibration of low_Hz takes away
    double low_Hz = 30.0;          ///< 1 .. 500
    double highVibration = 0.0;    ///< 0 .. 1
    double high_Hz = 150.0;        ///< 1 .. 500

    bool isValid(std::string* error = nullptr) const;
};

bool operator==(const HapticMaterial& a, const HapticMaterial& b);

} // namespace midair::bridge
