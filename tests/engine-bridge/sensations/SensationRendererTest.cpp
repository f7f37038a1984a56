// Sensations field by field, without a device.
#include "engine-bridge/rendering/ContactRenderer.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/haptics/sensation/Patterns.h"

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using namespace midair::bridge::test;
using Eigen::Vector3d;
using Attach = SensationProperties::Attach;
using Trigger = SensationProperties::Trigger;

namespace
{

constexpr double kStep_s = 1e-3;
constexpr double kPressure_Pa = 1000.0;

const haptics::TransducerArray& octagon()
{
    static const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    return array;
}

std::shared_ptr<const haptics::Sensation> classic(const std::string& text)
{
    return std::make_shared<const haptics::Sensation>(haptics::loadSensation(text));
}

/// An object without a mesh that plays a sensation of 1 kPa.
HapticObject sensation(const std::string& text, std::uint64_t id = 1)
{
    HapticObject made = object(std::make_shared<const haptics::TriangleMesh>(), id);
    made.path = "Scene/Sensation";
    made.properties.pressure = kPressure_Pa;
    made.properties.pressureInPa = true;
    made.properties.sensation.isMeant = true;
    made.properties.sensation.pattern = classic(text);
    return made;
}

/// A scene that is played step by step.
struct Scene
{
    ContactRenderer renderer{octagon(), {}};
    std::vector<HapticObject> objects;
    HandFrame hands;
    haptics::FieldSequence whole;
    double now_s = 1.0;
    double rate_Hz = 1000.0;
    double most_Pa = 0.0;

    void frame()
    {
        std::vector<HapticObject> now = objects;
        renderer.update(now, hands, now_s, 0.0);
    }
    RenderedField field()
    {
        RenderedField made = renderer.render(now_s, whole, most_Pa, rate_Hz);
        now_s += kStep_s;
        return made;
    }
    /// Fields for \a duration_s, with a frame each 10 ms if \a hasFrames. Returns the last.
    RenderedField run(double duration_s, bool hasFrames = true)
    {
        RenderedField last;
        const int fields = static_cast<int>(std::lround(duration_s / kStep_s));
        for (int i = 0; i < fields; ++i)
        {
            if (hasFrames && i % 10 == 0) frame();
            last = field();
        }
        return last;
    }
};

HandFrame open(int hand, const Eigen::Isometry3d& palm)
{
    HandFrame frame;
    frame.hands = {openHand(hand, palm)};
    return frame;
}

/// A palm 10 mm over the array's middle that faces down.
Eigen::Isometry3d overMiddle(double x_m = 0.0)
{
    return Eigen::Isometry3d(Eigen::Translation3d(x_m, 0.0, 0.01));
}

} // namespace

TEST(SensationRenderer, AFocusIsWhereItsSampleIsAtTheFieldsTime)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=20mm&frequency=70Hz")};
    Eigen::Isometry3d& pose = scene.objects[0].pose;
    pose = Eigen::Translation3d(0.01, -0.02, 0.03) *
           Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized());
    haptics::SensationPlayer reference(scene.objects[0].properties.sensation.pattern);
    const double begin_s = scene.now_s;
    double most_m = 0.0;
    scene.frame();
    for (int i = 0; i < 200; ++i)
    {
        const double time_ms = 1e3 * (scene.now_s - begin_s);
        const RenderedField field = scene.field();
        const haptics::SensationSample sample = reference.sampleAt(time_ms);
        if (i == 0) continue; // it fades in
        ASSERT_EQ(field.foci.size(), 1) << i;
        most_m = std::max(
            most_m, (field.foci.positions.col(0) - pose * (1e-3 * sample.position_mm)).norm());
        const double gain = i < 5 ? i / 5.0 : 1.0;
        ASSERT_NEAR(field.foci.targets[0], gain * kPressure_Pa * sample.intensity, 0.1);
    }
    EXPECT_LT(most_m, 1e-9);
}

