#pragma once

#include "haptics/base/text/MessageLog.h"

#include <osgMidair/HapticSettings>

#include <vector>

namespace osgMidair
{

/// Replaces what is real in \a settings: devices by the simulated one, tracked hands by none.
/// Returns what is wrong with the names of these, as nobody tries to open them.
std::vector<midair::base::Message> rehearse(HapticSettings& settings);

} // namespace osgMidair
