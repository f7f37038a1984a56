#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldBaker>
#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>
#include <osgMidair/RigidBodyCallback>

#include <osg/Geode>
#include <osg/Geometry>
#include <osg/PositionAttitudeTransform>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

constexpr std::uint64_t kFrame_ns = 20000000;

/// A point above a board.
osg::ref_ptr<HapticScene> pointScene()
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    osg::ref_ptr<HapticPoints> points = new HapticPoints;
    points->setPoints({{0.0, 0.0, 0.15}, {0.0, 0.03, 0.15}});
    scene->addChild(points);
    return scene;
}

osg::ref_ptr<osg::FrameStamp> stamp(unsigned int frame)
{
    osg::ref_ptr<osg::FrameStamp> made = new osg::FrameStamp;
    made->setFrameNumber(frame);
    made->setSimulationTime(0.02 * frame);
    return made;
}

bool bake(FieldBaker& baker, unsigned int k, BakedFrame& frame, std::string& error)
{
    return baker.bake(*stamp(k), {}, k * kFrame_ns, (k + 1) * kFrame_ns, frame, error);
}

} // namespace

TEST(FieldBaker, SolvesAFrameAtItsTime)
{
    const osg::ref_ptr<HapticScene> scene = pointScene();
    osg::ref_ptr<FieldBaker> baker = new FieldBaker(*scene);
    std::string error;
    ASSERT_TRUE(baker->look(*stamp(0), {}, error)) << error;
    EXPECT_EQ(baker->getNumTransducers(), 249u);
    EXPECT_TRUE(baker->getUnbakeable().empty());
    BakedFrame frame;
    ASSERT_TRUE(bake(*baker, 7, frame, error)) << error;
    ASSERT_EQ(frame.fields.size(), 1u);
    EXPECT_EQ(frame.fields[0].time_ns, 7 * kFrame_ns);
    EXPECT_EQ(frame.fields[0].phase.size(), 249u);
    EXPECT_EQ(frame.points, 2u);
    EXPECT_LT(frame.rms, 0.01);
    EXPECT_FALSE(bake(*baker, 8, frame, error) && frame.fields.empty());
    EXPECT_FALSE(baker->bake(*stamp(9), {}, 5, 5, frame, error));
    EXPECT_NE(error.find("ends before"), std::string::npos);
    // It never opened anything.
    EXPECT_EQ(scene->getStatistics().snapshots, 0u);
}

TEST(FieldBaker, StartsAreTheSameEachTime)
{
    const osg::ref_ptr<HapticScene> scene = pointScene();
    osg::ref_ptr<FieldBaker> baker = new FieldBaker(*scene);
    std::string error;
    BakedFrame first;
    BakedFrame again;
    ASSERT_TRUE(bake(*baker, 0, first, error)) << error;
    baker->restart();
    ASSERT_TRUE(bake(*baker, 0, again, error)) << error;
    EXPECT_EQ(first.fields[0].phase, again.fields[0].phase);
    EXPECT_EQ(first.fields[0].duty, again.fields[0].duty);
}

TEST(FieldBaker, SurfacesThatMoveSlowlyAreEven)
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    osg::ref_ptr<osg::PositionAttitudeTransform> moved = new osg::PositionAttitudeTransform;
    osg::ref_ptr<HapticSurface> surface = new HapticSurface;
    surface->addChild(osg::createTexturedQuadGeometry(
        {-0.015f, -0.015f, 0.0f}, {0.03f, 0.0f, 0.0f}, {0.0f, 0.03f, 0.0f}));
    moved->addChild(surface);
    scene->addChild(moved);
    std::vector<BakedFrame> frames[2];
    for (const bool isEvened : {false, true})
    {
        scene->setEven(isEvened ? 25 : 0);
        osg::ref_ptr<FieldBaker> baker = new FieldBaker(*scene);
        for (unsigned int k = 0; k < 3; ++k)
        {
            moved->setPosition({0.0, 3e-4 * k, 0.15});
            std::string error;
            BakedFrame frame;
            ASSERT_TRUE(bake(*baker, k, frame, error)) << error;
            ASSERT_EQ(frame.fields.size(), 1u) << "held";
            frames[isEvened].push_back(frame);
        }
    }
    for (int k = 0; k < 3; ++k)
    {
        const BakedFrame &solved = frames[0][k], &evened = frames[1][k];
        EXPECT_LT(solved.rms, 0.01);
        EXPECT_TRUE(evened.isEvened && !solved.isEvened);
        EXPECT_GT(evened.rms, 0.02) << "it is even over the surface, not at its points";
        EXPECT_GT(evened.level_Pa, 0.5 * solved.level_Pa);
        EXPECT_NE(evened.fields[0].phase, solved.fields[0].phase);
    }
}

TEST(FieldBaker, FollowsSettingsThatChange)
{
    const osg::ref_ptr<HapticScene> scene = pointScene();
    osg::ref_ptr<FieldBaker> baker = new FieldBaker(*scene);
    std::string error;
    BakedFrame frame;
    ASSERT_TRUE(bake(*baker, 0, frame, error)) << error;
    const double before_Pa = frame.level_Pa;
    scene->setMaxPressure(0.5 * before_Pa);
    ASSERT_TRUE(bake(*baker, 1, frame, error)) << error;
    EXPECT_LE(frame.level_Pa, 0.5 * before_Pa);
    EXPECT_GT(frame.level_Pa, 0.4 * before_Pa);
    scene->setEnabled(false);
    ASSERT_TRUE(bake(*baker, 2, frame, error)) << error;
    ASSERT_EQ(frame.fields.size(), 1u);
    EXPECT_TRUE(frame.fields[0].phase.empty());
}

TEST(FieldBaker, RefusesWhatCannotBePlayed)
{
    const auto refusal = [](const std::function<void(HapticScene&)>& change)
    {
        const osg::ref_ptr<HapticScene> scene = pointScene();
        change(*scene);
        osg::ref_ptr<FieldBaker> baker = new FieldBaker(*scene);
        std::string error;
        EXPECT_FALSE(baker->look(*stamp(0), {}, error));
        return error;
    };
    EXPECT_NE(refusal([](HapticScene& scene) { scene.setArray("nonesuch"); }).find("nonesuch"),
              std::string::npos);
    EXPECT_NE(refusal([](HapticScene& scene) { scene.setDevice("sim:?max-amplitude=2"); })
                  .find("max-amplitude"),
              std::string::npos);
    EXPECT_NE(refusal([](HapticScene& scene) { scene.setSolver("nonesuch"); }).find("nonesuch"),
              std::string::npos);
    EXPECT_NE(refusal([](HapticScene& scene) { scene.setMaxAmplitude(-1.0); }).find("maxAmplitude"),
              std::string::npos);
}
