#include "engine-bridge/contact/ContactTracker.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kFrame_s = 1.0 / 90.0;

bool isNoted(const ContactTracker& tracker, ContactReason reason)
{
    for (const ContactNote& note : tracker.notes())
        if (note.reason == reason) return true;
    return false;
}

/// Foci of one moment by contact and number.
using Foci = std::map<std::pair<std::uint64_t, int>, ContactFocus>;

Foci byName(const std::vector<ContactFocus>& foci)
{
    Foci result;
    for (const ContactFocus& focus : foci)
        result[{focus.contact, focus.index}] = focus;
    return result;
}

// A finger goes round on a sphere at 0.2 m/s, so that the patch is fitted anew in each frame: steps
// stay within half a millimetre, the contact stays one, and the foci stay near it.
TEST(ContactTracker, StepsAreSmallWhileTheHandMoves)
{
    ContactTracker tracker;
    const HapticObject ball = test::object(sphere(0.03, 20));
    double frame_s = 0.0;
    Foci before;
    int compared = 0;
    for (int i = 0; i < 3000; ++i)
    {
        const double time = i * kField_s;
        if (time >= frame_s)
        {
            const double angle = 0.2 * time / 0.036;
            const double depth = 2e-3 + 1e-3 * std::sin(3.0 * time);
            const Vector3d way(std::cos(angle), std::sin(angle), 0.0);
            tracker.update({ball}, test::ball((0.03 + kR - depth) * way), time);
            frame_s += kFrame_s;
        }
        ASSERT_TRUE(tracker.advance(kField_s));
        const Foci now = byName(tracker.foci());
        for (const auto& [name, focus] : now)
        {
            const auto old = before.find(name);
            if (old == before.end() || now.size() != before.size()) continue;
            EXPECT_LE((focus.position - old->second.position).norm(), 0.5e-3 + 1e-9);
            ++compared;
            // A frame's motion at most behind its place on a path of some 3 mm.
            EXPECT_LT((focus.position - focus.centre).norm(), 7e-3);
        }
        before = now;
        ASSERT_EQ(tracker.contacts().size(), 1u);
        EXPECT_EQ(tracker.contacts()[0].id, 1u);
        EXPECT_NEAR(tracker.contacts()[0].path.turningRate_Hz(), 5.0, 0.05);
        if (time > 0.5)
        {
            EXPECT_NEAR(tracker.contacts()[0].speed_m_s, 0.2, 0.01);
        }
    }
    EXPECT_GT(compared, 2900);
}

// A millimetre of tremor about contact, about the border between one focus and two, and about the
// place where contacts end: nothing switches.
TEST(ContactTracker, TremorSwitchesNothing)
{
    for (const double depth : {0.0, 1.5e-3, -1.5e-3})
    {
        ContactTracker tracker;
        const HapticObject sheet = test::object(test::sheet());
        tracker.update({sheet}, test::ball({0, 0, kR - 1e-3}), 0.0);
        std::set<std::uint64_t> ids;
        int switches = 0;
        std::size_t foci = 0;
        for (int i = 0; i < 2000; ++i)
        {
            const double time = i * kField_s;
            if (i % 11 == 0)
            {
                const Vector3d tremor(
                    std::sin(54.0 * time), std::sin(61.0 * time), std::sin(57.0 * time));
                tracker.update(
                    {sheet}, test::ball(Vector3d(0, 0, kR - depth) + 1e-3 * tremor), time);
            }
            tracker.advance(kField_s);
            ASSERT_EQ(tracker.contacts().size(), 1u) << depth << " " << i;
            ids.insert(tracker.contacts()[0].id);
            if (i < 800) continue; // until the number of foci has settled
            const std::size_t count = tracker.contacts()[0].path.foci().size();
            switches += foci != 0 && foci != count;
            foci = count;
        }
        EXPECT_EQ(ids.size(), 1u);
        EXPECT_EQ(switches, 0) << depth;
    }
}

