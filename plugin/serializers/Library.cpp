#include <osgDB/Registry>

// A static build names the library and its wrappers with USE_SERIALIZER_WRAPPER.
USE_SERIALIZER_WRAPPER(osgMidair_HapticOverlays)
USE_SERIALIZER_WRAPPER(osgMidair_HapticPoints)
USE_SERIALIZER_WRAPPER(osgMidair_HapticScene)
USE_SERIALIZER_WRAPPER(osgMidair_HapticSurface)
USE_SERIALIZER_WRAPPER(osgMidair_Properties)

extern "C" void wrapper_serializer_library_osgMidair(void) {}
