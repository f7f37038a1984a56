#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/SceneSettings>

namespace midair::bridge
{

/// All rows of SceneSettings.
const base::SettingTable<SceneSettings>& sceneTable();

/// What follows from the settings that differ between \a a and \a b: values of base::Effect, joined
/// by |.
unsigned effectsOf(const SceneSettings& a, const SceneSettings& b);

} // namespace midair::bridge
