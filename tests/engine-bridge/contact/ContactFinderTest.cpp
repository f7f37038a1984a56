#include "engine-bridge/contact/ContactFinder.h"

#include "engine-bridge/contact/ContactForce.h"
#include "engine-bridge/hands/MeshDistance.h"
#include "engine-bridge/hands/PressedSkin.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kDepth = 1e-3;
const double kA = std::sqrt(2.0 * kR * kDepth - kDepth * kDepth); // 3.87 mm

/// A pose that shares nothing with the mesh's grid.
Eigen::Isometry3d oblique()
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 0.3).normalized()).toRotationMatrix();
    pose.translation() = Vector3d(0.013, -0.021, 0.037);
    return pose;
}

double degreesBetween(const Vector3d& a, const Vector3d& b)
{
    return base::toDegrees(std::atan2(a.cross(b).norm(), a.dot(b)));
}

bool isNoted(const ContactFinder& finder, ContactReason reason)
{
    for (const ContactNote& note : finder.notes())
        if (note.reason == reason) return true;
    return false;
}

// Closed forms of a ball in a plane, on triangles of 2 mm: to 2 % and one degree.
TEST(ContactFinder, ABallInAPlaneHasTheClosedFormsPatch)
{
    ContactFinder finder;
    const Eigen::Isometry3d pose = oblique();
    for (int i = 0; i < 25; ++i) // places between the vertices
    {
        const Vector3d foot(0.37e-3 * i, -0.23e-3 * i, 0.0);
        finder.update({test::object(test::sheet(), 1, pose)},
                      test::ball(pose * (foot + Vector3d(0, 0, kR - kDepth))));
        ASSERT_EQ(finder.patches().size(), 1u);
        const ContactPatch& patch = finder.patches()[0];
        EXPECT_NEAR(patch.area_m2, base::kPi * kA * kA, 0.02 * base::kPi * kA * kA);
        EXPECT_NEAR(patch.area_m2, 47.1e-6, 0.02 * 47.1e-6);
        EXPECT_LT((patch.centre - pose * foot).norm(), 0.05e-3);
        EXPECT_LT(degreesBetween(patch.normal, pose.linear() * Vector3d::UnitZ()), 1.0);
        EXPECT_NEAR(patch.semiMajor_m, kA, 0.01 * kA); // whose square is the covariance: 2 %
        EXPECT_NEAR(patch.semiMinor_m, kA, 0.01 * kA);
        EXPECT_NEAR(patch.covariance.trace(), 0.5 * kA * kA, 0.02 * 0.5 * kA * kA);
        EXPECT_NEAR(patch.depth_m, kDepth, 0.02 * kDepth);
        EXPECT_FALSE(patch.isExit);
        EXPECT_TRUE(finder.notes().empty());
    }
}

// 10 mN presses it 1 mm in (ContactForceOptions), wherever a physics engine keeps the plane.
TEST(ContactFinder, ABallThatPushesThePlaneHasThePatchOfItsForce)
{
    for (const double gap : {0.5e-3, 0.0, -0.4e-3})
    {
        ContactFinder finder;
        HandFrame frame = test::ball(Vector3d(0.4e-3, 0.3e-3, kR + gap));
        finder.update({test::object(test::sheet())}, frame);
        EXPECT_EQ(finder.patches().size(), gap < 0.0 ? 1u : 0u);
        const int bone = handCapsules(frame)[0].bone;
        frame.presses = {{frame.hands[0].id, bone, Vector3d(0.4e-3, 0.3e-3, 0.2e-3), 0.01}};
        finder.update({test::object(test::sheet())}, frame);
        ASSERT_EQ(finder.patches().size(), 1u) << gap;
        EXPECT_TRUE(finder.nearby().empty());
        EXPECT_NEAR(finder.patches()[0].depth_m, kDepth, 0.02 * kDepth) << gap;
        EXPECT_NEAR(finder.patches()[0].semiMajor_m, kA, 0.1 * kA) << gap; // of a larger ball
        frame.presses[0].place.z() = 5e-3;
        finder.update({test::object(test::sheet())}, frame);
        EXPECT_EQ(finder.patches().size(), gap < 0.0 ? 1u : 0u) << "it pushes something else";
    }
}

