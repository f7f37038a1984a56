#include "plugin/serializers/Wrappers.h"

#include <osgMidair/FileFormats>

namespace osgMidair
{

void registerSerializers()
{
    registerProperties();
    registerHapticScene();
    registerHapticSurface();
    registerHapticPoints();
    registerHapticOverlays();
}

} // namespace osgMidair