// A single focus has all the pressure that the array can give it.
TEST(SensationRenderer, ARelativePressureIsAShareOfTheLoudestFocus)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=0mm")};
    scene.objects[0].properties.pressureInPa = false;
    scene.objects[0].properties.pressure = 1.0;
    RenderedField full = scene.run(0.02);
    ASSERT_EQ(full.foci.size(), 1);
    EXPECT_NEAR(full.q.cwiseAbs().minCoeff(), 1.0f, 1e-3f);
    scene.objects[0].properties.pressure = 0.5;
    const RenderedField half = scene.run(0.02);
    EXPECT_NEAR(half.foci.targets[0], 0.5 * full.foci.targets[0], 1e-3 * full.foci.targets[0]);
    EXPECT_NEAR(half.q.cwiseAbs().maxCoeff(), 0.5f, 0.01f);
}

TEST(SensationRenderer, ItBeginsAndEndsAsItsTriggerSays)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=20mm")};
    SensationProperties& wanted = scene.objects[0].properties.sensation;
    wanted.trigger = Trigger::PROGRAM;
    EXPECT_EQ(scene.run(0.05).foci.size(), 0);
    EXPECT_FALSE(scene.renderer.isActive(scene.now_s));
    wanted.plays = 1;
    EXPECT_EQ(scene.run(0.02).foci.size(), 1);
    wanted.plays = 0;
    scene.frame();
    double last = kPressure_Pa;
    int fields = 0;
    for (; scene.renderer.isActive(scene.now_s) && fields < 100; ++fields)
    {
        const RenderedField field = scene.field();
        const double now = field.foci.size() > 0 ? field.foci.targets[0] : 0.0;
        EXPECT_LE(now, last) << "it fades";
        last = now;
    }
    EXPECT_NEAR(fields * kStep_s, PlayingSensation::kFadeOut_s, 2.1 * kStep_s);
    EXPECT_EQ(last, 0.0);
    EXPECT_EQ(scene.run(0.02).foci.size(), 0);
    wanted.plays = 2;
    EXPECT_EQ(scene.run(0.02).foci.size(), 1) << "again";
}

TEST(SensationRenderer, OneThatStopsEndsOrBeginsAnew)
{
    Scene scene;
    scene.objects = {sensation("click")};
    scene.objects[0].properties.sensation.trigger = Trigger::PROGRAM;
    scene.objects[0].properties.sensation.plays = 1;
    EXPECT_GT(scene.run(0.03).foci.size(), 0);
    scene.run(0.5);
    EXPECT_FALSE(scene.renderer.isActive(scene.now_s));
    scene.objects[0].properties.sensation.trigger = Trigger::ALWAYS;
    int felt = 0;
    for (int i = 0; i < 1000; ++i)
        felt += scene.run(kStep_s).foci.size() > 0 ? 1 : 0;
    EXPECT_GT(felt, 500) << "always is again and again";
}

TEST(SensationRenderer, TouchesBeginAndEndIt)
{
    struct Case
    {
        Trigger trigger;
        bool whileTouched;
        bool afterwards;
    };
    for (const Case& one : {Case{Trigger::TOUCH_BEGIN, true, true},
                            Case{Trigger::TOUCH_STAY, true, false},
                            Case{Trigger::TOUCH_END, false, true}})
    {
        Scene scene;
        scene.objects = {sensation("circle?radius=5mm")};
        scene.objects[0].mesh = sheet();
        scene.objects[0].properties.sensation.trigger = one.trigger;
        const int which = static_cast<int>(one.trigger);
        EXPECT_EQ(scene.run(0.05).foci.size(), 0) << which;
        scene.hands = ball(Vector3d(0, 0, 6.5e-3));
        EXPECT_EQ(scene.run(0.05).foci.size(), one.whileTouched ? 1 : 0) << which;
        scene.hands = ball(Vector3d(0, 0, 0.06));
        EXPECT_EQ(scene.run(0.05).foci.size(), one.afterwards ? 1 : 0) << which;
    }
}

