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

/// Before there were volume and hands, the last byte of an overlay was ShowFigures, 0 or 1.
TEST(OverlaysSerializationOfOldFiles, LastByteIsShowFigures)
{
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    const std::string shown = written(*overlays, "Binary");
    overlays->setShowFigures(false);
    const std::string hidden = written(*overlays, "Binary");
    ASSERT_EQ(shown.size(), hidden.size());
    std::vector<std::size_t> differing;
    for (std::size_t i = 0; i < shown.size(); ++i)
        if (shown[i] != hidden[i]) differing.push_back(i);
    ASSERT_EQ(differing.size(), 1U);
    EXPECT_EQ(shown[differing[0]], 1);
    EXPECT_EQ(hidden[differing[0]], 0);
    EXPECT_EQ(differing[0], shown.size() - 1);
    const auto back = read(hidden, "Binary");
    ASSERT_TRUE(back);
    EXPECT_FALSE(back->getShowFigures());
    EXPECT_TRUE(back->getShowFieldVolume());
    EXPECT_TRUE(back->getShowHands());
    EXPECT_FALSE(back->getShowExposure()) << "which is hidden until it is asked for";
}
