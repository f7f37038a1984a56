#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/FieldSettings>

namespace midair::haptics
{

/// The settings of a solver, with their ranges.
const base::SettingTable<SolverSettings>& solverSettings();

} // namespace midair::haptics
