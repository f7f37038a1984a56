// Hands of an OpenXR runtime of the tests' own, through Debian's loader, in a scene.
#include "tests/fake-openxr/FakeHands.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandSource>
#include <osgMidair/TouchCallback>

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

class TouchDiary : public TouchCallback
{
public:
    void enter(const Touch& touch) override { add("enter ", touch); }
    void leave(const Touch& touch) override { add("leave ", touch); }

    std::vector<std::string> lines;
    Touch last;

protected:
    ~TouchDiary() override = default;

private:
    void add(const std::string& what, const Touch& touch)
    {
        lines.push_back(what + touch.node->getName());
        last = touch;
    }
};

/// The runtime's right hand: the last bone of an index finger that points down (-y of OpenXR) at
/// the scene's \a tip, the middle of its end's ball of 7.5 mm.
void point(const osg::Vec3d& tip)
{
    midair::bridge::Hand hand = midair::bridge::openHandWithIndexTipAt(
        1,
        Eigen::Vector3d(tip.x(), tip.z(), -tip.y()),
        Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitX())));
    for (std::size_t i = 0; i < hand.joints.size(); ++i)
        hand.joints[i].positionValid =
            i == midair::bridge::INDEX_DISTAL || i == midair::bridge::INDEX_TIP;
    const FakeAccess fake;
    fake->hands[1] = fakeHand(hand);
}

std::string errorOf(const std::string& uri)
{
    std::string error;
    EXPECT_FALSE(openHandSource(uri, error));
    return error;
}

} // namespace

TEST(OpenXrHands, TouchWhatIsSeenThere)
{
    useFakeRuntime();
    {
        BoxScene box;
        const osg::ref_ptr<TouchDiary> diary = new TouchDiary;
        box.scene->setHands("openxr:");
        box.surface->setTouchEvents(true);
        box.surface->setTouchCallback(diary);
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        point(osg::Vec3d(0.01, 0.005, 0.17 + 0.0075 + 0.02));
        ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().hands == 1; }));
        EXPECT_EQ(diary->lines, std::vector<std::string>());
        point(osg::Vec3d(0.01, 0.005, 0.17 + 0.0075 - 0.002));
        ASSERT_TRUE(viewer.framesUntil([&] { return !diary->lines.empty(); }));
        EXPECT_EQ(diary->lines[0], "enter box");
        EXPECT_EQ(diary->last.hand, 1);
        EXPECT_EQ(diary->last.bone, "index distal to index tip");
        EXPECT_NEAR(diary->last.distance, -0.002, 1e-5);
        EXPECT_LT((diary->last.position - osg::Vec3d(0.01, 0.005, 0.17)).length(), 2e-3);
        FakeAccess()->hands[1].reset();
        ASSERT_TRUE(viewer.framesUntil([&] { return diary->lines.back() == "leave box"; }));
        EXPECT_EQ(box.scene->getStatistics().messages, std::vector<std::string>());
    }
    const FakeAccess fake;
    EXPECT_EQ(fake->alive, 0);
    EXPECT_EQ(fake->misuse, std::vector<std::string>());
}

TEST(OpenXrHands, ArePlacedByTheMatrixOfTheirName)
{
    useFakeRuntime();
    point(osg::Vec3d(0.0, 0.0, 0.0));
    std::string error;
    const osg::ref_ptr<HandSource> source = openHandSource(
        "openxr:?space=local&matrix=1 0 0 0  0 0 1 0  0 -1 0 0  0.1 0.2 0.3 1", error);
    ASSERT_TRUE(source) << error;
    std::vector<Hand> hands;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!source->getHands(0.0, hands) && std::chrono::steady_clock::now() < end)
        std::this_thread::yield();
    ASSERT_EQ(hands.size(), 1u);
    EXPECT_LT(
        (hands[0].joints[midair::bridge::INDEX_TIP].position - osg::Vec3d(0.1, 0.2, 0.3)).length(),
        1e-6);
    // The finger points down in the scene.
    EXPECT_GT(hands[0].joints[midair::bridge::INDEX_DISTAL].position.z(), 0.31);
    EXPECT_EQ(FakeAccess()->space, XR_REFERENCE_SPACE_TYPE_LOCAL);
    EXPECT_EQ(source->getStatus().find("openxr: Fake XR 1.2.3; "), 0u) << source->getStatus();
}

TEST(OpenXrHands, WhatIsMissingIsAMessageOfTheScene)
{
    BoxScene box;
    box.scene->setHands("openxr:?loader=libmidair_no_such_loader.so.1");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().messages.empty(); }));
    viewer.frames(5);
    EXPECT_EQ(box.scene->getStatistics().messages,
              std::vector<std::string>{
                  "openxr: the loader can't be loaded (libmidair_no_such_loader.so.1: cannot open "
                  "shared object file: No such file or directory); no hands. Install "
                  "libopenxr-loader1 and an OpenXR runtime"});
}

TEST(OpenXrHands, NamesThatAreWrongAreToldWithWhatIsRight)
{
    EXPECT_EQ(errorOf("openxr:?space=head"),
              "hand source \"openxr:?space=head\": space=head should be stage or local");
    EXPECT_EQ(errorOf("openxr:?matrix=1 0 0"),
              "hand source \"openxr:?matrix=1 0 0\": matrix=1 0 0 should be 16 numbers of a rigid "
              "matrix, row by row, translation last");
    const std::string mirrored = "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
    EXPECT_EQ(errorOf("openxr:?matrix=" + mirrored),
              "hand source \"openxr:?matrix=" + mirrored + "\": matrix=" + mirrored +
                  " should be 16 numbers of a rigid matrix, row by row, translation last");
    EXPECT_EQ(errorOf("openxr:?speed=2"),
              "hand source \"openxr:?speed=2\": unknown parameter \"speed\"; known are helper, "
              "loader, matrix, process, space");
    EXPECT_EQ(errorOf("openxr:monado"),
              "hand source \"openxr:monado\": nothing may stand between \"openxr:\" and the "
              "parameters, but \"monado\" does");
}
