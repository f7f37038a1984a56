#include "plugin/serializers/SettingSerializer.h"

#include <osgMidair/HapticScene>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <optional>
#include <string>

namespace
{

using osgMidair::HapticScene;

/// Nothing in the file: the end of it, when its folder and the user's options count.
class EndOfScene : public osgDB::BaseSerializer
{
public:
    EndOfScene() : osgDB::BaseSerializer(READ_WRITE_PROPERTY) {}

    const std::string& getName() const override
    {
        static const std::string name = "EndOfScene";
        return name;
    }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        // OSG's reader puts the file's folder in front, unless it reads from a stream.
        const osgDB::Options* options = is.getOptions();
        std::optional<std::string> folder;
        if (options && !options->getDatabasePathList().empty())
            folder = options->getDatabasePathList().front();
        static_cast<HapticScene&>(object).endReading(folder);
        return true;
    }

    bool write(osgDB::OutputStream&, const osg::Object&) override { return true; }
};

} // namespace

// .osgb is positional: the format's version says how many of the settings follow.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticScene,
                               new osgMidair::HapticScene,
                               osgMidair::HapticScene,
                               "osg::Object osg::Node osg::Group osgMidair::HapticScene")
{
    (void)domain; // a name of the macro
    ADD_INT_SERIALIZER(FormatVersion, 0);
    osgMidair::addSettings<MyClass>(
        *wrapper, osgMidair::sceneSettings(), &MyClass::getSettings, &MyClass::setSettings);
    wrapper->addSerializer(new EndOfScene, osgDB::BaseSerializer::RW_USER); // stays the last
}
