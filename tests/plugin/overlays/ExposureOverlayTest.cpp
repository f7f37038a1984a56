#include "haptics/propagation/Exposure.h"
#include "plugin/overlays/OverlayPart.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ExposureOverlay>
#include <osgMidair/HapticOverlays>

#include <osg/Geode>
#include <osg/Geometry>
#include <osgText/Text>

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

/// Looks from a place.
class EyeVisitor : public osg::NodeVisitor
{
public:
    osg::Vec3 getEyePoint() const override { return eye; }

    osg::Vec3 eye;
};

/// Triangles of the map, lines, and labels with a text.
struct Drawn
{
    unsigned int faces = 0, lines = 0, labels = 0;
};

Drawn drawn(ExposureOverlay& overlay)
{
    Drawn drawn;
    drawn.faces = overlay.getChild(0)->asGeometry()->getPrimitiveSet(0)->getNumIndices() / 3;
    drawn.lines = overlay.getChild(1)->asGeometry()->getPrimitiveSet(0)->getNumIndices() / 2;
    const osg::Geode& labels = *overlay.getChild(2)->asGeode();
    for (unsigned int k = 0; k < labels.getNumDrawables(); ++k)
        drawn.labels +=
            static_cast<const osgText::Text&>(*labels.getDrawable(k)).getText().empty() ? 0 : 1;
    return drawn;
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
    const unsigned int all = 2 * 48 * 96;
    EXPECT_LT(drawn(*overlay).faces, all) << "nothing behind the board";
    EXPECT_GT(drawn(*overlay).faces, all / 4);
    EXPECT_GT(drawn(*overlay).lines, 50u);
    EXPECT_GT(drawn(*overlay).labels, 2u);
    OverlayPart::of(*overlay).setResult(playing(*array, 0.1f));
    ASSERT_TRUE(overlay->waitFor(1.0));
    EXPECT_NEAR(overlay->getLevel(), sum_dB - 23.01, 0.01);
    OverlayPart::of(*overlay).setResult(playing(*array, 0.0f));
    ASSERT_TRUE(overlay->waitFor(1.0));
    EXPECT_EQ(overlay->getLevel(), 0.0);
    EXPECT_EQ(drawn(*overlay).faces, 0u);
    EXPECT_EQ(drawn(*overlay).lines, 0u);
    EXPECT_EQ(drawn(*overlay).labels, 0u);
}

TEST(ExposureOverlay, NoLabelStandsBeforeWhatIsFelt)
{
    const auto array =
        std::make_shared<const haptics::TransducerArray>(haptics::TransducerArray::singleBoard());
    const auto field = playing(*array, 1.0F);
    osg::ref_ptr<ExposureOverlay> overlay = new ExposureOverlay;
    OverlayPart::of(*overlay).setArray(array, haptics::Medium());
    OverlayPart::of(*overlay).setResult(field);
    ASSERT_TRUE(overlay->waitFor(30.0));
    osg::Drawable& loudest = *overlay->getChild(2)->asGeode()->getDrawable(0);
    const auto isDrawn = [&](const osg::Vec3d& eye)
    {
        EyeVisitor visitor;
        visitor.eye = eye;
        return !loudest.getCullCallback()->asDrawableCullCallback()->cull(
            &visitor, &loudest, static_cast<osg::State*>(nullptr));
    };
    const osg::Vec3d place = overlay->getPlace();
    EXPECT_TRUE(isDrawn(place * 3.0)) << "nothing is felt";
    field->points.positions = Eigen::Vector3d(place.x(), place.y(), place.z()) * 0.4;
    OverlayPart::of(*overlay).setResult(field);
    EXPECT_FALSE(isDrawn(place * 3.0)) << "before it";
    EXPECT_FALSE(isDrawn(-place)) << "behind it";
    EXPECT_TRUE(isDrawn({2.0, 0.0, 0.0})) << "beside it";
}

TEST(ExposureOverlay, IsHiddenUntilItIsAskedFor)
{
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    EXPECT_FALSE(overlays->isShown("ears"));
    overlays->setShowAll(true);
    EXPECT_FALSE(overlays->isShown("ears"));
    overlays->setShown("ears", true);
    EXPECT_TRUE(overlays->getOverlay("ears")->isShown());
    const osg::ref_ptr<HapticOverlays> copy = new HapticOverlays(*overlays);
    EXPECT_TRUE(copy->isShown("ears"));
    EXPECT_TRUE(overlays->setNumber("earsOpacity", 0.5));
    EXPECT_FLOAT_EQ(overlays->get<ExposureOverlay>()->getOpacity(), 0.5F);
    overlays->setShowAll(false);
    EXPECT_FALSE(overlays->isShown("ears"));
}