TEST(SensationRenderer, AHandCarriesItOnItsPalmSideMirroredOnTheLeft)
{
    for (const int hand : {0, 1})
    {
        Scene scene;
        scene.objects = {sensation("circle?radius=10mm")};
        scene.objects[0].properties.sensation.attach = Attach::HAND;
        scene.objects[0].properties.sensation.joint = PALM;
        EXPECT_EQ(scene.run(0.02).foci.size(), 0) << "no hand";
        scene.hands = open(hand, overMiddle());
        RenderedField field = scene.run(0.03);
        ASSERT_EQ(field.foci.size(), 1);
        const HandJoint palm = scene.hands.hands[0].joints[PALM];
        const Vector3d away = field.foci.positions.col(0) - palm.position;
        EXPECT_NEAR(away.y(), -palm.radius_m, 1e-9) << "the palm's side, OpenXR's -y";
        EXPECT_NEAR(std::hypot(away.x(), away.z()), 0.01, 1e-9);
        int index = -1;
        const auto frame = frameOfHand(scene.hands, PALM, index);
        ASSERT_TRUE(frame);
        EXPECT_EQ(index, hand);
        EXPECT_NEAR(frame->toArray.linear().determinant(), hand == 1 ? 1.0 : -1.0, 1e-9);
        // It follows, and fades out when the hand is lost for longer than a moment.
        scene.hands = open(hand, overMiddle(0.02));
        field = scene.run(0.02);
        ASSERT_EQ(field.foci.size(), 1);
        EXPECT_NEAR(field.foci.positions(1, 0) - palm.position.y(), -palm.radius_m, 1e-9);
        scene.hands = {};
        EXPECT_EQ(scene.run(0.05).foci.size(), 1) << "held";
        EXPECT_EQ(scene.run(0.15).foci.size(), 0) << "lost";
        EXPECT_FALSE(scene.renderer.isActive(scene.now_s)) << "no field is made for nobody";
        scene.hands = open(hand, overMiddle());
        EXPECT_EQ(scene.run(0.03).foci.size(), 1) << "found";
    }
}

TEST(SensationRenderer, ASurfaceCarriesItAtTheTouchOrUnderTheOrigin)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=10mm")};
    scene.objects[0].mesh = sheet();
    scene.objects[0].pose.translation() = Vector3d(0.0, 0.0, 0.01);
    SensationProperties& wanted = scene.objects[0].properties.sensation;
    wanted.attach = Attach::SURFACE;
    for (int i = 0; i < 30; ++i)
    {
        const RenderedField field = scene.run(kStep_s);
        if (field.foci.size() == 0) continue;
        EXPECT_NEAR(field.foci.positions(2, 0), 0.01, 1e-9);
        EXPECT_NEAR(field.foci.positions.col(0).head<2>().norm(), 0.01, 1e-4);
    }
    wanted.trigger = Trigger::TOUCH_STAY;
    scene.hands = ball(Vector3d(0.02, 0.0, 0.0165));
    const RenderedField field = scene.run(0.05);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR((field.foci.positions.col(0) - Vector3d(0.02, 0.0, 0.01)).norm(), 0.01, 1e-3);
}

// Nothing that needs a hand plays on where frames stand still; what has a place does.
TEST(SensationRenderer, WithoutFramesHandsAreUnknown)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=10mm"), sensation("circle?radius=10mm", 2)};
    scene.objects[0].properties.sensation.attach = Attach::HAND;
    scene.objects[1].pose.translation().x() = 0.05;
    scene.hands = open(1, overMiddle());
    EXPECT_EQ(scene.run(0.03).foci.size(), 2);
    const RenderedField field = scene.run(PlayingSensation::kStale_s + 0.05, false);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(field.foci.positions(0, 0), 0.05, 0.0101);
    scene.objects.pop_back();
    scene.frame();
    scene.run(PlayingSensation::kStale_s + 0.1, false);
    EXPECT_FALSE(scene.renderer.isActive(scene.now_s)) << "no field is made for nobody";
}

// Where nothing was rendered for long, a pattern's loop isn't lost, and nothing is caught up.
TEST(SensationRenderer, TimeThatIsNotPlayedDoesNotPassInThePattern)
{
    Scene scene;
    scene.objects = {sensation("tapping")};
    scene.run(0.1);
    const double before_ms = scene.renderer.view().sensations[0].patternTime_ms;
    scene.now_s += 7200.0;
    scene.run(2 * kStep_s);
    EXPECT_NEAR(scene.renderer.view().sensations[0].patternTime_ms, before_ms + 1.0, 2.0);
}

