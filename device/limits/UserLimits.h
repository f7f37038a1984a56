#pragma once

#include "device/ArrayDevice.h"

namespace midair::device
{

/// Returns the caps that the user's environment sets for whatever plays without a scene, where a
/// scene would keep them: OSG_MIDAIR_MAX_AMPLITUDE (0 .. 1) and OSG_MIDAIR_MAX_PRESSURE (Pa, peak,
/// 0 .. 1e6; 0: none), each as it was when the program began and as it is now, the stricter of
/// both. The other limits are those of SafetyLimits(). Throws DeviceError for one that isn't
/// understood: nothing may be played then.
SafetyLimits limitsOfUser();

} // namespace midair::device
