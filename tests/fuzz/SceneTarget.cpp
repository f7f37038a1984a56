#include "plugin/overlays/OverlayPart.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Notify>
#include <osgDB/ObjectWrapper>
#include <osgDB/Registry>

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

using namespace osgMidair;

namespace
{

using Serializer = osgDB::BaseSerializer;

/// Of no other version a binary file is read.
constexpr const char* kVersion = "FormatVersion";

struct Property
{
    std::string name;
    Serializer::Type type;
};

/// A class of ours, as its wrapper reads and writes it.
struct Class
{
    std::string name;
    std::vector<Property> properties; ///< in the order of binary files, behind the version
    /// Overlays: what follows by name, in binary files behind a byte that says how many there are.
    std::vector<Property> named;
    std::string binary;           ///< a whole .osgb file of it with all defaults
    std::size_t propertiesAt = 0; ///< where in it the first property is; the rest are properties
};

osgDB::ReaderWriter& format()
{
    return *osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
}

const osgDB::Options* optionsFor(const std::string& type)
{
    static const osg::ref_ptr<osgDB::Options> ascii = new osgDB::Options("fileType=Ascii");
    static const osg::ref_ptr<osgDB::Options> xml = new osgDB::Options("fileType=XML");
    static const osg::ref_ptr<osgDB::Options> binary = new osgDB::Options("fileType=Binary");
    return type == "Ascii" ? ascii.get() : type == "XML" ? xml.get() : binary.get();
}

std::string written(const osg::Node& node, const std::string& type)
{
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    require(format().writeNode(node, stream, optionsFor(type)).success(),
            "what was read can be written");
    return stream.str();
}

osg::ref_ptr<osg::Node> read(const std::string& file, const std::string& type)
{
    std::istringstream stream(file, std::ios::in | std::ios::binary);
    return format().readNode(stream, optionsFor(type)).takeNode();
}

/// Bytes of a value in a binary file; 0: it says itself how many.
std::size_t bytesOf(Serializer::Type type)
{
    switch (type)
    {
    case Serializer::RW_BOOL:
        return 1;
    case Serializer::RW_DOUBLE:
        return sizeof(double);
    case Serializer::RW_MATRIXD:
        return 16 * sizeof(double);
    case Serializer::RW_STRING:
        return 0;
    default: // whole numbers and enumerations
        return sizeof(std::int32_t);
    }
}

Class describe(const osg::ref_ptr<osg::Node>& node, const std::string& defaults)
{
    Class c;
    c.name = std::string(node->libraryName()) + "::" + node->className();
    osgDB::ObjectWrapper* wrapper =
        osgDB::Registry::instance()->getObjectWrapperManager()->findWrapper(c.name);
    require(wrapper != nullptr, "the kit's serializers are found");
    c.binary = written(*node, "Binary");
    std::size_t length = defaults.size();
    for (std::size_t i = 0; i < wrapper->getSerializerList().size(); ++i)
    {
        if (wrapper->getTypeList()[i] == Serializer::RW_USER) continue; // nothing of fixed length
        if (wrapper->getSerializerList()[i]->getName() == kVersion) continue;
        c.properties.push_back(
            {wrapper->getSerializerList()[i]->getName(), wrapper->getTypeList()[i]});
        const Serializer::Type type = c.properties.back().type;
        length += type == Serializer::RW_STRING    ? sizeof(std::int32_t)
                  : type == Serializer::RW_MATRIXD ? bytesOf(type) + sizeof(std::int64_t)
                                                   : bytesOf(type);
    }
    if (dynamic_cast<const HapticOverlays*>(node.get()))
        for (const auto& [place, kind] : overlayKinds())
        {
            c.named.push_back({"Show" + kind.name, Serializer::RW_BOOL});
            for (const OverlayNumber& number : kind.numbers)
                c.named.push_back({number.storedName(), Serializer::RW_DOUBLE});
        }
    if (!c.named.empty()) ++length; // that there are none
    require(length < c.binary.size(), "properties are a file's end");
    c.propertiesAt = c.binary.size() - length;
    return c;
}

const Class& classOf(std::uint8_t choice)
{
    static const std::array<Class, 3> classes = []
    {
        osg::setNotifyLevel(osg::ALWAYS);
        osgDB::Registry::instance()->getLibraryFilePathList().push_front(MIDAIR_LIBRARY_FOLDER);
        HapticSettings settings;
        return std::array<Class, 3>{
            describe(new HapticScene,
                     settings.array + settings.device + settings.solver + settings.hands),
            describe(new HapticSurface, HapticProperty().attach),
            describe(new HapticOverlays, "")};
    }();
    return classes[choice % classes.size()];
}

/// What is left of the input.
struct Source
{
    const std::uint8_t* at;
    std::size_t left;

    std::uint8_t byte()
    {
        if (left == 0) return 0;
        --left;
        return *at++;
    }
    /// \a count of them, zeros where there are none left.
    std::string bytes(std::size_t count)
    {
        std::string taken(count, '\0');
        for (char& c : taken)
            c = static_cast<char>(byte());
        return taken;
    }
    /// Up to the line's end.
    std::string line()
    {
        std::string taken;
        while (left > 0)
        {
            const char c = static_cast<char>(byte());
            if (c == '\n') break;
            taken += c;
        }
        return taken;
    }
};

template<typename T>
void append(std::string& file, T value)
{
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(T));
    file.append(bytes.data(), bytes.size());
}

