#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/base/settings/SettingTable.h"

#include <string>

namespace midair::capi
{

/// The properties of an object of the C interface: those of haptic objects in scene files, with
/// their names, ranges and defaults, but for paint, which a mesh has as the intensity of its
/// vertices.
struct ObjectProperties
{
    /// What a pressure is in.
    enum PressureUnit : int
    {
        RELATIVE,
        PASCAL
    };

    bool enabled = true;
    double pressure = 1.0; ///< 1e-6 .. 1e5, in the unit
    PressureUnit pressureUnit = RELATIVE;
    double spacing = 0.0; ///< m, 0.001 .. 1; 0: one wavelength
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
    bridge::Side side = bridge::Side::BOTH;
    int priority = 0;
    double modulationFrequency = 0.0; ///< Hz, 0 .. 500; 0: steady
    double modulationDepth = 1.0;     ///< 0 .. 1
    bool touchEvents = false;
    bridge::Render render = bridge::Render::INHERIT;
    std::string material;
    /// \{ In place of the material's; 0: as the material says.
    double stiffness = 0.0;
    double contactForce = 0.0;
    double softness = 0.0;
    double roughness = 0.0;
    double texturePeriod = 0.0;
    double lowVibration = 0.0;
    double highVibration = 0.0;
    /// \}
};

const base::SettingTable<ObjectProperties>& objectTable();

/// The part of \a properties that goes to the pipeline with each object. Fails, with the known
/// names, for an unknown material, and for one whose numbers don't go together.
bridge::HapticProperties forPipeline(const ObjectProperties& properties);

} // namespace midair::capi