TEST(ContactTracker, BeginsAtContactEndsFarFromItAndIsSilentBetween)
{
    ContactTracker tracker;
    const HapticObject sheet = test::object(test::sheet());
    const auto go = [&](double gap, double time)
    {
        tracker.update({sheet}, test::ball({0, 0, kR + gap}), time);
        double pressure = 0.0;
        for (int i = 0; i < 100; ++i)
        {
            tracker.advance(kField_s);
            pressure = tracker.foci().empty() ? 0.0 : tracker.foci()[0].pressure_Pa;
        }
        return pressure;
    };
    EXPECT_EQ(go(1e-3, 0.0), 0.0);
    EXPECT_TRUE(tracker.contacts().empty());
    const double pressed = go(-1e-3, 0.1);
    EXPECT_NEAR(pressed, ContactForce().pressure_Pa(1e-3, 1, 1.0), 0.02 * pressed);
    const double angle = tracker.contacts()[0].path.angle_rad();
    EXPECT_LT(go(3e-3, 0.2), 0.01 * pressed);
    ASSERT_EQ(tracker.contacts().size(), 1u);
    EXPECT_NEAR(std::remainder(tracker.contacts()[0].path.angle_rad() - angle, base::kTwoPi),
                std::remainder(base::kTwoPi * 0.5, base::kTwoPi),
                1e-9);
    go(-1e-3, 0.3);
    EXPECT_EQ(tracker.contacts()[0].id, 1u);
    go(4.5e-3, 0.4);
    EXPECT_TRUE(tracker.contacts().empty());
    // It comes without a click: the first field is far below the last.
    tracker.update({sheet}, test::ball({0, 0, kR - 1e-3}), 0.5);
    tracker.advance(kField_s);
    EXPECT_LT(tracker.foci().empty() ? 0.0 : tracker.foci()[0].pressure_Pa, 0.05 * pressed);
    EXPECT_EQ(tracker.contacts()[0].id, 2u);
}

// Where foci come and go the force goes on: the sum of the squares of their pressures.
TEST(ContactTracker, TheForceGoesOnWhereTheNumberOfFociChanges)
{
    ContactTracker tracker;
    const HapticObject sheet = test::object(test::sheet());
    double before = 0.0;
    std::set<std::size_t> counts;
    for (int i = 0; i < 3000; ++i)
    {
        if (i % 11 == 0) // deep enough that the force is clipped, wider and narrower
            tracker.update({sheet},
                           test::ball({0, 0, kR - 4.2e-3 + 2e-3 * std::cos(2.5e-3 * i)}),
                           i * kField_s);
        tracker.advance(kField_s);
        double sum = 0.0;
        for (const ContactFocus& focus : tracker.foci())
            sum += focus.pressure_Pa * focus.pressure_Pa;
        if (i > 100)
        {
            EXPECT_NEAR(sum, before, 1e-6 * before) << i;
            counts.insert(tracker.foci().size());
        }
        before = sum;
    }
    EXPECT_GE(counts.size(), 2u);
}

TEST(ContactTracker, AHandThatJumpsBeginsAnew)
{
    ContactTracker tracker;
    auto mesh = std::make_shared<haptics::TriangleMesh>(*test::sheet());
    mesh->vertices.topRows(2) *= 40.0; // 2.4 m
    const HapticObject sheet = test::object(mesh);
    tracker.update({sheet}, test::ball({0.5, 0, kR - 1e-3}), 0.0);
    for (int i = 0; i < 50; ++i)
        tracker.advance(kField_s);
    EXPECT_EQ(tracker.foci().size(), 1u);
    tracker.update({sheet}, test::ball({-0.5, 0, kR - 1e-3}), 0.05);
    EXPECT_TRUE(isNoted(tracker, ContactReason::HAND_JUMPED));
    ASSERT_EQ(tracker.contacts().size(), 1u);
    EXPECT_EQ(tracker.contacts()[0].id, 2u);
    for (int i = 0; i < 50; ++i)
    {
        tracker.advance(kField_s);
        for (const ContactFocus& focus : tracker.foci())
            EXPECT_LT(std::abs(focus.position.x() + 0.5), 5e-3); // nothing on the way
    }
}