TEST(SensationRenderer, TheHighestPriorityPlaysAndEqualOnesAdd)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=0mm", 1), sensation("circle?radius=0mm", 2)};
    scene.objects[1].pose.translation().x() = 0.03;
    EXPECT_EQ(scene.run(0.03).foci.size(), 2);
    scene.objects[1].properties.priority = 1;
    RenderedField field = scene.run(0.05);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(field.foci.positions(0, 0), 0.03, 1e-9);
    scene.objects.pop_back();
    field = scene.run(0.05);
    ASSERT_EQ(field.foci.size(), 1) << "the other one is back";
    EXPECT_NEAR(field.foci.positions(0, 0), 0.0, 1e-9);
    EXPECT_NEAR(field.foci.targets[0], kPressure_Pa, 1e-3);
}

TEST(SensationRenderer, ContactsAndWholeObjectsGiveWayToAHigherPriorityOnly)
{
    for (const int priority : {-1, 0, 1})
    {
        Scene scene;
        scene.objects = {
            sensation("circle?radius=0mm", 1), object(sheet(), 2), object(sheet(10), 3)};
        scene.objects[0].properties.priority = priority;
        scene.objects[0].pose.translation().x() = 0.05;
        scene.objects[1].properties.render = Render::CONTACT;
        scene.objects[2].pose.translation().z() = -0.05;
        scene.hands = ball(Vector3d(0, 0, 6.5e-3));
        scene.whole.fields = {Eigen::VectorXcf::Constant(octagon().size(), 0.25f)};
        const RenderedField field = scene.run(0.1);
        int ofContact = 0;
        for (int l = 0; l < field.foci.size(); ++l)
            ofContact += field.foci.object[static_cast<std::size_t>(l)] == 1 ? 1 : 0;
        const bool isSensation = field.foci.size() > ofContact;
        EXPECT_EQ(ofContact > 0, priority <= 0) << priority;
        EXPECT_EQ(isSensation, priority >= 0) << priority;
        EXPECT_NEAR(scene.renderer.whole(), priority <= 0 ? 1.0 : 0.0, 1e-9) << priority;
        // All is as before when it has gone.
        scene.objects.erase(scene.objects.begin());
        EXPECT_GT(scene.run(0.1).foci.size(), 0);
        EXPECT_NEAR(scene.renderer.whole(), 1.0, 1e-9);
    }
}

TEST(SensationRenderer, ACapLowersItAsAWhole)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=0mm")};
    scene.objects[0].properties.sensation.pattern = patterns::read(patterns::pattern(
        {[]
         {
             patterns::Json frame = patterns::standard(0.0, patterns::coords(0, 0, 0));
             frame["intensity"] = patterns::intensity(patterns::number(0.5));
             return frame;
         }()}));
    constexpr double kLoud_Pa = 20.0 * kPressure_Pa; // many levels of the array
    scene.objects[0].properties.pressure = kLoud_Pa;
    const auto loudness = [&](const RenderedField& field)
    { return static_cast<double>(field.q.cwiseAbs().maxCoeff()); };
    const double free = loudness(scene.run(0.02));
    scene.most_Pa = 0.5 * kLoud_Pa;
    RenderedField field = scene.run(kStep_s);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(field.foci.targets[0], 0.5 * kLoud_Pa, 1.0) << "what is wanted is told";
    EXPECT_NEAR(loudness(field), 0.5 * free, 0.02 * free) << "its course stays";
    scene.renderer.noteCap(0.5);
    double before = loudness(scene.run(kStep_s));
    EXPECT_NEAR(before, 0.25 * free, 0.02 * free);
    for (int i = 0; i < 20; ++i)
    {
        scene.renderer.noteCap(1.0);
        const double now = loudness(scene.run(kStep_s));
        EXPECT_LT(now - before, 0.02 * free) << "no vibration by the cap";
        before = now;
    }
}

// What a whole object is lowered by comes again with each of its fields.
TEST(SensationRenderer, ACapThatOthersNeedLeavesItAlone)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=0mm"), object(sheet(10), 2)};
    scene.whole.fields = {Eigen::VectorXcf::Constant(octagon().size(), 0.25f)};
    scene.run(0.03);
    for (int i = 0; i < 100; ++i)
    {
        scene.run(kStep_s);
        scene.renderer.noteCap(0.9);
    }
    scene.objects.pop_back();
    scene.whole = {};
    EXPECT_NEAR(scene.run(0.05).foci.targets[0], kPressure_Pa, 1e-3);
    Scene alone;
    alone.objects = {sensation("circle?radius=0mm")};
    EXPECT_NEAR(scene.run(kStep_s).q.norm(), alone.run(0.05).q.norm(), 1e-3);
}

