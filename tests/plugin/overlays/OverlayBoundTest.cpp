// A viewer finds its home by the scene's bound.

#include <osgMidair/AxesOverlay>
#include <osgMidair/HapticOverlays>
#include <osgMidair/WorkspaceBox>

#include <osg/Geometry>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgText/Text>

#include <gtest/gtest.h>

using namespace osgMidair;

TEST(OverlayBound, IsOfWhatIsShownAlone)
{
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.1f)));
    const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    root->addChild(overlays);
    overlays->setShowAll(false);
    const float alone = root->getBound().radius();
    const osg::ref_ptr<Overlay> one = overlays->get<WorkspaceBox>();
    one->addChild(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 10.0f)));
    EXPECT_EQ(root->getBound().radius(), alone) << "hidden while it grows";
    one->setShown(true);
    EXPECT_GT(root->getBound().radius(), 5.0f);
    one->setShown(false);
    EXPECT_EQ(root->getBound().radius(), alone) << "hidden later";
}

TEST(AxesOverlay, DrawsEachAxisFromTheOriginOnceItIsAskedFor)
{
    const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    const osg::ref_ptr<AxesOverlay> axes = overlays->get<AxesOverlay>();
    ASSERT_TRUE(axes);
    EXPECT_FALSE(axes->isShown());
    overlays->setShowAll(true);
    EXPECT_FALSE(axes->isShown()) << "it stands before what is felt";
    EXPECT_TRUE(overlays->setShown("axes", true));
    EXPECT_TRUE(overlays->setNumber("axesLength", 0.125));
    const auto* name = dynamic_cast<const osgText::Text*>(axes->getChild(0));
    ASSERT_TRUE(name);
    EXPECT_EQ(name->getCharacterSizeMode(),
              osgText::TextBase::OBJECT_COORDS_WITH_MAXIMUM_SCREEN_SIZE_CAPPED_BY_FONT_HEIGHT)
        << "never the largest text";
    const osg::Geometry* lines = axes->getChild(3)->asGeometry();
    ASSERT_TRUE(lines);
    const auto& ends = static_cast<const osg::Vec3Array&>(*lines->getVertexArray());
    ASSERT_EQ(ends.size(), 6U);
    for (unsigned int axis = 0; axis < 3; ++axis)
    {
        osg::Vec3 end;
        end[axis] = 0.125F;
        EXPECT_EQ(ends[2 * axis], osg::Vec3());
        EXPECT_EQ(ends[2 * axis + 1], end);
    }
}
