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
    using Set = void (HapticOverlays::*)(bool);
    using Get = bool (HapticOverlays::*)() const;
    const std::pair<Set, Get> switches[] = {
        {&HapticOverlays::setShowControlPoints, &HapticOverlays::getShowControlPoints},
        {&HapticOverlays::setShowFieldSlice, &HapticOverlays::getShowFieldSlice},
        {&HapticOverlays::setShowArray, &HapticOverlays::getShowArray},
        {&HapticOverlays::setShowWorkspace, &HapticOverlays::getShowWorkspace},
        {&HapticOverlays::setShowFigures, &HapticOverlays::getShowFigures},
        {&HapticOverlays::setShowFieldVolume, &HapticOverlays::getShowFieldVolume},
        {&HapticOverlays::setShowHands, &HapticOverlays::getShowHands},
        {&HapticOverlays::setShowExposure, &HapticOverlays::getShowExposure}};
    for (const auto& [set, get] : switches)
    {
        osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
        (overlays.get()->*set)(!(overlays.get()->*get)());
        overlays->setName("seen");
        const auto back = read(written(*overlays, GetParam()), GetParam());
        ASSERT_TRUE(back);
        EXPECT_EQ(back->getName(), "seen");
        for (const auto& [otherSet, otherGet] : switches)
            EXPECT_EQ((back.get()->*otherGet)(), (overlays.get()->*otherGet)());
    }
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         OverlaysSerialization,
                         ::testing::Values("Ascii", "XML", "Binary"));
