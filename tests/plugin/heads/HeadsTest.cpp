// The viewer's head in a scene: where it comes from, and whose ears are listened at.
#include "plugin/settings/Grants.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HeadSource>

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A head that a test moves, and that moves by itself if it is to.
class TestHead : public HeadSource
{
public:
    bool getHead(double time, Head& head) override
    {
        head.position = position + speed * time;
        return isTracked;
    }
    bool setHorizon(double ahead) override
    {
        horizon = ahead;
        return true;
    }
    std::string getStatus() const override { return "of a test"; }

    osg::Vec3d position;
    osg::Vec3d speed; ///< m/s
    bool isTracked = true;
    double horizon = 0.0;
};

/// A viewer whose camera rests at the array's middle, as osgXR's master camera does.
struct Watched
{
    Watched() : viewer(box.scene)
    {
        box.scene->setEarCamera(true);
        viewer.viewer.getCamera()->setViewMatrixAsLookAt(
            osg::Vec3d(0.0, 0.0, 0.15), osg::Vec3d(0.0, 1.0, 0.15), osg::Vec3d(0.0, 0.0, 1.0));
    }
    /// The two ears of a head, once both are at \a place.
    bool listensAt(const osg::Vec3d& left, const osg::Vec3d& right)
    {
        return viewer.framesUntil(
            [&]
            {
                ears = box.scene->getStatistics().ears;
                return ears.size() == 2 && (placeOf(0) - left).length() < 1e-6 &&
                       (placeOf(1) - right).length() < 1e-6;
            });
    }
    osg::Vec3d placeOf(std::size_t ear) const
    {
        return {ears[ear].x_m, ears[ear].y_m, ears[ear].z_m};
    }
    double loudest_dB() const { return std::max(ears[0].level_dB, ears[1].level_dB); }

    BoxScene box;
    HeadlessViewer viewer;
    std::vector<midair::haptics::PlaceExposure> ears;
};

} // namespace

TEST(Heads, TheEarsAreThoseOfTheHeadAndNotOfAMasterCameraAtTheArray)
{
    Watched of;
    ASSERT_TRUE(of.listensAt({-0.08, 0.0, 0.15}, {0.08, 0.0, 0.15}));
    const double camera_dB = of.loudest_dB();
    const osg::ref_ptr<InjectedHead> source = new InjectedHead;
    of.box.scene->setHeadSource(source);
    of.viewer.frames(3);
    EXPECT_TRUE(of.listensAt({-0.08, 0.0, 0.15}, {0.08, 0.0, 0.15})) << "it was never seen";
    Head head;
    head.position.set(0.0, -0.3, 0.15);
    source->setHead(head);
    ASSERT_TRUE(of.listensAt({-0.08, -0.3, 0.15}, {0.08, -0.3, 0.15}));
    const double head_dB = of.loudest_dB();
    EXPECT_LT(head_dB, camera_dB - 3.0);
    // The level is that of ears that a program sets there.
    of.box.scene->setHeadSource(nullptr);
    of.box.scene->setEarCamera(false);
    of.box.scene->setEars({{-0.08, -0.3, 0.15}, {0.08, -0.3, 0.15}});
    ASSERT_TRUE(of.listensAt({-0.08, -0.3, 0.15}, {0.08, -0.3, 0.15}));
    EXPECT_NEAR(of.loudest_dB(), head_dB, 0.2);
    RecordProperty("camera_dB", std::to_string(camera_dB));
    RecordProperty("head_dB", std::to_string(head_dB));
}

TEST(Heads, ALostOneIsListenedAtWhereItWasLast)
{
    Watched of;
    const osg::ref_ptr<InjectedHead> source = new InjectedHead;
    of.box.scene->setHeadSource(source);
    Head head;
    head.position.set(0.0, -0.1, 0.15); // near the beam
    head.orientation.makeRotate(0.5 * osg::PI, osg::Vec3d(0.0, 0.0, 1.0));
    source->setHead(head);
    ASSERT_TRUE(of.listensAt({0.0, -0.18, 0.15}, {0.0, -0.02, 0.15}));
    EXPECT_TRUE(of.box.scene->getStatistics().headTracked);
    EXPECT_EQ(of.box.scene->getStatistics().head, "head set by the application, 1 times");
    Head last;
    EXPECT_TRUE(of.box.scene->getHead(last));
    EXPECT_EQ(last.position, head.position);
    source->clear();
    of.viewer.frames(10);
    EXPECT_TRUE(of.listensAt({0.0, -0.18, 0.15}, {0.0, -0.02, 0.15}));
    EXPECT_FALSE(of.box.scene->getStatistics().headTracked);
    EXPECT_FALSE(of.box.scene->getHead(last));
    EXPECT_TRUE(
        says(*of.box.scene, "the head is lost: its last position is used, also for the ear limit"));
}

TEST(Heads, ALimitHoldsAtThem)
{
    Watched of;
    const osg::ref_ptr<InjectedHead> source = new InjectedHead;
    Head head;
    head.position.set(0.0, -0.4, 0.3);
    source->setHead(head);
    of.box.scene->setHeadSource(source);
    ASSERT_TRUE(of.listensAt({-0.08, -0.4, 0.3}, {0.08, -0.4, 0.3}));
    const double limit_dB = of.box.scene->getStatistics().exposure.level_dB + 7.0;
    of.box.scene->setEarLimit(limit_dB);
    head.position.set(-0.08, 0.0, 0.17); // the right ear is in the beam
    source->setHead(head);
    of.viewer.frame();
    ASSERT_TRUE(of.listensAt({-0.16, 0.0, 0.17}, {0.0, 0.0, 0.17}));
    ASSERT_TRUE(of.box.scene->waitForField(60.0));
    EXPECT_LE(of.box.scene->getStatistics().ears.at(1).level_dB, limit_dB);
    EXPECT_LT(of.box.result()->report().capFactor, 1.0);
}