TEST(ContactFinder, APushIsAsDeepAsAContactOfItsForce)
{
    const ContactForceOptions pad;
    const MeshDistance plane(test::sheet());
    const auto force_N = [&](double pushed_N)
    {
        const std::vector<HandPress> presses = {{1, 8, Vector3d::Zero(), pushed_N}};
        return pad.stiffness_N_m *
               pressedDepth_m(presses, 1, 8, plane, Eigen::Isometry3d::Identity()).value();
    };
    EXPECT_NEAR(force_N(0.005), 0.005, 1e-12);
    EXPECT_NEAR(force_N(1.0), pad.mostForce_N, 1e-12);
}

TEST(ContactFinder, ACapsuleThatLiesInAPlaneHasTheClosedFormsPatch)
{
    constexpr double kLength = 0.02;
    ContactFinder finder;
    HandFrame frame;
    frame.hands.resize(1);
    const Vector3d way = Vector3d(std::cos(0.4), std::sin(0.4), 0.0);
    const Vector3d middle(0.5e-3, 0.3e-3, kR - kDepth);
    test::addBone(
        frame.hands[0], INDEX_TIP, middle - 0.5 * kLength * way, middle + 0.5 * kLength * way);
    finder.update({test::object(test::sheet())}, frame);
    ASSERT_EQ(finder.patches().size(), 1u);
    const ContactPatch& patch = finder.patches()[0];
    const double disc = base::kPi * kA * kA, strip = 2.0 * kA * kLength;
    EXPECT_NEAR(patch.area_m2, disc + strip, 0.02 * (disc + strip));
    EXPECT_LT(std::min(degreesBetween(patch.major, way), degreesBetween(patch.major, -way)), 1.0);
    // Along: the strip l^2/12, the half discs at l/2 + 4 a/(3 pi); across: a^2/3 and a^2/4.
    const double half = 0.5 * kLength;
    const double along =
        (strip * kLength * kLength / 12.0 +
         disc * (half * half + 8.0 * half * kA / (3.0 * base::kPi) + kA * kA / 4)) /
        (disc + strip);
    const double across = (strip * kA * kA / 3.0 + disc * kA * kA / 4.0) / (disc + strip);
    EXPECT_NEAR(patch.semiMajor_m, 2.0 * std::sqrt(along), 0.01 * 2.0 * std::sqrt(along));
    EXPECT_NEAR(patch.semiMinor_m, 2.0 * std::sqrt(across), 0.01 * 2.0 * std::sqrt(across));
    EXPECT_NEAR(patch.depth_m, kDepth, 0.02 * kDepth);
}

TEST(ContactFinder, TwoBallsNearEachOtherAreOnePatchAndFarApartTwo)
{
    ContactFinder finder;
    for (const double apart : {0.010, 0.040})
    {
        HandFrame frame;
        frame.hands.resize(1);
        const Vector3d a(0.5 * apart, 0, kR - kDepth), b(-0.5 * apart, 0, kR - kDepth);
        test::addBone(frame.hands[0], INDEX_TIP, a, a);
        test::addBone(frame.hands[0], MIDDLE_TIP, b, b);
        finder.update({test::object(test::sheet())}, frame);
        ASSERT_EQ(finder.patches().size(), apart < 0.015 ? 1u : 2u);
        if (apart > 0.015) continue;
        const ContactPatch& patch = finder.patches()[0];
        EXPECT_EQ(patch.bones.size(), 2u);
        EXPECT_LT(patch.centre.norm(), 0.1e-3);
        EXPECT_NEAR(patch.area_m2, 2.0 * base::kPi * kA * kA, 0.04 * base::kPi * kA * kA);
        EXPECT_NEAR(patch.semiMajor_m, 2.0 * std::hypot(0.5 * kA, 5e-3), 0.1e-3);
    }
    // Two hands' fingers are two, however near.
    HandFrame frame = test::ball({5e-3, 0, kR - kDepth});
    frame.hands.push_back(test::ball({-5e-3, 0, kR - kDepth}).hands[0]);
    frame.hands[1].id = 1;
    finder.update({test::object(test::sheet())}, frame);
    EXPECT_EQ(finder.patches().size(), 2u);
}

