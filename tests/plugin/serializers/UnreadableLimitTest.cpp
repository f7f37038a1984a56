// Limits and calibrations in scene files that are no numbers: OSG reads them as 0, and a cap of 0
// is none.
#include "tests/plugin/KitTest.h"

#include <osgDB/ReadFile>

#include <sstream>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Reads a scene whose text has \a to in place of \a from.
osg::ref_ptr<HapticScene>
changed(const HapticScene& scene, const std::string& from, const std::string& to)
{
    findPlugins();
    osgDB::ReaderWriter& format = *osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("fileType=Ascii");
    std::ostringstream out;
    EXPECT_TRUE(format.writeNode(scene, out, options).success());
    std::string text = out.str();
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << text;
    if (place != std::string::npos) text.replace(place, from.size(), to);
    std::istringstream in(text);
    return dynamic_cast<HapticScene*>(format.readNode(in, options).getNode());
}

} // namespace

TEST(UnreadableLimit, Silences)
{
    BoxScene box;
    box.scene->setMaxPressure(800.0);
    box.scene->setMaxAmplitude(0.5);
    box.scene->setEarLimit(110.0);
    box.scene->setMetresPerUnit(0.125);
    box.scene->setCalibration(osg::Matrixd::translate(0.25, 0.0, 0.0));
    const std::pair<const char*, const char*> wrong[] = {
        {"MaxPressure 800", "MaxPressure eight"},
        {"MaxPressure 800", "MaxPressure 800mm"},
        {"MaxAmplitude 0.5", "MaxAmplitude 0,5"},
        {"EarLimit 110", "EarLimit abc"},
        {"EarLimit 110", "EarLimit 130bananas"},
        {"0.25", "a_quarter"},
        {"MetresPerUnit 0.125", "MetresPerUnit abc"},
    };
    for (const auto& [from, to] : wrong)
    {
        Notices notices;
        const osg::ref_ptr<HapticScene> scene = changed(*box.scene, from, to);
        ASSERT_NE(scene, nullptr) << to;
        EXPECT_TRUE(scene->getSettings().isSilenced) << to;
        EXPECT_NE(notices.text().find("; nothing is played"), std::string::npos) << to;
        EXPECT_EQ(scene->getSettings().whySilenced.size(), 1u) << to;
    }
    const auto right = changed(*box.scene, "MaxPressure 800", "MaxPressure 9e2");
    ASSERT_NE(right, nullptr);
    EXPECT_FALSE(right->getSettings().isSilenced);
    EXPECT_EQ(right->getMaxPressure(), 900.0);
    EXPECT_EQ(right->getCalibration(), box.scene->getCalibration());
    EXPECT_EQ(right->getNumChildren(), 1u) << "what follows is read";
}
