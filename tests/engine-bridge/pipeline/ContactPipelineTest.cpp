// Objects that are felt where hands touch them, through the whole pipeline.
#include "device/limits/GuardedDevice.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Eigen::Vector3d;

namespace
{

/// What tells the pipelines the time: it passes with their frames and fields alone.
midair::test::SetClock& timeOfAll()
{
    static midair::test::SetClock clock;
    return clock;
}

HologramOptions contactOptions(Render render = Render::CONTACT)
{
    HologramOptions options;
    options.clock = &timeOfAll();
    options.array = haptics::TransducerArray::octagonalPrism();
    options.contacts.shares.render = render;
    return options;
}

/// A sheet in the array's middle and a finger, \a depth_m deep in it; none if it isn't finite.
SceneSnapshot touching(double depth_m, double x_m = 0.0)
{
    SceneSnapshot snapshot;
    snapshot.time_s = timeOfAll().now_s();
    snapshot.objects.push_back(bridge::test::object(bridge::test::sheet()));
    snapshot.objects[0].path = "Scene/Sheet";
    if (std::isfinite(depth_m))
        snapshot.hands = bridge::test::ball(Vector3d(x_m, 0.0, 8e-3 - depth_m));
    return snapshot;
}

constexpr double kNoHand = std::numeric_limits<double>::quiet_NaN();
constexpr double kDeep = 1.5e-3;

/// Frames of \a snapshot and fields in between, for \a time_s and at least three frames. Calls \a
/// look with each result.
template<typename Look>
void run(HologramPipeline& pipeline, SceneSnapshot snapshot, double time_s, Look look)
{
    const double begin_s = timeOfAll().now_s();
    double frame_s = -1.0;
    for (int frames = 0; frames < 3 || timeOfAll().now_s() - begin_s < time_s;)
    {
        const double now_s = timeOfAll().now_s();
        if (now_s - frame_s > 0.01)
        {
            frame_s = snapshot.time_s = now_s;
            ++frames;
            look(*pipeline.process(snapshot));
        }
        if (const auto result = pipeline.attend()) look(*result);
        timeOfAll().jump(std::clamp(pipeline.rest_s(), 1e-4, 1e-3));
    }
}

std::shared_ptr<const HologramResult>
after(HologramPipeline& pipeline, const SceneSnapshot& snapshot, double time_s)
{
    std::shared_ptr<const HologramResult> last;
    run(pipeline,
        snapshot,
        time_s,
        [&](const HologramResult& result) { last = std::make_shared<HologramResult>(result); });
    return last;
}

double drive(const HologramResult& result)
{
    double most = 0.0;
    for (const Eigen::VectorXcf& q : result.sequence.fields)
        most = std::max(most, static_cast<double>(q.norm()));
    return most;
}

} // namespace

TEST(ContactPipeline, AWholeObjectIsPlayedAsEverWhoeverTouches)
{
    HologramPipeline pipeline(contactOptions(Render::OBJECT));
    const auto result = after(pipeline, touching(kDeep), 0.1);
    EXPECT_EQ(result->counters.contactFields, 0u);
    EXPECT_EQ(result->touched, nullptr);
    EXPECT_GT(result->points.size(), 20);
    EXPECT_EQ(result->counters.solves, 1u);
}

