#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticOverlays>

#include <osgDB/Registry>

#include <sstream>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

std::string written(const osg::Node& node, const std::string& type)
{
    findPlugins();
    osgDB::ReaderWriter* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    EXPECT_TRUE(format->writeNode(node, stream, new osgDB::Options("fileType=" + type)).success());
    return stream.str();
}

osg::ref_ptr<HapticOverlays> read(const std::string& content, const std::string& type)
{
    osgDB::ReaderWriter* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    std::stringstream stream(content, std::ios::in | std::ios::binary);
    const osg::ref_ptr<osg::Node> node =
        format->readNode(stream, new osgDB::Options("fileType=" + type)).takeNode();
    return dynamic_cast<HapticOverlays*>(node.get());
}

} // namespace

class OverlaysSerialization : public ::testing::TestWithParam<const char*>
{
};

TEST_P(OverlaysSerialization, EverySwitchComesBack)
{
    for (const OverlayDescription& one : HapticOverlays::describe())
    {
        osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
        ASSERT_TRUE(overlays->setShown(one.word, !overlays->isShown(one.name)));
        overlays->setName("seen");
        const auto back = read(written(*overlays, GetParam()), GetParam());
        ASSERT_TRUE(back);
        EXPECT_EQ(back->getName(), "seen");
        for (const OverlayDescription& other : HapticOverlays::describe())
            EXPECT_EQ(back->isShown(other.word), overlays->isShown(other.name)) << other.name;
    }
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         OverlaysSerialization,
                         ::testing::Values("Ascii", "XML", "Binary"));
