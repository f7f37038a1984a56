#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/scene/PaintReader.h"

#include <osgMidair/HapticProperty>

namespace osgMidair
{

/// What of \a property goes to the hologram thread with each object.
midair::bridge::HapticProperties forBridge(const HapticProperty& property);

/// What of it the mesh is painted by.
midair::bridge::PaintOptions paintOf(const HapticProperty& property);

} // namespace osgMidair
