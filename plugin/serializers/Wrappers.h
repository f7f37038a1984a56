#pragma once

namespace osgMidair
{

// Each makes one of the kit's classes known to OSG's readers and writers, the first time that it is
// called. A class's own file of this folder defines it.
void registerProperties();
void registerHapticScene();
void registerHapticSurface();
void registerHapticPoints();
void registerHapticOverlays();

} // namespace osgMidair