TEST(ContactFinder, WhatWasJoinedStaysSoInTremor)
{
    ContactFinder finder;
    int switches = 0;
    std::size_t before = 0;
    for (int i = 0; i < 200; ++i)
    {
        const double apart = 0.015 + 1e-3 * std::sin(0.9 * i);
        HandFrame frame;
        frame.hands.resize(1);
        const Vector3d a(0.5 * apart, 0, kR - kDepth), b(-0.5 * apart, 0, kR - kDepth);
        test::addBone(frame.hands[0], INDEX_TIP, a, a);
        test::addBone(frame.hands[0], MIDDLE_TIP, b, b);
        finder.update({test::object(test::sheet())}, frame);
        switches += before != 0 && before != finder.patches().size();
        before = finder.patches().size();
    }
    EXPECT_LE(switches, 1);
}

// Bones that overlap share a part of the surface, which counts once: as where places of a fine grid
// lie in any of them.
TEST(ContactFinder, TheUnionOfBonesIsCountedOnce)
{
    ContactFinderOptions options;
    options.join_m = options.part_m = 0.05;
    ContactFinder finder(options);
    HandFrame frame;
    frame.hands.push_back(openHand(1, Eigen::Isometry3d::Identity()));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(base::kPi / 2, Vector3d::UnitX()).toRotationMatrix();
    pose.translation() = Vector3d(-0.03, 6e-3, -0.09); // along the index finger, parallel to it
    const auto mesh = test::sheet(30);
    finder.update({test::object(mesh, 1, pose)}, frame);
    ASSERT_EQ(finder.patches().size(), 1u);
    EXPECT_GE(finder.patches()[0].bones.size(), 2u);
    std::vector<Capsule> capsules;
    for (const Capsule& own : finder.patches()[0].own)
        capsules.push_back({pose.inverse() * own.a, pose.inverse() * own.b, own.radius_m});
    constexpr double kStep_m = 0.1e-3;
    double area = 0.0;
    for (double x = -0.03 + kStep_m / 2; x < 0.03; x += kStep_m)
        for (double y = -0.03 + kStep_m / 2; y < 0.03; y += kStep_m)
            if (std::any_of(capsules.begin(),
                            capsules.end(),
                            [&](const Capsule& one) {
                                return contains(one, {x, y, 0.0});
                            }))
                area += kStep_m * kStep_m;
    EXPECT_NEAR(finder.patches()[0].area_m2, area, 0.01 * area);
    // What a touch takes is the same.
    EXPECT_NEAR(MeshDistance(mesh).overlapArea(capsules, 0.5e-3), area, 0.01 * area);
}

TEST(ContactFinder, AThinPlateIsSplitByItsNormalsAndItsFarSideIsAnExit)
{
    ContactFinder finder;
    const auto mesh = test::plate(1.5e-3);
    ASSERT_EQ(windingOf(*mesh), 1);
    finder.update({test::object(mesh)}, test::ball({0, 0, kR - 4e-3}));
    ASSERT_EQ(finder.patches().size(), 2u);
    const ContactPatch& a = finder.patches()[0];
    const ContactPatch& b = finder.patches()[1];
    const ContactPatch& top = a.normal.z() > 0.0 ? a : b;
    const ContactPatch& bottom = a.normal.z() > 0.0 ? b : a;
    EXPECT_LT(degreesBetween(top.normal, Vector3d::UnitZ()), 1.0);
    EXPECT_LT(degreesBetween(bottom.normal, -Vector3d::UnitZ()), 1.0);
    EXPECT_FALSE(top.isExit);
    EXPECT_TRUE(bottom.isExit);
    EXPECT_NEAR(top.depth_m, 4e-3, 0.02 * 4e-3);
    EXPECT_NEAR(top.area_m2, base::kPi * (2 * kR * 4e-3 - 16e-6), 0.02 * top.area_m2);
}