// From rest, too, a whole object fades and isn't cut.
TEST(SensationRenderer, AWholeObjectFadesBelowAHigherPriority)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=0mm"), object(sheet(10), 2)};
    scene.objects[0].properties.priority = 1;
    scene.whole.fields = {Eigen::VectorXcf::Constant(octagon().size(), 0.25f)};
    scene.frame();
    double last = 1.0;
    for (int i = 0; i < 30; ++i)
    {
        scene.field();
        EXPECT_LE(last - scene.renderer.whole(), 1.01 * kStep_s / Precedence::kFade_s) << i;
        last = scene.renderer.whole();
    }
    EXPECT_EQ(last, 0.0);
}

// Other options make another renderer; nobody asked for the click again.
TEST(SensationRenderer, OtherOptionsDontPlayItAgain)
{
    Scene scene;
    scene.objects = {sensation("click"), sensation("circle?radius=10mm", 2)};
    scene.objects[0].properties.sensation.trigger = Trigger::PROGRAM;
    scene.objects[0].properties.sensation.plays = 1;
    scene.run(0.5);
    EXPECT_EQ(scene.run(kStep_s).foci.size(), 1) << "the click is over";
    const double time_ms = scene.renderer.view().sensations[1].patternTime_ms;
    ContactRenderer other(octagon(), {});
    other.continueSensations(scene.renderer);
    std::vector<HapticObject> now = scene.objects;
    other.update(now, {}, scene.now_s, 0.0);
    const RenderedField field = other.render(scene.now_s, {}, 0.0, 1000.0);
    EXPECT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(other.view().sensations[1].patternTime_ms, time_ms + 1.0, 1.01);
    // Nor when it was gone for a while.
    scene.objects.erase(scene.objects.begin());
    scene.objects.push_back(sensation("circle", 3));
    now = scene.objects;
    other.update(now, {}, scene.now_s, 0.0);
    now.push_back(sensation("click"));
    now.back().properties.sensation.trigger = Trigger::PROGRAM;
    now.back().properties.sensation.plays = 1;
    other.update(now, {}, scene.now_s, 0.0);
    EXPECT_EQ(other.render(scene.now_s + 0.02, {}, 0.0, 1000.0).foci.size(), 2);
    now.back().properties.sensation.plays = 2;
    other.update(now, {}, scene.now_s, 0.0);
    other.render(scene.now_s + 0.03, {}, 0.0, 1000.0);
    EXPECT_EQ(other.render(scene.now_s + 0.04, {}, 0.0, 1000.0).foci.size(), 3);
}

// As a scene that is switched off and on, however soon.
TEST(SensationRenderer, OneThatWasTakenAwayWhileItPlayedBeginsAnew)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=10mm")};
    scene.objects[0].properties.sensation.trigger = Trigger::PROGRAM;
    scene.objects[0].properties.sensation.plays = 1;
    EXPECT_EQ(scene.run(0.05).foci.size(), 1);
    const std::vector<HapticObject> kept = std::exchange(scene.objects, {});
    EXPECT_EQ(scene.run(0.05).foci.size(), 0);
    scene.objects = kept;
    EXPECT_EQ(scene.run(0.05).foci.size(), 1);
    scene.renderer.clear();
    EXPECT_EQ(scene.run(0.05).foci.size(), 1);
    scene.objects[0].properties.sensation.plays = 0;
    scene.run(0.05);
    scene.objects.clear();
    scene.run(0.05);
    scene.objects = kept;
    scene.objects[0].properties.sensation.plays = 0;
    EXPECT_EQ(scene.run(0.05).foci.size(), 0) << "the program has ended it";
}

TEST(SensationRenderer, SlowFieldsGetAnOutlineAndNothingAliases)
{
    Scene scene;
    scene.rate_Hz = 88.0;
    scene.objects = {sensation("circle?radius=20mm&frequency=70Hz")};
    const RenderedField field = scene.run(0.03);
    ASSERT_EQ(field.foci.size(), 8);
    for (int l = 0; l < 8; ++l)
        EXPECT_NEAR(field.foci.positions.col(l).norm(), 0.02, 1e-9);
    ASSERT_EQ(scene.renderer.sensationProblems().size(), 1u);
    scene.rate_Hz = 1000.0;
    EXPECT_EQ(scene.run(0.03).foci.size(), 1);
    EXPECT_TRUE(scene.renderer.sensationProblems().empty());
}

