#include <osgMidair/HapticOverlays>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

// Not written as a Group: its children are its own affair. .osgb is positional: this order is frozen.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticOverlays,
                               new osgMidair::HapticOverlays,
                               osgMidair::HapticOverlays,
                               "osg::Object osg::Node osgMidair::HapticOverlays")
{
    ADD_BOOL_SERIALIZER(ShowControlPoints, true);
    ADD_BOOL_SERIALIZER(ShowFieldSlice, true);
    ADD_BOOL_SERIALIZER(ShowArray, true);
    ADD_BOOL_SERIALIZER(ShowWorkspace, true);
    ADD_BOOL_SERIALIZER(ShowFigures, true);
}