TEST(ContactPipeline, AnObjectOfContactsIsSilentUntilItIsTouched)
{
    HologramPipeline pipeline(contactOptions());
    for (const double depth_m : {kNoHand, -0.05, -2e-3})
    {
        const auto result = after(pipeline, touching(depth_m), 0.05);
        EXPECT_EQ(drive(*result), 0.0) << depth_m;
        EXPECT_EQ(result->state, ArrayState::SILENT) << depth_m;
        EXPECT_EQ(result->counters.contactFields, 0u) << depth_m;
        EXPECT_EQ(result->counters.solves, 0u);
        EXPECT_TRUE(result->messages.empty());
        EXPECT_GT(pipeline.counters().skippedUnmoved, 0u);
        EXPECT_EQ(pipeline.rest_s(), HologramPipeline::kAttend_s);
    }
    const auto touched = after(pipeline, touching(kDeep), 0.3);
    EXPECT_EQ(touched->state, ArrayState::PLAYING);
    EXPECT_GT(touched->counters.contactFields, 50u);
    ASSERT_EQ(touched->touched->contacts.size(), 1u);
    ASSERT_GT(touched->points.size(), 0);
    EXPECT_TRUE(touched->points.absolute);
    // The force is 15 mN: 10 N/m times 1.5 mm, on 22 mm^2; within the levels of the device.
    const double rhoCC_Pa = 1.204 * 343.2 * 343.2, wanted_Pa = std::sqrt(rhoCC_Pa * 0.015 / 22e-6);
    EXPECT_NEAR(touched->achieved_Pa.cast<double>().norm(), wanted_Pa, 0.02 * wanted_Pa);
    EXPECT_LT(touched->report().rms, 0.02);
    EXPECT_GT(touched->fingertip.force_N, 5e-3);
    EXPECT_LT(touched->fingertip.force_N, 30e-3) << "of foci that sound one at a time: 15 mN";
    EXPECT_EQ(touched->fingertip.how, haptics::PlayedAs::CIRCLING);
    for (Eigen::Index l = 0; l < touched->points.positions.cols(); ++l)
        EXPECT_NEAR(
            (touched->points.positions.col(l) - Vector3d(0, 0, 8e-3 - kDeep)).norm(), 8e-3, 1e-3);
    const auto left = after(pipeline, touching(-0.05), 0.2);
    EXPECT_EQ(drive(*left), 0.0);
    EXPECT_EQ(left->state, ArrayState::SILENT);
}

// A wake-up is late, or very late; the rate stays, and nothing is made up for.
TEST(ContactPipeline, FieldsKeepToTheClockOfTheirRate)
{
    HologramOptions options = contactOptions();
    options.fieldRate = 500.0;
    HologramPipeline pipeline(options);
    after(pipeline, touching(kDeep), 0.3); // it plays
    const auto fieldsIn = [&](double time_s, double late_s)
    {
        const std::uint64_t before = pipeline.counters().contactFields;
        const double begin_s = timeOfAll().now_s();
        while (timeOfAll().now_s() - begin_s < time_s)
        {
            timeOfAll().jump(pipeline.rest_s() + late_s);
            pipeline.attend();
        }
        return static_cast<double>(pipeline.counters().contactFields - before);
    };
    EXPECT_NEAR(fieldsIn(0.05, 1e-6), 25.0, 1.0);
    EXPECT_NEAR(fieldsIn(0.05, 0.9e-3), 25.0, 1.0);
    EXPECT_EQ(fieldsIn(1e-3, 21.3e-3), 1.0) << "ten are left out";
    EXPECT_NEAR(fieldsIn(0.02, 1e-6), 10.0, 1.0);
}

TEST(ContactPipeline, AWholeObjectBesideKeepsItsPressure)
{
    SceneSnapshot snapshot = touching(kDeep);
    HapticObject other =
        bridge::test::object(bridge::test::sheet(10), 2, Eigen::Isometry3d::Identity());
    other.pose.translation() = Vector3d(0.0, 0.0, -0.06);
    other.properties.render = Render::OBJECT;
    other.properties.pressure = 500.0;
    other.properties.pressureInPa = true;
    snapshot.objects.push_back(other);
    HologramPipeline pipeline(contactOptions());
    const auto result = after(pipeline, snapshot, 0.3);
    ASSERT_EQ(result->points.object.size(), static_cast<std::size_t>(result->points.size()));
    int ofOther = 0;
    double sum_Pa = 0.0;
    for (std::size_t l = 0; l < result->points.object.size(); ++l)
        if (result->points.object[l] == 1)
        {
            ++ofOther;
            sum_Pa += result->achieved_Pa[static_cast<Eigen::Index>(l)];
        }
    ASSERT_GT(ofOther, 5);
    EXPECT_LT(ofOther, result->points.size());
    // The side lobes of foci of 8 kPa, some 300 Pa, add to it; without it they are all there is.
    EXPECT_GT(sum_Pa / ofOther, 400.0);
    EXPECT_LT(sum_Pa / ofOther, 900.0);
    EXPECT_EQ(result->touched->whole, 1.0);
    const auto alone = after(
        pipeline,
        [&]
        {
            snapshot.hands = {};
            return snapshot;
        }(),
        0.3);
    EXPECT_EQ(alone->points.size(), ofOther);
    EXPECT_NEAR(alone->achieved_Pa.mean(), 500.0, 5.0);
}

