#pragma once

#include "haptics/array/Medium.h"
#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/FieldSettings>

namespace midair::haptics
{

/// All settings of what is played, those of the solver too, with their ranges.
const base::SettingTable<FieldSettings>& fieldSettings();

/// The air that \a settings describe.
Medium mediumOf(const FieldSettings& settings);

} // namespace midair::haptics
