#include "haptics/base/text/Number.h"
#include "plugin/serializers/SettingSerializer.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSensation>
#include <osgMidair/HapticSurface>

#include <osg/Notify>
#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <optional>
#include <type_traits>

namespace
{

using osgMidair::HapticScene;

/// Serializer without data, the last of a scene. When read it passes the file's folder and applies
/// the user's options.
class EndOfScene : public osgMidair::NamedSerializer
{
public:
    EndOfScene() : NamedSerializer("EndOfScene") {}

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        // OSG's reader puts the file's folder first, unless it reads from a stream.
        const osgDB::Options* options = is.getOptions();
        std::optional<std::string> folder;
        if (options && !options->getDatabasePathList().empty())
            folder = options->getDatabasePathList().front();
        static_cast<HapticScene&>(object).endReading(folder);
        return true;
    }
};

using osgMidair::HapticPoints;

/// More entries than a scene can hold; a file that announces more is broken.
constexpr unsigned int kMost = 200000;
constexpr const char* kTooMany = "osgMidair: a HapticPoints with too many points";

/// Sets one entry of a list from its numbers.
void setEntry(osg::Vec3d& point, const double* numbers)
{
    point.set(numbers[0], numbers[1], numbers[2]);
}
void setEntry(double& pressure, const double* numbers)
{
    pressure = *numbers;
}

/// Reads a list from text: the number of entries, and in brackets \a each numbers per entry. If the
/// text is malformed the scene is silenced, because a pressure may have gone to another point.
template<class T>
void readPlain(osgDB::InputStream& in, std::vector<T>& list, std::size_t each)
{
    osgMidair::BlockReader& reader = osgMidair::BlockReader::of(in);
    double size = -1.0;
    midair::base::parseNumber(reader.readValue(), size);
    if (size > kMost) return in.throwException(kTooMany);
    const std::vector<std::string> words = reader.readWords();
    if (static_cast<double>(words.size()) != static_cast<double>(each) * size)
        return reader.complain("a list of points or pressures announces another number of entries "
                               "than it has: " +
                                   std::to_string(words.size()) + " numbers",
                               true);
    std::vector<double> numbers(words.size());
    for (std::size_t i = 0; i < words.size(); ++i)
        if (!midair::base::parseNumber(words[i], numbers[i]))
            return reader.complain("\"" + words[i] + "\" should be a number", true);
    list.resize(words.size() / each);
    for (std::size_t i = 0; i < list.size(); ++i)
        setEntry(list[i], numbers.data() + each * i);
}

template<class T>
bool readList(osgDB::InputStream& in, std::vector<T>& list)
{
    if (!in.isBinary())
    {
        readPlain(in, list, std::is_same_v<T, double> ? 1 : 3);
        return !in.getException();
    }
    unsigned int size = 0;
    in >> size >> in.BEGIN_BRACKET;
    if (size > kMost)
    {
        in.throwException(kTooMany);
        return false;
    }
    for (unsigned int i = 0; i < size && !in.getException(); ++i)
    {
        T value{};
        in >> value;
        list.push_back(value);
    }
    in >> in.END_BRACKET;
    return !in.getException();
}

template<class T>
bool writeList(osgDB::OutputStream& out, const std::vector<T>& list)
{
    out << static_cast<unsigned int>(list.size()) << out.BEGIN_BRACKET << std::endl;
    for (const T& value : list)
        out << value << std::endl;
    out << out.END_BRACKET << std::endl;
    return true;
}

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

void osgMidair::registerHapticSensation()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticSensation; },
        "osgMidair",
        "osgMidair::HapticSensation",
        "osgMidair::Properties osg::Object osg::Node osg::Group osgMidair::HapticSurface "
        "osgMidair::HapticSensation",
        [](const char*, osgDB::ObjectWrapper* /*wrapper*/) {});
}

void osgMidair::registerHapticPoints()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticPoints; },
        "osgMidair",
        "osgMidair::HapticPoints",
        "osgMidair::Properties osg::Object osg::Node osgMidair::HapticPoints",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            addFormatVersion(*wrapper);
            using Lists = osgDB::UserSerializer<HapticPoints>;
            wrapper->addSerializer(new Lists(
                                       "Points",
                                       [](const HapticPoints& node)
                                       { return !node.getPoints().empty(); },
                                       [](osgDB::InputStream& in, HapticPoints& node)
                                       {
                                           std::vector<osg::Vec3d> points;
                                           if (!readList(in, points)) return false;
                                           node.setPoints(points, node.getPressures());
                                           return true;
                                       },
                                       [](osgDB::OutputStream& out, const HapticPoints& node)
                                       { return writeList(out, node.getPoints()); }),
                                   osgDB::BaseSerializer::RW_USER);
            wrapper->addSerializer(new Lists(
                                       "Pressures",
                                       [](const HapticPoints& node)
                                       { return !node.getPressures().empty(); },
                                       [](osgDB::InputStream& in, HapticPoints& node)
                                       {
                                           std::vector<double> pressures;
                                           if (!readList(in, pressures)) return false;
                                           node.setPressures(pressures);
                                           return true;
                                       },
                                       [](osgDB::OutputStream& out, const HapticPoints& node)
                                       { return writeList(out, node.getPressures()); }),
                                   osgDB::BaseSerializer::RW_USER);
            addSettings<HapticPoints, HapticProperty>(
                *wrapper,
                surfaceProperties(),
                [](const HapticPoints& node) -> const HapticProperty&
                { return node.getProperty(); },
                [](HapticPoints& node, const HapticProperty& all) { node.setProperty(all); });
        });
}