// The whole has a ratio for its target, 1, and hundreds of Pa: no error of its is one of contacts.
TEST(ContactPipeline, FiguresOfContactsAreNotThoseOfWholeObjects)
{
    SceneSnapshot snapshot = touching(kDeep);
    HapticObject other =
        bridge::test::object(bridge::test::sheet(10), 2, Eigen::Isometry3d::Identity());
    other.pose.translation() = Vector3d(0.0, 0.0, -0.06);
    other.properties.render = Render::OBJECT;
    snapshot.objects.push_back(other);
    HologramPipeline pipeline(contactOptions());
    const auto result = after(pipeline, snapshot, 0.3);
    ASSERT_TRUE(result->touched);
    ASSERT_GT(result->points.size(), 10);
    double foci = 0.0, squares = 0.0, worst = 0.0;
    for (Eigen::Index l = 0; l < result->points.size(); ++l)
    {
        if (result->points.object[static_cast<std::size_t>(l)] == 1) continue;
        const double wanted_Pa = result->points.targets[l];
        ASSERT_GT(wanted_Pa, 1000.0);
        const double error = result->achieved_Pa[l] / wanted_Pa - 1.0;
        ++foci;
        squares += error * error;
        worst = std::max(worst, std::fabs(error));
    }
    ASSERT_GT(foci, 0.0);
    EXPECT_NEAR(result->report().rms, std::sqrt(squares / foci), 1e-5);
    EXPECT_NEAR(result->report().max, worst, 1e-5);
}

// From the first moment of a touch on: 8e13 % was told. A focus that wants 1 % of what the whole
// object gets, which it fades into, has 100 times as much.
TEST(ContactPipeline, NoErrorOfContactsIsBeyondAllMeasure)
{
    for (const Render render : {Render::CONTACT, Render::AUTO})
    {
        HologramPipeline pipeline(contactOptions(render));
        after(pipeline, touching(kNoHand), 0.05);
        double most = 0.0;
        const auto look = [&](const HologramResult& result) {
            most = std::max({most, result.report().rms, result.report().max});
        };
        for (const double depth_m : {1e-8, 2e-6, kDeep, -1e-3, kNoHand})
            run(pipeline, touching(depth_m), 0.15, look);
        EXPECT_LT(most, 200.0) << static_cast<int>(render);
    }
}

