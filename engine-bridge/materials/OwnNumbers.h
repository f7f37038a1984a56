#pragma once

#include "engine-bridge/HapticMaterial.h"

namespace midair::bridge
{

/// Replaces those numbers of \a material that \a property, of an object in a scene's file or in the
/// C interface, has of its own: those that aren't 0.
template<typename P>
void replaceNumbers(HapticMaterial& material, const P& property)
{
    const auto replace = [](double own, double& value)
    {
        if (own != 0.0) value = own;
    };
    replace(property.stiffness, material.stiffness_N_m);
    replace(property.contactForce, material.mostForce_N);
    replace(property.softness, material.radiusGrowth);
    replace(property.roughness, material.roughness);
    replace(property.texturePeriod, material.texturePeriod_m);
    replace(property.lowVibration, material.lowVibration);
    replace(property.highVibration, material.highVibration);
    constexpr double kLeastRadius_m = 1e-3; // that grows
    if (property.softness > 0.0 && !(material.radius_m > 0.0)) material.radius_m = kLeastRadius_m;
}

} // namespace midair::bridge