TEST(ContactTracker, BadInputEndsContactsAndSaysWhy)
{
    const HapticObject sheet = test::object(test::sheet());
    ContactTracker tracker;
    const auto begin = [&](double time)
    {
        tracker.update({sheet}, test::ball({0, 0, kR - 1e-3}), time);
        EXPECT_EQ(tracker.contacts().size(), 1u);
    };
    begin(0.0);
    tracker.update({sheet}, test::ball({0, 0, kNan}), 0.01);
    EXPECT_TRUE(tracker.contacts().empty());
    EXPECT_TRUE(isNoted(tracker, ContactReason::JOINT_NOT_FINITE));
    begin(0.02);
    EXPECT_FALSE(tracker.update({sheet}, test::ball({0, 0, kR - 1e-3}), kNan));
    EXPECT_TRUE(tracker.contacts().empty());
    EXPECT_TRUE(isNoted(tracker, ContactReason::TIME_NOT_FINITE));
    begin(0.03);
    EXPECT_FALSE(tracker.update({sheet}, test::ball({0, 0, kR - 1e-3}), 0.01));
    EXPECT_TRUE(tracker.contacts().empty());
    begin(0.04);
    EXPECT_FALSE(tracker.advance(kNan));
    EXPECT_TRUE(tracker.foci().empty());
    begin(0.05);
    HapticObject lost = sheet;
    lost.pose.translation().x() = kNan;
    tracker.update({lost}, test::ball({0, 0, kR - 1e-3}), 0.06);
    EXPECT_TRUE(tracker.contacts().empty());
    EXPECT_TRUE(isNoted(tracker, ContactReason::POSE_NOT_FINITE));
    // A hand that the tracker lost is held, an object that is gone is not.
    begin(0.07);
    tracker.update({sheet}, {}, 0.15);
    EXPECT_EQ(tracker.contacts().size(), 1u);
    tracker.update({sheet}, {}, 0.19);
    EXPECT_TRUE(tracker.contacts().empty());
    begin(0.20);
    tracker.update({}, test::ball({0, 0, kR - 1e-3}), 0.21);
    EXPECT_TRUE(tracker.contacts().empty());
    ContactTrackerOptions options;
    options.restart_m = kNan;
    EXPECT_THROW(ContactTracker{options}, base::InputError);
}

// Two fingers on two objects of other materials, each sliding at its own speed: each contact has
// the frequency of its own.
TEST(ContactTracker, EachContactHasItsOwnMaterial)
{
    ContactTracker tracker;
    HapticMaterial fine, coarse;
    fine.roughness = coarse.roughness = 0.5;
    fine.texturePeriod_m = 0.5e-3;
    coarse.texturePeriod_m = 2e-3;
    Eigen::Isometry3d beside = Eigen::Isometry3d::Identity();
    beside.translation().y() = 0.1;
    std::vector<HapticObject> objects = {test::object(test::sheet(), 1),
                                         test::object(test::sheet(), 2, beside)};
    objects[0].properties.material = fine;
    objects[1].properties.material = coarse;
    for (int i = 0; i < 400; ++i)
    {
        const double time = i * kField_s;
        if (i % 11 == 0)
        {
            HandFrame hands;
            hands.hands.resize(1);
            const Vector3d a(0.05 * time - 0.01, 0, kR - 1e-3);
            const Vector3d b(0.02, 0.1 - 0.08 * time, kR - 1e-3);
            test::addBone(hands.hands[0], INDEX_TIP, a, a);
            test::addBone(hands.hands[0], LITTLE_TIP, b, b);
            tracker.update(objects, hands, time);
        }
        tracker.advance(kField_s);
    }
    ASSERT_EQ(tracker.contacts().size(), 2u);
    EXPECT_EQ(tracker.contacts()[0].path.patch().object, 1u);
    EXPECT_NEAR(tracker.contacts()[0].vibration.texture_Hz(), 100.0, 2.0);
    EXPECT_NEAR(tracker.contacts()[1].vibration.texture_Hz(), 40.0, 0.8);
    // One that can't be played is silent alone, and told.
    objects[0].properties.material.roughness = 2.0;
    HandFrame hands;
    hands.hands.resize(1);
    const Vector3d a(0.0, 0.0, kR - 1e-3), b(0.0, 0.1, kR - 1e-3);
    test::addBone(hands.hands[0], INDEX_TIP, a, a);
    test::addBone(hands.hands[0], LITTLE_TIP, b, b);
    tracker.update(objects, hands, 0.4);
    for (const Contact& contact : tracker.contacts())
        EXPECT_EQ(contact.path.patch().object, 2u);
    ASSERT_FALSE(tracker.notes().empty());
    EXPECT_EQ(tracker.notes()[0].reason, ContactReason::MATERIAL_INVALID);
}

