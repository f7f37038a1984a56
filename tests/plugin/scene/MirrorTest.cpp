// Front and back are those of what is seen, however it is scaled or mirrored.
#include "tests/plugin/KitTest.h"

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A box in front of the array of which the front alone is felt.
struct FrontOfABox : testing::TestWithParam<osg::Vec3d>
{
    FrontOfABox() { box.surface->setSide(HapticProperty::FRONT); }

    void expectFront()
    {
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        const osg::ref_ptr<const HapticField> field = box.scene->getField();
        for (const HapticField::ControlPoint& point : field->getPoints())
        {
            EXPECT_LT(point.position.z(), 0.15) << "the lower half, towards the array";
            EXPECT_GT((point.position - osg::Vec3d(0.0, 0.0, 0.15)) * point.normal, 0.0)
                << "outwards";
        }
    }

    BoxScene box;
    osg::Matrixd scale = osg::Matrixd::scale(GetParam());
};

} // namespace

TEST_P(FrontOfABox, IsWhereItIsSeenBelowATransform)
{
    box.transform->setMatrix(scale * osg::Matrixd::translate(0.0, 0.0, 0.15));
    expectFront();
}

TEST_P(FrontOfABox, IsWhereItIsSeenAboveATransform)
{
    box.surface->removeChildren(0, box.surface->getNumChildren());
    const osg::ref_ptr<osg::MatrixTransform> inner = new osg::MatrixTransform(scale);
    inner->addChild(BoxScene::box());
    box.surface->addChild(inner);
    expectFront();
}

INSTANTIATE_TEST_SUITE_P(Scales,
                         FrontOfABox,
                         testing::Values(osg::Vec3d(1.0, 1.0, 1.0),
                                         osg::Vec3d(-1.0, 1.0, 1.0),
                                         osg::Vec3d(1.0, 1.0, -1.0),
                                         osg::Vec3d(-1.0, -1.0, -1.0),
                                         osg::Vec3d(1.5, 1.0, 0.3),
                                         osg::Vec3d(-1.5, 1.0, 0.3)));
