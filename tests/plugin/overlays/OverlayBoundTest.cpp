// A viewer finds its home by the scene's bound.

#include <osgMidair/HapticOverlays>
#include <osgMidair/WorkspaceBox>

#include <osg/Shape>
#include <osg/ShapeDrawable>

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
