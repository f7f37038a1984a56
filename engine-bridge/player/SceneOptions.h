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

/// What Render::INHERIT stands for in a scene whose setting is \a render.
Render renderOf(SceneSettings::Render render);

/// The kit's materials and the user's; read once, when the first object names one.
const MaterialLibrary& materials();

/// What an object is made of: its material with the numbers that it has of its own.
struct ObjectMaterial
{
    HapticMaterial material;
    std::string problem;    ///< why it isn't felt where it is touched; empty: it is
    bool isUnknown = false; ///< that is since its name is
};
ObjectMaterial materialOf(const ObjectSettings& settings);

/// The part of \a settings that goes to the pipeline with each object, felt as \a material.
HapticProperties propertiesOf(const ObjectSettings& settings, const HapticMaterial& material);

/// \a settings with what \a limits restrict beyond them.
SceneSettings restricted(SceneSettings settings, const device::UserCaps& limits);

/// The pipeline's options for \a settings, without array, device and owner. \a temperature_C: of
/// the air. Listening places that can't be read are left out.
HologramOptions optionsOf(const SceneSettings& settings, double temperature_C);

} // namespace midair::bridge