TEST(ContactFinder, TheOutsideIsWhereTheFingerCameFromWhateverTheWinding)
{
    for (const bool isTurned : {false, true})
    {
        const auto mesh = test::sheet(30, 2e-3, isTurned);
        EXPECT_EQ(windingOf(*mesh), 0);
        ContactFinder finder;
        for (const double depth : {1e-3, 4e-3, 7e-3, 10e-3, 12e-3}) // past the finger's middle
        {
            finder.update({test::object(mesh)}, test::ball({0, 0, kR - depth}));
            ASSERT_EQ(finder.patches().size(), 1u);
            EXPECT_GT(finder.patches()[0].normal.z(), 0.999);
            EXPECT_NEAR(finder.patches()[0].depth_m, depth, 0.02 * depth);
        }
    }
    // A closed mesh says itself where its outside is, also to a finger that appears deep in it.
    auto turned = std::make_shared<haptics::TriangleMesh>(*sphere(0.03, 20));
    EXPECT_EQ(windingOf(*turned), 1);
    turned->triangles.row(1).swap(turned->triangles.row(2));
    EXPECT_EQ(windingOf(*turned), -1);
    ContactFinder finder;
    finder.update({test::object(turned)}, test::ball({0.026, 0, 0}));
    ASSERT_EQ(finder.patches().size(), 1u);
    EXPECT_GT(finder.patches()[0].normal.x(), 0.99);
}

TEST(ContactFinder, WhatIsClippedIsNotTouched)
{
    ContactFinder finder;
    HapticObject half = test::object(test::sheet());
    half.clips = {Eigen::Vector4d(1, 0, 0, 0)}; // x < 0 is cut off
    finder.update({half}, test::ball({0, 0, kR - kDepth}));
    ASSERT_EQ(finder.patches().size(), 1u);
    EXPECT_NEAR(finder.patches()[0].area_m2, 0.5 * base::kPi * kA * kA, 0.05 * 47.1e-6);
    EXPECT_NEAR(finder.patches()[0].centre.x(), 4.0 * kA / (3.0 * base::kPi), 0.1e-3);
}

TEST(ContactFinder, BadInputIsNoContactAndHasAReason)
{
    ContactFinder finder;
    const HapticObject good = test::object(test::sheet());
    finder.update({good}, test::ball({0, 0, kNan}));
    EXPECT_TRUE(finder.patches().empty());
    EXPECT_TRUE(isNoted(finder, ContactReason::JOINT_NOT_FINITE));
    for (const double radius : {kNan, -1.0, 0.5, double(INFINITY)})
    {
        finder.update({good}, test::ball({0, 0, 0}, radius));
        EXPECT_TRUE(finder.patches().empty()) << radius;
        EXPECT_TRUE(isNoted(finder, ContactReason::RADIUS_OUT_OF_RANGE)) << radius;
    }
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = kNan;
    finder.update({test::object(test::sheet(), 1, pose)}, test::ball({0, 0, kR - kDepth}));
    EXPECT_TRUE(finder.patches().empty());
    EXPECT_TRUE(isNoted(finder, ContactReason::POSE_NOT_FINITE));

    // Lines and triangles without area are touched, but have no patch.
    auto line = std::make_shared<haptics::TriangleMesh>();
    line->vertices.resize(3, 3);
    line->vertices << -0.01, 0, 0.01, 0, 0, 0, 0, 0, 0;
    line->triangles.resize(3, 2);
    line->triangles << 0, 0, 1, 1, 1, 2;
    finder.update({test::object(line, 9)}, test::ball({0, 0, kR - kDepth}));
    EXPECT_TRUE(finder.patches().empty());
    EXPECT_TRUE(isNoted(finder, ContactReason::NO_AREA));

    // A triangle with a vertex that isn't a number is left out; the rest is felt.
    auto holed = std::make_shared<haptics::TriangleMesh>(*test::sheet());
    holed->vertices(0, 0) = kNan;
    finder.update({test::object(holed, 11)}, test::ball({0, 0, kR - kDepth}));
    ASSERT_EQ(finder.patches().size(), 1u);
    EXPECT_TRUE(finder.patches()[0].covariance.allFinite());

    ContactFinderOptions options;
    options.resolution_m = kNan;
    EXPECT_THROW(ContactFinder{options}, base::InputError);
}

TEST(ContactFinder, EachReasonHasAText)
{
    for (int i = 1; i <= static_cast<int>(ContactReason::HAND_JUMPED); ++i)
        EXPECT_GT(std::string(contactReasonText(static_cast<ContactReason>(i))).size(), 10u);
    EXPECT_STREQ(contactReasonText(ContactReason::NONE), "");
}

} // namespace

} // namespace midair::bridge
