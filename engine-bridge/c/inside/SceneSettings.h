#pragma once

#include "device/limits/UserLimits.h"
#include "engine-bridge/HapticObject.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/FieldSettings>

#include <Eigen/Core>

#include <string>

namespace midair::capi
{

/// The settings of a scene of the C interface: those of a scene's files that need no scene graph,
/// with their names, ranges and defaults.
struct SceneSettings : haptics::FieldSettings
{
    bool enabled = true;
    double reach = 0.0; ///< m, 0 .. 10
    bool shadows = false;
    std::string earPoints; ///< "x y z; x y z ..", m, array frame; at most 64
    bridge::Render render = bridge::Render::OBJECT;
    double contactRate = 5.0;  ///< Hz, 0 .. 100
    double contactStep = 5e-4; ///< m, 5e-5 .. 5e-3
    int contactFoci = 10;      ///< 1 .. 10
    bool contactMask = false;
    double trackerError = 5e-3; ///< m, 0 .. 0.1
};

const base::SettingTable<SceneSettings>& sceneTable();

/// Reads "0 0 0.6; 30 0 60 cm" into \a places (3 x n, m), as base::parsePlaces() does.
bool readPlaces(const std::string& text, Eigen::Matrix3Xd& places);

/// The pipeline's options for \a settings, without array and device. The user's \a caps are in
/// them; one that isn't understood is an amplitude of 0, with a note.
bridge::HologramOptions optionsOf(const SceneSettings& settings, const device::UserCaps& caps);

} // namespace midair::capi
