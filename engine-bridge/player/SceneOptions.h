#pragma once

#include "device/limits/UserLimits.h"
#include "engine-bridge/HapticObject.h"
#include "engine-bridge/materials/MaterialLibrary.h"
#include "engine-bridge/pipeline/HologramOptions.h"

#include <osgMidair/ObjectSettings>
#include <osgMidair/SceneSettings>

#include <string>

namespace midair::bridge
{

/// Returns the meaning of Render::INHERIT in a scene whose setting is \a render.
Render renderOf(SceneSettings::Render render);

/// Returns the kit's and the user's materials; they are read once, when an object first names one.
const MaterialLibrary& materials();

/// An object's material with the object's own numbers.
struct ObjectMaterial
{
    HapticMaterial material;
    std::string problem;    ///< why it isn't felt where touched; empty if it is
    bool isUnknown = false; ///< the reason is an unknown name
};
ObjectMaterial materialOf(const ObjectSettings& settings);

/// Returns the part of \a settings that the pipeline gets with each object, with \a material.
HapticProperties propertiesOf(const ObjectSettings& settings, const HapticMaterial& material);

/// Returns \a settings tightened by \a limits.
SceneSettings restricted(SceneSettings settings, const device::UserCaps& limits);

/// Returns the pipeline's options for \a settings, without array, device and owner. \a
/// temperature_C: of the air. Listening places that can't be parsed are left out.
HologramOptions optionsOf(const SceneSettings& settings, double temperature_C);

} // namespace midair::bridge
