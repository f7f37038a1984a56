#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/scene/PaintReader.h"

#include <osgMidair/HapticProperty>

namespace osgMidair
{

/// Returns the part of \a property that goes to the hologram thread with each object.
midair::bridge::HapticProperties forBridge(const HapticProperty& property);

/// Returns the part of \a property that describes the paint of the mesh.
midair::bridge::PaintOptions paintOf(const HapticProperty& property);

} // namespace osgMidair
