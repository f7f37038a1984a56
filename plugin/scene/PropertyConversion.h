#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/scene/PaintReader.h"

#include <osgMidair/HapticProperty>

#include <string>

namespace osgMidair
{

/// Returns the part of \a property that goes to the hologram thread with each object.
midair::bridge::HapticProperties forBridge(const HapticProperty& property);

/// Returns what is wrong with the material of \a property, so that nothing is felt where the object
/// is touched, or with the user's file of materials; empty: nothing.
std::string problemOfMaterial(const HapticProperty& property);

/// Returns the part of \a property that describes the paint of the mesh.
midair::bridge::PaintOptions paintOf(const HapticProperty& property);

} // namespace osgMidair
