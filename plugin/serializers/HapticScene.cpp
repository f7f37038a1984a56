#include "plugin/serializers/SettingSerializer.h"
#include "plugin/serializers/Wrappers.h"

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

void osgMidair::registerHapticScene()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticScene; },
        "osgMidair",
        "osgMidair::HapticScene",
        "osgMidair::Properties osg::Object osg::Node osg::Group osgMidair::HapticScene",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            addFormatVersion(*wrapper);
            addSettings<HapticScene, HapticSettings>(
                *wrapper,
                sceneSettings(),
                [](const HapticScene& node) -> const HapticSettings& { return node.getSettings(); },
                [](HapticScene& node, const HapticSettings& all) { node.setSettings(all); });
            wrapper->addSerializer(new EndOfScene,
                                   osgDB::BaseSerializer::RW_USER); // must stay last
        });
}
