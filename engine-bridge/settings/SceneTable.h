#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/ObjectSettings>
#include <osgMidair/SceneSettings>

namespace midair::bridge
{

/// All rows of SceneSettings.
const base::SettingTable<SceneSettings>& sceneTable();

/// All rows of ObjectSettings.
const base::SettingTable<ObjectSettings>& objectTable();

} // namespace midair::bridge
