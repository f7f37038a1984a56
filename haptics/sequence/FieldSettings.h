#pragma once

#include "haptics/array/Medium.h"
#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/FieldSettings>

namespace midair::haptics
{

/// All settings of fields, including the solver's, with their ranges.
const base::SettingTable<FieldSettings>& fieldSettings();

/// Returns the air described by \a settings.
Medium mediumOf(const FieldSettings& settings);

} // namespace midair::haptics
