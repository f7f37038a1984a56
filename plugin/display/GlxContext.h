#pragma once

#include "engine-bridge/hands/openxr/OpenXrView.h"

#include <string>

namespace osgMidair
{

/// The GLX context current on this thread, for OpenXR. \a error gets the reason if there is none;
/// otherwise it is empty.
midair::bridge::OpenXrGraphics currentGlx(std::string& error);

/// Turns off vertical sync of the current context's window: a headset has its own clock, and
/// waiting for both would be late for both.
void stopWaitingForScreen();

} // namespace osgMidair