// A ring that wants 11 kPa and a button that wants 1.8 kPa, beside each other under a cap.
TEST(ContactPipeline, AGreedyContactDoesNotWeakenTheOthers)
{
    SceneSnapshot snapshot = touching(kDeep, -0.03);
    snapshot.objects.clear();
    for (const std::uint64_t id : {1, 2})
    {
        HapticObject& made =
            snapshot.objects.emplace_back(bridge::test::object(bridge::test::sheet(10), id));
        made.pose.translation().x() = id == 1 ? -0.03 : 0.03;
        made.path = id == 1 ? "Scene/Ring" : "Scene/Button";
        made.properties.material.stiffness_N_m = 1000.0;
        made.properties.material.mostForce_N = id == 1 ? 0.02 : 5e-4;
    }
    const Vector3d place(0.03, 0.0, 8e-3 - kDeep);
    bridge::test::addBone(snapshot.hands.hands[0], MIDDLE_TIP, place, place);
    HologramOptions options = contactOptions();
    options.maxPressure = 3000.0;
    HologramPipeline pipeline(options);
    const auto result = after(pipeline, snapshot, 0.3);
    ASSERT_TRUE(result->touched);
    double ring_Pa = 0.0, button_Pa = 0.0, wanted_Pa = 0.0;
    for (Eigen::Index l = 0; l < result->points.size(); ++l)
    {
        const bool isRing = result->points.object[static_cast<std::size_t>(l)] == 0;
        double& most_Pa = isRing ? ring_Pa : button_Pa;
        most_Pa = std::max(most_Pa, static_cast<double>(result->achieved_Pa[l]));
        if (!isRing) wanted_Pa = std::max<double>(wanted_Pa, result->points.targets[l]);
    }
    ASSERT_GT(wanted_Pa, 500.0);
    EXPECT_LE(ring_Pa, 3000.0 * (1.0 + 1e-5));
    EXPECT_GT(ring_Pa, 2700.0);
    EXPECT_GT(button_Pa, 0.9 * wanted_Pa);
    const auto& told = result->told;
    const auto cap = std::find_if(told.begin(),
                                  told.end(),
                                  [](const base::Message& one)
                                  { return one.code == base::MessageCode::CAP_PRESSURE; });
    ASSERT_NE(cap, told.end());
    EXPECT_NE(cap->text.find("Scene/Ring wants "), std::string::npos) << cap->text;
    EXPECT_NE(cap->text.find("contactForce"), std::string::npos) << cap->text;
    EXPECT_NE(cap->text.find("3000 Pa (MaxPressure)"), std::string::npos) << cap->text;
    EXPECT_EQ(cap->text.find("Button"), std::string::npos) << cap->text;
}

TEST(ContactPipeline, AutoPlaysTheWholeWhereNoHandIsKnown)
{
    HologramOptions options = contactOptions(Render::AUTO);
    options.restAfter_s = std::numeric_limits<double>::infinity(); // the whole stays as it is
    HologramPipeline pipeline(options);
    const auto unknown = after(pipeline, touching(kNoHand), 0.05);
    EXPECT_GT(unknown->points.size(), 20);
    EXPECT_GT(drive(*unknown), 1.0);
    const auto known = after(pipeline, touching(-0.05), 0.3);
    EXPECT_EQ(drive(*known), 0.0);
    const auto touched = after(pipeline, touching(kDeep), 0.2);
    EXPECT_LE(touched->points.size(), 4);
    EXPECT_GT(touched->achieved_Pa.maxCoeff(), 2000.0f);
    const auto lost = after(pipeline, touching(kNoHand), 0.4);
    EXPECT_EQ(lost->points.size(), unknown->points.size());
    EXPECT_NEAR(lost->achieved_Pa.mean(), unknown->achieved_Pa.mean(), 5.0f);
}

// What rests is evened out; a touch plays contacts as before, and ends it for a while.
TEST(ContactPipeline, AutoPlaysContactsInPlaceOfAnEvenedWhole)
{
    HologramPipeline pipeline(contactOptions(Render::AUTO));
    const auto evened = after(pipeline, touching(kNoHand), 5.0);
    EXPECT_TRUE(evened->sequence.evened);
    const auto touched = after(pipeline, touching(kDeep), 0.4);
    EXPECT_FALSE(touched->sequence.evened);
    EXPECT_LE(touched->points.size(), 4);
    EXPECT_GT(touched->achieved_Pa.maxCoeff(), 2000.0f);
    EXPECT_LT(touched->report().rms, 0.02);
    EXPECT_EQ(drive(*after(pipeline, touching(-0.05), 0.3)), 0.0);
    const auto lost = after(pipeline, touching(kNoHand), 0.4);
    EXPECT_EQ(lost->points.size(), evened->points.size());
    EXPECT_TRUE(after(pipeline, touching(kNoHand), 5.0)->sequence.evened);
}

