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

/// Serializer without data. It is the last of a scene, and when read it passes the folder of the
/// file and applies the user's options.
class EndOfScene : public osgDB::BaseSerializer, public osgMidair::NamedProperties
{
public:
    EndOfScene() : osgDB::BaseSerializer(READ_WRITE_PROPERTY) {}

    const std::string& getName() const override
    {
        static const std::string name = "EndOfScene";
        return name;
    }
    std::vector<std::string> names() const override { return {}; }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        // OSG's reader puts the folder of the file first, unless it reads from a stream.
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

// .osgb is positional: the format version says how many settings follow.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticScene,
                               new osgMidair::HapticScene,
                               osgMidair::HapticScene,
                               "osgMidair::Properties osg::Object osg::Node"
                               " osg::Group osgMidair::HapticScene")
{
    (void)domain; // unused parameter of the macro
    ADD_INT_SERIALIZER(FormatVersion, 0);
    osgMidair::addSettings<MyClass, osgMidair::HapticSettings>(
        *wrapper,
        osgMidair::sceneSettings(),
        [](const MyClass& node) -> const osgMidair::HapticSettings& { return node.getSettings(); },
        [](MyClass& node, const osgMidair::HapticSettings& all) { node.setSettings(all); });
    wrapper->addSerializer(new EndOfScene, osgDB::BaseSerializer::RW_USER); // must stay last
}