// Two circles, the second a quarter of a turn behind, of which one is modulated.
TEST(SensationRenderer, ASteadyTurnIsThatOfItsSamples)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=20mm&frequency=50Hz")};
    scene.run(0.005);
    scene.objects.push_back(sensation("point-am?radius=10mm&frequency=50Hz&modulation=100", 2));
    scene.objects.back().pose.translation().x() = 0.05;
    EXPECT_FALSE(scene.renderer.steady(0.0)) << "it hasn't begun";
    scene.run(0.003);
    EXPECT_FALSE(scene.renderer.steady(0.0)) << "it fades in";
    scene.run(0.02);
    const std::optional<SteadyTurn> steady = scene.renderer.steady(0.0);
    ASSERT_TRUE(steady);
    EXPECT_FALSE(steady->storedIn({1000.0, 1024, 40e3})) << "fields one by one do";
    const auto turn = steady->storedIn({200.0, 1024, 40e3});
    ASSERT_TRUE(turn);
    EXPECT_EQ(turn->periods, 2 * turn->turns);
    for (int field = 0; field < turn->fields; ++field)
    {
        const double turns = static_cast<double>(field * turn->turns) / turn->fields;
        const double first_rad = 2.0 * M_PI * turns;
        const double second_rad = 2.0 * M_PI * (turns - 0.005 * 50.0);
        const std::vector<ContactFocus> foci = steady->foci(*turn, field);
        const Vector3d circle = 0.02 * Vector3d(std::cos(first_rad), std::sin(first_rad), 0.0);
        EXPECT_LT((foci.at(0).position - circle).norm(), 1e-9);
        EXPECT_EQ(foci[0].pressure_Pa, kPressure_Pa);
        // The only modulation goes on from its last sample, 22 ms after its begin at none.
        const double wave = 0.5 + 0.5 * std::cos(2.0 * M_PI * (2.0 * turns + 0.5 + 100.0 * 0.022));
        if (foci.size() < 2)
        {
            EXPECT_LT(wave, 1e-6);
            continue;
        }
        EXPECT_NEAR(foci[1].pressure_Pa, kPressure_Pa * wave, 1e-6);
        const Vector3d point =
            Vector3d(0.05 + 0.01 * std::cos(second_rad), 0.01 * std::sin(second_rad), 0.0);
        EXPECT_LT((foci[1].position - point).norm(), 1e-9);
    }
}

TEST(SensationRenderer, WhatChangesIsNotSteady)
{
    Scene scene;
    const auto isSteady = [&] { return scene.renderer.steady(0.0).has_value(); };
    scene.objects = {sensation("circle")};
    scene.run(0.03);
    const std::optional<SteadyTurn> before = scene.renderer.steady(0.0);
    ASSERT_TRUE(before);
    scene.run(0.0123);
    EXPECT_TRUE(scene.renderer.steady(0.0)->isSame(*before)) << "whatever the time";
    scene.objects[0].pose.translation().x() = 1e-4;
    scene.run(0.01);
    EXPECT_FALSE(scene.renderer.steady(0.0)->isSame(*before)) << "another place";
    scene.objects[0].pose.translation().x() = 0.0;
    scene.objects[0].properties.sensation.parameters = {{"intensity", 0.5}};
    scene.run(0.01);
    EXPECT_FALSE(scene.renderer.steady(0.0)->isSame(*before)) << "another parameter";
    scene.objects[0].properties.sensation.parameters.clear();
    scene.objects[0].properties.pressure = 999.0;
    scene.run(0.01);
    EXPECT_FALSE(scene.renderer.steady(0.0)->isSame(*before)) << "another pressure";
    scene.objects[0].properties.pressure = kPressure_Pa;
    scene.run(0.01);
    EXPECT_TRUE(scene.renderer.steady(0.0)->isSame(*before));

    scene.objects.push_back(sensation("circle?frequency=71", 2));
    scene.run(0.03);
    EXPECT_FALSE(scene.renderer.steady(0.0)->storedIn({100.0, 1024, 40e3})) << "other turns";
    scene.objects[1].properties.sensation.pattern = classic("pulse?repeat=1");
    scene.run(0.03);
    EXPECT_FALSE(isSteady()) << "it moves";
    scene.objects.pop_back();
    scene.run(0.03);
    EXPECT_TRUE(isSteady());
    scene.objects.push_back(object(sheet(), 3));
    scene.run(0.03);
    EXPECT_FALSE(isSteady()) << "a whole object is played, too";
    scene.objects.pop_back();
    scene.run(0.2);
    EXPECT_TRUE(isSteady());
    scene.objects[0].properties.sensation.trigger = Trigger::PROGRAM;
    scene.run(0.01);
    EXPECT_FALSE(isSteady()) << "it fades out";
}

