#include "plugin/serializers/SettingSerializer.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/HapticSurface>

// .osgb is positional: the format version says how many properties follow.
void osgMidair::registerHapticSurface()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticSurface; },
        "osgMidair",
        "osgMidair::HapticSurface",
        "osgMidair::Properties osg::Object osg::Node osg::Group osgMidair::HapticSurface",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            using MyClass = HapticSurface; // for OSG's macro
            ADD_INT_SERIALIZER(FormatVersion, 0);
            addSettings<MyClass, HapticProperty>(
                *wrapper,
                surfaceProperties(),
                [](const MyClass& node) -> const HapticProperty& { return node.getProperty(); },
                [](MyClass& node, const HapticProperty& all) { node.setProperty(all); });
        });
}