TEST(ContactPipeline, CapsHoldForEachOfItsFields)
{
    HologramOptions options = contactOptions();
    options.maxPressure = 900.0;
    HologramPipeline pressure(options);
    int fields = 0;
    double most_Pa = 0.0;
    run(pressure,
        touching(kDeep),
        0.2,
        [&](const HologramResult& result)
        {
            if (drive(result) == 0.0 || !result.touched) return;
            ++fields;
            most_Pa = std::max(
                most_Pa,
                loudestInDouble(
                    result.points.positions, *result.array, result.medium, result.played()));
        });
    EXPECT_GT(fields, 3);
    EXPECT_LE(most_Pa, 900.0 * (1.0 + 1e-5));
    EXPECT_GT(most_Pa, 800.0);

    options = contactOptions();
    options.earLimit = 110.0;
    options.earPoints = Vector3d(0.0, 0.5, 0.0);
    HologramPipeline ears(options);
    double most_dB = 0.0;
    run(ears,
        touching(kDeep),
        0.2,
        [&](const HologramResult& result)
        {
            if (drive(result) == 0.0 || !result.touched) return;
            const double p_Pa =
                loudestInDouble(options.earPoints, *result.array, result.medium, result.played());
            most_dB = std::max(most_dB, 20.0 * std::log10(p_Pa / std::sqrt(2.0) / 20e-6));
        });
    EXPECT_GT(most_dB, 60.0);
    EXPECT_LE(most_dB, 110.0);
}

TEST(ContactPipeline, WithoutFramesItFallsSilent)
{
    HologramPipeline pipeline(contactOptions());
    ASSERT_GT(drive(*after(pipeline, touching(kDeep), 0.2)), 0.0);
    std::shared_ptr<const HologramResult> last;
    EXPECT_TRUE(eventually(
        [&]
        {
            timeOfAll().jump(1e-3);
            if (const auto result = pipeline.attend()) last = result;
            return last && drive(*last) == 0.0;
        }));
    EXPECT_EQ(last->state, ArrayState::SILENT);
    ASSERT_TRUE(last->touched);
    for (const ContactView& contact : last->touched->contacts)
        EXPECT_EQ(contact.foci.cols(), 0);
    EXPECT_GT(drive(*after(pipeline, touching(kDeep), 0.2)), 0.0);
}

TEST(ContactPipeline, AHandThatIsNoNumberIsToldAndFeelsNothing)
{
    HologramPipeline pipeline(contactOptions());
    SceneSnapshot snapshot = touching(kDeep);
    for (HandJoint& joint : snapshot.hands.hands[0].joints)
        joint.position.x() = NAN;
    const auto result = after(pipeline, snapshot, 0.05);
    EXPECT_EQ(drive(*result), 0.0);
    ASSERT_FALSE(result->messages.empty());
    EXPECT_NE(result->messages[0].find("contact of hand 0"), std::string::npos)
        << result->messages[0];
    EXPECT_GT(drive(*after(pipeline, touching(kDeep), 0.2)), 0.0);
}

TEST(ContactPipeline, MutedItSendsNothingAndGoesOnAfterwards)
{
    HologramPipeline pipeline(contactOptions());
    ASSERT_GT(drive(*after(pipeline, touching(kDeep), 0.1)), 0.0);
    pipeline.device().setMuted(true);
    const auto muted = after(pipeline, touching(kDeep), 0.1);
    EXPECT_EQ(muted->state, ArrayState::MUTED);
    EXPECT_EQ(drive(*muted), 0.0);
    pipeline.device().setMuted(false);
    const auto again = after(pipeline, touching(kDeep), 0.1);
    EXPECT_EQ(again->state, ArrayState::PLAYING);
    EXPECT_GT(drive(*again), 0.0);
}

TEST(ContactPipeline, NewOptionsOfContactsHoldFromTheNextFrame)
{
    HologramPipeline pipeline(contactOptions());
    ASSERT_GT(drive(*after(pipeline, touching(kDeep), 0.1)), 0.0);
    HologramOptions options = contactOptions(Render::OBJECT);
    pipeline.reconfigure(options);
    const auto whole = after(pipeline, touching(kDeep), 0.1);
    EXPECT_EQ(whole->touched, nullptr);
    EXPECT_GT(whole->points.size(), 20);
    options.contacts.tracker.path.rate_Hz = NAN;
    pipeline.reconfigure(options);
    EXPECT_EQ(drive(*after(pipeline, touching(kDeep), 0.1)), 0.0);
}
