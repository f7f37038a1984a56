#include "plugin/serializers/SettingSerializer.h"

#include <osgMidair/HapticSurface>

// .osgb is positional: the format version says how many properties follow.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticSurface,
                               new osgMidair::HapticSurface,
                               osgMidair::HapticSurface,
                               "osgMidair::Properties osg::Object osg::Node"
                               " osg::Group osgMidair::HapticSurface")
{
    (void)domain; // unused parameter of the macro
    ADD_INT_SERIALIZER(FormatVersion, 0);
    osgMidair::addSettings<MyClass, osgMidair::HapticProperty>(
        *wrapper,
        osgMidair::surfaceProperties(),
        [](const MyClass& node) -> const osgMidair::HapticProperty& { return node.getProperty(); },
        [](MyClass& node, const osgMidair::HapticProperty& all) { node.setProperty(all); });
}