// Perception of softness by radius and rate: 1 mm + 0.16 x depth, and 200 Hz a metre of depth.
TEST(ContactTracker, SoftThingsGrowUnderTheFinger)
{
    ContactTracker tracker;
    std::vector<HapticObject> objects = {test::object(test::sheet(), 1)};
    HapticMaterial& soft = objects[0].properties.material;
    soft.radius_m = 1e-3;
    soft.radiusGrowth = 0.5;
    soft.rateGrowth_Hz_m = 500.0;
    for (const double depth_m : {1e-3, 4e-3})
    {
        for (int i = 0; i < 300; ++i)
        {
            const double time = depth_m * 100.0 + i * kField_s;
            if (i % 11 == 0) tracker.update(objects, test::ball({0.0, 0.0, kR - depth_m}), time);
            tracker.advance(kField_s);
        }
        ASSERT_EQ(tracker.contacts().size(), 1u);
        const ContactPath& path = tracker.contacts()[0].path;
        EXPECT_NEAR(path.semiMajor_m(), 1e-3 + 0.5 * depth_m, 0.05e-3);
        EXPECT_EQ(path.semiMajor_m(), path.semiMinor_m());
        EXPECT_NEAR(path.turningRate_Hz(), 5.0 + 500.0 * depth_m, 0.1);
    }
}

// A sheet painted in stripes of 10 mm along x, from 0 to 1 and back: a finger at 0.05 m/s feels
// a wave of 5 Hz.
TEST(ContactTracker, WhatIsPaintedIsFeltAsTheFingerGoesOverIt)
{
    auto mesh = std::make_shared<haptics::TriangleMesh>(*test::sheet(30, 2e-3));
    mesh->intensity.resize(mesh->vertices.cols());
    const auto height = [](double x_m) { return 0.5 - 0.5 * std::cos(base::kTwoPi * x_m / 0.01); };
    for (Eigen::Index v = 0; v < mesh->vertices.cols(); ++v)
        mesh->intensity[v] = static_cast<float>(height(mesh->vertices(0, v)));
    ContactTracker tracker;
    const std::vector<HapticObject> objects = {test::object(mesh, 1)};
    double largest = 0.0, smallest = 1.0, worst = 0.0, step = 0.0, before = -1.0;
    for (int i = 0; i < 600; ++i)
    {
        const double time = i * kField_s, x = 0.05 * time - 0.015;
        if (i % 11 == 0) tracker.update(objects, test::ball({x, 0.0, kR - 1e-3}), time);
        tracker.advance(kField_s);
        if (i < 50) continue;
        ASSERT_EQ(tracker.contacts().size(), 1u);
        const double felt = tracker.contacts()[0].paint.intensity();
        largest = std::max(largest, felt);
        smallest = std::min(smallest, felt);
        if (before >= 0.0) step = std::max(step, std::abs(felt - before));
        before = felt;
        worst = std::max(worst, std::abs(felt - height(x - 0.05 * 0.011))); // a frame late
    }
    EXPECT_GT(largest, 0.9); // corners are 2 mm apart
    EXPECT_LT(smallest, 0.1);
    EXPECT_LT(worst, 0.15);
    EXPECT_LT(step, 0.03); // a millisecond is 0.05 mm: pi/10 mm of the slope 100 a metre
}

} // namespace

} // namespace midair::bridge