TEST(SensationRenderer, TenPlayAtOnceAndTheRestIsTold)
{
    Scene scene;
    for (std::uint64_t id = 1; id <= 12; ++id)
    {
        scene.objects.push_back(sensation("circle?radius=0mm", id));
        scene.objects.back().pose.translation().x() = 0.01 * (static_cast<double>(id) - 6.5);
    }
    const RenderedField field = scene.run(0.03);
    EXPECT_FALSE(field.isFailed);
    EXPECT_EQ(field.foci.size(), 10);
    EXPECT_EQ(scene.renderer.sensationProblems().size(), 2u);
}

// Whatever numbers a scene gives, no field has one that isn't finite.
TEST(SensationRenderer, BrokenOnesAreSilent)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=20mm")};
    scene.objects[0].properties.sensation.pattern = nullptr;
    EXPECT_EQ(scene.run(0.02).foci.size(), 0);
    EXPECT_FALSE(scene.renderer.isActive(scene.now_s));

    patterns::Json broken = patterns::pattern({patterns::standard(0.0, patterns::coords(0, 0, 0))});
    const patterns::Json one = {{"type", "constant"}, {"value", 1.0}};
    const patterns::Json zero = {{"type", "constant"}, {"value", 0.0}};
    broken["pattern_transform"]["playback_speed"] = {
        {"type", "formula"},
        {"value", {{"type", "divide"}, {"value", patterns::Json::array({one, zero})}}}};
    scene.objects[0].properties.sensation.pattern = patterns::read(broken);
    RenderedField field = scene.run(0.05);
    EXPECT_EQ(field.foci.size(), 0);
    EXPECT_TRUE(field.q.allFinite());

    scene.objects[0] = sensation("circle?radius=20mm");
    scene.objects[0].pose.translation().x() = std::nan("");
    field = scene.run(0.05);
    EXPECT_TRUE(field.q.allFinite());
    EXPECT_TRUE(field.q.isZero());
}

TEST(SensationRenderer, ParametersOfProgramAndTouchReachThePattern)
{
    Scene scene;
    scene.objects = {sensation("circle?radius=20mm")};
    scene.objects[0].properties.sensation.parameters = {{"radius", 5.0}};
    RenderedField field = scene.run(0.02);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(field.foci.positions.col(0).norm(), 0.005, 1e-9);
    scene.objects[0].properties.sensation.parameters = {{"radius", 8.0}};
    scene.frame();
    field = scene.field();
    EXPECT_NEAR(field.foci.positions.col(0).norm(), 0.008, 1e-9) << "in the next field";

    patterns::Json near = patterns::pattern(
        {[]
         {
             patterns::Json frame = patterns::standard(0.0, patterns::coords(0, 0, 0));
             frame["intensity"] = patterns::intensity(patterns::parameter("proximity"));
             return frame;
         }()});
    patterns::define(near, "proximity", {{"default", 0.0}});
    scene.objects[0] = sensation("circle?radius=0mm", 7);
    scene.objects[0].mesh = sheet();
    scene.objects[0].properties.sensation.pattern = patterns::read(near);
    EXPECT_EQ(scene.run(0.02).foci.size(), 0);
    scene.hands = ball(Vector3d(0, 0, 0.058)); // its skin 50 mm away
    field = scene.run(0.02);
    ASSERT_EQ(field.foci.size(), 1);
    EXPECT_NEAR(field.foci.targets[0] / kPressure_Pa, 0.5, 0.01);
}