TEST(Heads, AreNamedByTheSetting)
{
    Watched of;
    of.box.scene->setHeads("fixed 0 -0.3 0.15");
    EXPECT_TRUE(of.listensAt({-0.08, -0.3, 0.15}, {0.08, -0.3, 0.15}));
    EXPECT_EQ(of.box.scene->getStatistics().head, "head fixed at 0 -0.3 0.15 m");
    of.box.scene->setHeads("opnxr:");
    of.viewer.frames(3);
    EXPECT_TRUE(says(*of.box.scene,
                     "head source \"opnxr:\" is not known (did you mean openxr?); fixed X Y Z, "
                     "recorded:FILE, recorded:FILE?loop, mouse:, tag:FILE, openxr: and osc: are"));
    of.box.scene->setHeads("tag:");
    of.viewer.frames(3);
    EXPECT_TRUE(
        says(*of.box.scene,
             "head source \"tag:\": should be tag:FILE, where FILE describes camera and tags"));
    EXPECT_TRUE(of.listensAt({-0.08, 0.0, 0.15}, {0.08, 0.0, 0.15}));
}

TEST(Heads, ThatAFileNamesTakeTheUsersGrant)
{
    for (const char* wish : {"fixed 0 0 9", "mouse:", "recorded:head.csv", "osc:", "openxr:"})
    {
        HapticSettings settings;
        settings.heads = wish;
        settings.wishes.asked["heads"] = wish;
        std::vector<midair::base::Message> messages;
        EXPECT_EQ(Grants({}, false).apply(settings, "a scene", messages).heads, "") << wish;
        ASSERT_EQ(messages.size(), 1u) << wish;
        EXPECT_EQ(messages[0].code, midair::base::MessageCode::GRANTS_REFUSED) << messages[0].text;
        EXPECT_EQ(Grants({{wish, "fixed 0 0 1"}}, false).apply(settings, "s", messages).heads,
                  "fixed 0 0 1");
        EXPECT_EQ(Grants({}, true).apply(settings, "s", messages).heads, wish) << "trusted";
        settings.wishes.asked.clear();
        EXPECT_EQ(Grants({}, false).apply(settings, "s", messages).heads, wish) << "a program's";
    }
}

TEST(Heads, ArePredictedAsHandsAre)
{
    BoxScene box;
    const osg::ref_ptr<TestHead> source = new TestHead;
    source->speed.set(0.3, 0.0, 0.0);
    box.scene->setHeadSource(source);
    box.scene->setPrediction(HapticSettings::TRACKER);
    box.scene->setTrackerDelay(0.05);
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return source->horizon >= 0.0509 - 1e-9; }));
    EXPECT_EQ(box.scene->getHeadSource(), source.get());
}

TEST(Heads, FollowTheMouseOfTheViewThatShowsTheScene)
{
    BoxScene box;
    box.scene->setHeads("mouse:");
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0, -0.5, 0.15), osg::Vec3d(0, 0, 0.15), osg::Vec3d(0, 0, 1));
    viewer.frames(3);
    Head head;
    ASSERT_TRUE(box.scene->getHead(head));
    EXPECT_LT((head.position - osg::Vec3d(0, -0.5, 0.15)).length(), 1e-9);
    EXPECT_LT((head.orientation * osg::Vec3d(0, 0, -1) - osg::Vec3d(0, 1, 0)).length(), 1e-9);
    // The queue of a viewer without a window counts y downwards.
    viewer.viewer.getEventQueue()->mouseMotion(1.0F, -0.5F);
    viewer.frames(3);
    ASSERT_TRUE(box.scene->getHead(head));
    EXPECT_LT((head.position - osg::Vec3d(0.2, -0.5, 0.25)).length(), 1e-6);
    // A camera that follows the head moves it no further.
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0.2, -0.5, 0.25), osg::Vec3d(0.2, 0, 0.25), osg::Vec3d(0, 0, 1));
    viewer.frames(3);
    ASSERT_TRUE(box.scene->getHead(head));
    EXPECT_LT((head.position - osg::Vec3d(0.2, -0.5, 0.25)).length(), 1e-6);
}

TEST(Heads, OfOnesOwnAreOpenedByTheirName)
{
    std::string error;
    ASSERT_TRUE(registerHeadSource(
        "helmet",
        [](const std::string& options, std::string& why) -> osg::ref_ptr<HeadSource>
        {
            why = "no helmet " + options;
            return options == "here" ? new TestHead : nullptr;
        },
        error))
        << error;
    EXPECT_FALSE(openHeadSource("helmet:there", error));
    EXPECT_EQ(error, "head source \"helmet:there\": no helmet there");
    const osg::ref_ptr<HeadSource> own = openHeadSource("helmet:here", error);
    ASSERT_TRUE(own);
    EXPECT_EQ(own->getStatus(), "of a test");
    const osg::ref_ptr<HeadSource> fixed = openHeadSource("fixed 0 -0.3 0.4", error);
    ASSERT_TRUE(fixed);
    Head head;
    EXPECT_TRUE(fixed->getHead(0.0, head));
    EXPECT_EQ(head.position, osg::Vec3d(0, -0.3, 0.4));
    EXPECT_FALSE(openHeadSource("none", error));
    EXPECT_FALSE(openHeadSource("recorded:nowhere.csv", error));
    EXPECT_NE(error.find("nowhere.csv"), std::string::npos);
}