std::string binaryFile(const Class& c, Source& source)
{
    std::string values;
    for (const Property& property : c.properties)
    {
        if (property.type == Serializer::RW_STRING)
        {
            const std::string text = source.bytes(source.byte());
            append(values, static_cast<std::int32_t>(text.size()));
            values += text;
            continue;
        }
        if (property.type == Serializer::RW_MATRIXD)
            append(values, static_cast<std::int64_t>(sizeof(std::int64_t) + 16 * sizeof(double)));
        values += source.bytes(bytesOf(property.type));
    }
    if (!c.named.empty())
    {
        const std::uint8_t count = source.byte();
        values += static_cast<char>(count);
        for (int i = 0; i < count; ++i)
        {
            // A name that is known, or any.
            const std::uint8_t choice = source.byte();
            const std::string name =
                choice < c.named.size() ? c.named[choice].name : source.bytes(source.byte());
            append(values, static_cast<std::int32_t>(name.size()));
            values += name + source.bytes(sizeof(double));
        }
    }
    std::string file = c.binary.substr(0, c.propertiesAt);
    // The object's name is followed by how long it is, itself included.
    const std::size_t lengthAt = file.find(c.name) + c.name.size();
    std::string length;
    append(length, static_cast<std::int64_t>(file.size() - lengthAt + values.size()));
    return file.replace(lengthAt, length.size(), length) + values;
}

/// A value as OSG's text formats have it: what would end it or the file's structure is left out.
std::string textValue(const Property& property, const std::string& line)
{
    std::string value;
    for (const char c : line)
    {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 32 || c == '{' || c == '}' || c == '"' || c == '\\' || c == '<' || c == '>' ||
            c == '&')
            continue;
        value += c;
    }
    if (property.type == Serializer::RW_STRING) return "\"" + value + "\"";
    // More or fewer words than a value has are the reader's business.
    std::istringstream words(value);
    const int count = property.type == Serializer::RW_MATRIXD ? 16 : 1;
    std::string kept;
    for (int i = 0; i < count; ++i)
    {
        std::string word;
        words >> word;
        kept += (i == 0 ? "" : " ") + (word.empty() ? "0" : word);
    }
    return property.type == Serializer::RW_MATRIXD ? "{\n" + kept + "\n}" : kept;
}

std::vector<Property> inText(const Class& c)
{
    std::vector<Property> all = {{kVersion, Serializer::RW_INT}};
    all.insert(all.end(), c.properties.begin(), c.properties.end());
    all.insert(all.end(), c.named.begin(), c.named.end());
    return all;
}

std::string asciiFile(const Class& c, Source& source)
{
    std::string file = "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n" + c.name +
                       " {\n  UniqueID 1\n";
    for (const Property& property : inText(c))
    {
        const std::string line = source.line();
        if (!line.empty()) file += "  " + property.name + " " + textValue(property, line) + "\n";
    }
    return file + "}\n";
}

std::string xmlFile(const Class& c, Source& source)
{
    std::string name = c.name;
    name.replace(name.find("::"), 2, "--");
    std::string file = "<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<Scene>\n"
                       "<Version attribute=\"161\" />\n<Generator attribute=\"OpenSceneGraph "
                       "3.6.5\" />\n<" +
                       name + ">\n<UniqueID attribute=\"1\" />\n";
    for (const Property& property : inText(c))
    {
        const std::string line = source.line();
        if (line.empty()) continue;
        std::string value = textValue(property, line);
        if (property.type == Serializer::RW_STRING)
            value = "&quot;" + value.substr(1, value.size() - 2) + "&quot;";
        const bool block = property.type == Serializer::RW_MATRIXD;
        if (block) value = value.substr(2, value.size() - 4);
        file += "<" + property.name + (block ? " text=\"" : " attribute=\"") + value + "\" />\n";
    }
    return file + "</" + name + ">\n</Scene>\n";
}

template<typename T>
void requireRepairs(T values)
{
    values.repair();
    require(values.repair().empty(), "what was repaired is in range");
}

void check(osg::Node* node)
{
    if (const auto* scene = dynamic_cast<HapticScene*>(node)) requireRepairs(scene->getSettings());
    if (const auto* surface = dynamic_cast<HapticSurface*>(node))
        requireRepairs(surface->getProperty());
}

} // namespace

void fuzzScene(const std::uint8_t* data, std::size_t size)
{
    if (size < 2) return;
    Source source{data + 2, size - 2};
    const Class& c = classOf(data[1]);
    const std::string type = data[0] == 'a' ? "Ascii" : data[0] == 'x' ? "XML" : "Binary";
    const std::string file = type == "Ascii" ? asciiFile(c, source)
                             : type == "XML" ? xmlFile(c, source)
                                             : binaryFile(c, source);
    const osg::ref_ptr<osg::Node> node = read(file, type);
    require(node != nullptr, "a file that is whole is read");
    check(node);
    for (const char* other : {"Ascii", "XML", "Binary"})
    {
        const osg::ref_ptr<osg::Node> again = read(written(*node, other), other);
        require(again != nullptr && std::string(again->className()) == node->className(),
                "what was written is read");
        check(again);
    }
}
