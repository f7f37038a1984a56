#include "tests/plugin/KitTest.h"

#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// 10,000 nodes, 10 of them haptic: boxes of 10 mm in a row, 25 mm apart, in front of one simulated
/// board.
struct LargeScene : testing::Test
{
    LargeScene()
    {
        scene->setArray("board");
        std::vector<osg::ref_ptr<osg::Group>> level{scene};
        for (int nodes = 0; nodes < 10000;)
        {
            std::vector<osg::ref_ptr<osg::Group>> next;
            for (const auto& parent : level)
                for (int i = 0; i < 10 && nodes < 10000; ++i, ++nodes)
                {
                    next.emplace_back(new osg::MatrixTransform);
                    parent->addChild(next.back());
                }
            level.swap(next);
        }
        for (std::size_t i = 0; i < 10; ++i)
        {
            osg::ref_ptr<HapticSurface> surface = new HapticSurface;
            surface->addChild(BoxScene::box(0.01f));
            movers.emplace_back(new osg::MatrixTransform);
            movers[i]->addChild(surface);
            move(i, 0.0);
            level[level.size() * i / 10]->addChild(movers[i]);
        }
    }

    void move(std::size_t i, double y)
    {
        movers[i]->setMatrix(
            osg::Matrixd::translate(0.025 * static_cast<double>(i) - 0.1125, y, 0.15));
    }

    HapticStatistics statistics() const { return scene->getStatistics(); }

    bool solvedOnceMore(HeadlessViewer& viewer, std::uint64_t solves) const
    {
        return viewer.framesUntil([&] { return statistics().solves == solves + 1; });
    }

    osg::ref_ptr<HapticScene> scene = new HapticScene;
    std::vector<osg::ref_ptr<osg::MatrixTransform>> movers;
};

} // namespace

TEST_F(LargeScene, OnlyThePointsOfWhatMovedAreFoundAnew)
{
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(solvedOnceMore(viewer, 0));
    const HapticStatistics first = statistics();
    EXPECT_EQ(first.objects, 10);
    ASSERT_EQ(first.points % 10, 0) << "each has as many as the others";
    const auto all = static_cast<std::uint64_t>(first.points);
    EXPECT_GT(all, 30u);
    EXPECT_EQ(first.rowsBuilt, all);
    EXPECT_EQ(first.rowsKept, 0u);
    EXPECT_EQ(first.meshesRead, 10u);

    viewer.frames(20);
    EXPECT_EQ(statistics().solves, first.solves) << "nothing moved, nothing solved";

    move(3, 0.002);
    ASSERT_TRUE(solvedOnceMore(viewer, first.solves));
    const HapticStatistics second = statistics();
    EXPECT_EQ(second.rowsBuilt - first.rowsBuilt, all / 10);
    EXPECT_EQ(second.rowsKept - first.rowsKept, all - all / 10);
    EXPECT_EQ(second.meshesRead, first.meshesRead);
    EXPECT_EQ(second.meshesSampled, first.meshesSampled);
}

TEST_F(LargeScene, WhatIsHiddenOrOutOfReachIsNotSampled)
{
    movers[0]->setNodeMask(0);
    movers[1]->setMatrix(osg::Matrixd::translate(0.0, 0.0, -5.0));
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(solvedOnceMore(viewer, 0));
    const HapticStatistics s = statistics();
    EXPECT_EQ(s.objects, 9) << "active ones";
    EXPECT_EQ(s.outOfWorkspace, 1u) << "the object as a whole";
    EXPECT_EQ(s.points % 8, 0);
    EXPECT_EQ(s.rowsBuilt, static_cast<std::uint64_t>(s.points));
}
