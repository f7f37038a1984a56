#include "tests/plugin/KitTest.h"

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// The box over the board, and a plate of 100 mm half way between them that is tagged.
struct Shaded : BoxScene
{
    osg::ref_ptr<osg::MatrixTransform> plate =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.07));

    explicit Shaded(bool shadows)
    {
        plate->setName("tray");
        plate->setUserValue("obstacle", true);
        plate->addChild(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.1f, 0.1f, 0.02f)));
        scene->setShadows(shadows);
        scene->addChild(plate);
    }
};

} // namespace

TEST(ObstacleTag, ShadowsAndIsNotFelt)
{
    Shaded shaded(true);
    HeadlessViewer viewer(shaded.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return shaded.points() > 0; }));
    const int points = shaded.points();
    const double behind_Pa = shaded.result()->report().level_Pa;
    EXPECT_EQ(shaded.scene->getStatistics().objects, 1) << "the plate is not felt";
    const auto solves = [&] { return shaded.scene->getStatistics().solves; };
    const std::uint64_t before = solves();
    viewer.frames(20);
    EXPECT_EQ(solves(), before) << "it stands still";
    shaded.plate->setMatrix(osg::Matrixd::translate(0.3, 0.0, 0.07)); // out of the way
    ASSERT_TRUE(viewer.framesUntil([&] { return solves() > before; }));
    EXPECT_EQ(shaded.points(), points);
    const double free_Pa = shaded.result()->report().level_Pa;
    EXPECT_GT(free_Pa, 1.5 * behind_Pa);
    shaded.plate->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.07));
    const std::uint64_t moved = solves();
    ASSERT_TRUE(viewer.framesUntil([&] { return solves() > moved; }));
    EXPECT_LT(1.5 * shaded.result()->report().level_Pa, free_Pa) << "back in the way";
    shaded.plate->setNodeMask(0);
    const std::uint64_t masked = solves();
    ASSERT_TRUE(viewer.framesUntil([&] { return solves() > masked; }));
    EXPECT_GT(shaded.result()->report().level_Pa, 1.5 * behind_Pa) << "masked, it is not there";
    EXPECT_TRUE(shaded.scene->getStatistics().messages.empty());
}

TEST(ObstacleTag, SaysOnceThatShadowsAreOff)
{
    Shaded shaded(false);
    HeadlessViewer viewer(shaded.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return shaded.points() > 0; }));
    viewer.frames(5);
    const auto messages = shaded.scene->getStatistics().messages;
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(
        messages[0],
        "HapticScene/MatrixTransform 'tray': is an obstacle, which counts only where the scene's "
        "shadows are on");
}
