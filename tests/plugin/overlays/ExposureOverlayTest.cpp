#include "haptics/propagation/Exposure.h"
#include "plugin/overlays/OverlayPart.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ExposureOverlay>
#include <osgMidair/HapticOverlays>

#include <osg/Geometry>

#include <gtest/gtest.h>

using namespace osgMidair;
using namespace midair;

namespace
{

std::shared_ptr<bridge::HologramResult> playing(const haptics::TransducerArray& array,
                                                float amplitude)
{
    auto result = std::make_shared<bridge::HologramResult>();
    result->state = bridge::ArrayState::PLAYING;
    result->sequence.fields = {Eigen::VectorXcf::Constant(array.size(), amplitude),
                               Eigen::VectorXcf::Zero(array.size())};
    return result;
}

unsigned int visibleCorners(ExposureOverlay& overlay)
{
    const auto& colors =
        static_cast<const osg::Vec4ubArray&>(*overlay.getChild(0)->asGeometry()->getColorArray());
    unsigned int count = 0;
    for (const osg::Vec4ub& color : colors)
        count += color.a() > 0 ? 1 : 0;
    return count;
}

} // namespace

TEST(ExposureOverlay, MapsTheLevelAroundTheArray)
{
    const auto array =
        std::make_shared<const haptics::TransducerArray>(haptics::TransducerArray::singleBoard());
    osg::ref_ptr<ExposureOverlay> overlay = new ExposureOverlay;
    EXPECT_FALSE(overlay->waitFor(0.0)) << "there is no field";
    OverlayPart::of(*overlay).setArray(array, haptics::Medium());
    OverlayPart::of(*overlay).setResult(playing(*array, 1.0f));
    ASSERT_TRUE(overlay->waitFor(30.0));
    const osg::Vec3d place = overlay->getPlace();
    EXPECT_NEAR(place.length(), 0.5, 1e-6);
    EXPECT_GT(place.z(), 0.45) << "loudest in front";
    // Half of the time silent: 3 dB less than the incoherent sum there.
    const Eigen::Matrix3Xd where = Eigen::Vector3d(place.x(), place.y(), place.z());
    const haptics::Exposure ears(*array, haptics::Medium(), where);
    const double sum_dB = haptics::soundLevel_dB(
        static_cast<double>(ears.incoherent_Pa2(Eigen::VectorXcf::Ones(array->size()))[0]));
    EXPECT_NEAR(overlay->getLevel(), sum_dB - 3.01, 0.01);
    const unsigned int all = 13 * 25;
    EXPECT_LT(visibleCorners(*overlay), all) << "nothing behind the board";
    EXPECT_GT(visibleCorners(*overlay), all / 4);
    OverlayPart::of(*overlay).setResult(playing(*array, 0.1f));
    ASSERT_TRUE(overlay->waitFor(0.0));
    EXPECT_NEAR(overlay->getLevel(), sum_dB - 23.01, 0.01);
    OverlayPart::of(*overlay).setResult(playing(*array, 0.0f));
    ASSERT_TRUE(overlay->waitFor(0.0));
    EXPECT_EQ(overlay->getLevel(), 0.0);
    EXPECT_EQ(visibleCorners(*overlay), 0u);
}

TEST(ExposureOverlay, IsHiddenUntilItIsAskedFor)
{
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    EXPECT_FALSE(overlays->getShowExposure());
    overlays->setShowAll(true);
    EXPECT_FALSE(overlays->getShowExposure());
    overlays->setShowExposure(true);
    EXPECT_TRUE(overlays->getOverlay("ears")->isShown());
    const osg::ref_ptr<HapticOverlays> copy = new HapticOverlays(*overlays);
    EXPECT_TRUE(copy->getShowExposure());
    EXPECT_TRUE(overlays->setNumber("earsOpacity", 0.5));
    EXPECT_FLOAT_EQ(overlays->getExposure()->getOpacity(), 0.5F);
    overlays->setShowAll(false);
    EXPECT_FALSE(overlays->getShowExposure());
}
