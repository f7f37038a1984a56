#include "plugin/serializers/SettingSerializer.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/HapticSurface>

void osgMidair::registerHapticSurface()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticSurface; },
        "osgMidair",
        "osgMidair::HapticSurface",
        "osgMidair::Properties osg::Object osg::Node osg::Group osgMidair::HapticSurface",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            addFormatVersion(*wrapper);
            addSettings<HapticSurface, HapticProperty>(
                *wrapper,
                surfaceProperties(),
                [](const HapticSurface& node) -> const HapticProperty&
                { return node.getProperty(); },
                [](HapticSurface& node, const HapticProperty& all) { node.setProperty(all); });
        });
}
