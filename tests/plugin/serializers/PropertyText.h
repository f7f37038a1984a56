#pragma once

// Text files with one node of the kit's, property by property.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <osgDB/ReadFile>

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace property_text
{

using namespace osgMidair;

/// A property as text files have it: its name, and what follows in .osgt and in .osgx.
struct Written
{
    std::string name;
    std::string plain;
    std::string xml;
};
using List = std::vector<Written>;

/// A property with one value.
inline Written scalar(const std::string& name, const std::string& value)
{
    std::string quoted = value;
    for (std::size_t at = 0; (at = quoted.find('"', at)) != std::string::npos; at += 6)
        quoted.replace(at, 1, "&quot;");
    return {name, value, "attribute=\"" + quoted + "\" />"};
}

/// The text of a file with one object that has \a list, and another one behind it.
inline std::string fileOf(const std::string& className, const List& list, bool isXml)
{
    std::ostringstream out;
    if (!isXml)
    {
        out << "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n\n"
            << "osg::Group { UniqueID 100 Children 2 {\nosgMidair::" << className
            << " {\n  UniqueID 1\n";
        for (const Written& one : list)
            out << "  " << one.name << " " << one.plain << "\n";
        out << "}\nosg::Node { UniqueID 101 Name \"behind\" } } }\n";
        return out.str();
    }
    out << "<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<Scene>\n<Version attribute=\"161\" />\n"
        << "<Generator attribute=\"OpenSceneGraph 3.6.5\" />\n<osg--Group><UniqueID "
        << "attribute=\"100\" /><Children attribute=\"2\">\n<osgMidair--" << className
        << ">\n<UniqueID attribute=\"1\" />\n";
    for (const Written& one : list)
        out << "<" << one.name << " " << one.xml << "\n";
    out << "</osgMidair--" << className << ">\n<osg--Node><UniqueID attribute=\"101\" /><Name "
        << "attribute=\"&quot;behind&quot;\" /></osg--Node></Children></osg--Group>\n</Scene>\n";
    return out.str();
}

inline osg::ref_ptr<osg::Node> parsed(const std::string& text, bool isXml)
{
    findPlugins();
    osgDB::ReaderWriter& format = *osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    std::istringstream in(text);
    const osg::ref_ptr<osgDB::Options> options =
        new osgDB::Options(isXml ? "fileType=XML" : "fileType=Ascii");
    return format.readNode(in, options).takeNode();
}

template<class N>
std::string nameOf()
{
    return osg::ref_ptr<N>(new N)->className();
}

/// Reads a file with \a list; null after a failure if what is behind the object was lost.
template<class N>
osg::ref_ptr<N> through(const List& list, bool isXml)
{
    const std::string file = fileOf(nameOf<N>(), list, isXml);
    const osg::ref_ptr<osg::Node> node = parsed(file, isXml);
    osg::Group* group = node ? node->asGroup() : nullptr;
    EXPECT_TRUE(group && group->getNumChildren() == 2) << file;
    if (!group || group->getNumChildren() != 2) return nullptr;
    EXPECT_EQ(group->getChild(1)->getName(), "behind") << file;
    return dynamic_cast<N*>(group->getChild(0));
}

inline HapticSettings stateOf(const HapticScene& scene)
{
    return scene.getSettings();
}
inline HapticProperty stateOf(const HapticSurface& surface)
{
    return surface.getProperty();
}
inline HapticProperty stateOf(const HapticPoints& points)
{
    return points.getProperty();
}

} // namespace property_text
