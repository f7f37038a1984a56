#include "engine-bridge/hands/HandProximity.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// A square of 200 mm in z = 0 of its own frame.
std::shared_ptr<const haptics::TriangleMesh> square()
{
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    mesh->vertices.resize(3, 4);
    mesh->vertices << -0.1, 0.1, 0.1, -0.1, -0.1, -0.1, 0.1, 0.1, 0, 0, 0, 0;
    mesh->triangles.resize(3, 2);
    mesh->triangles << 0, 0, 1, 2, 2, 3;
    return mesh;
}

HapticObject object(std::uint64_t id, const Eigen::Isometry3d& pose = Eigen::Isometry3d::Identity())
{
    HapticObject result;
    result.id = id;
    result.path = "scene/square" + std::to_string(id);
    result.meshId = 1;
    result.mesh = square();
    result.pose = pose;
    return result;
}

/// A hand of which only the index finger's last bone is tracked, pointing down, its skin \a gap
/// over (0, 0).
HandFrame finger(double gap, int id = 1)
{
    HandFrame frame;
    Hand hand;
    hand.id = id;
    const double radius = 0.008;
    hand.joints[INDEX_TIP] = {
        Vector3d(0, 0, gap + radius), Eigen::Quaterniond::Identity(), radius, true, true};
    hand.joints[INDEX_DISTAL] = {
        Vector3d(0, 0, gap + radius + 0.02), Eigen::Quaterniond::Identity(), radius, true, true};
    frame.hands.push_back(hand);
    return frame;
}

std::string history(HandProximity& proximity, const std::vector<double>& gaps)
{
    std::string result;
    double time = 0.0;
    for (const double gap : gaps)
    {
        proximity.update({object(7)}, finger(gap), time += 0.01);
        for (const TouchEvent& event : proximity.events())
            result += event.kind == TouchEvent::ENTER ? "E" : "L";
        result += ".";
    }
    return result;
}

TEST(HandProximity, DistanceIsInTheObjectsFrame)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()).toRotationMatrix(); // now in x = 0.03
    pose.translation() = Vector3d(0.03, 0.0, 0.01);
    HandProximity proximity;
    proximity.update({object(3, pose)}, finger(0.005), 0.0);
    ASSERT_EQ(proximity.contacts().size(), 1u);
    const HandContact& contact = proximity.contacts()[0];
    EXPECT_EQ(contact.object, 3u);
    EXPECT_EQ(contact.hand, 1);
    EXPECT_EQ(boneName(contact.bone), "index distal to index tip");
    EXPECT_NEAR(contact.distance_m, 0.022, 1e-14);
    EXPECT_NEAR(contact.position.x(), 0.03, 1e-14);
    EXPECT_FALSE(contact.touching);
}

TEST(HandProximity, TouchesHaveHysteresis)
{
    HandProximity proximity; // enters under 0, leaves over 4 mm
    EXPECT_EQ(
        history(proximity, {0.02, 0.001, -0.001, 0.002, -0.002, 0.0039, 0.0041, 0.002, -0.001}),
        "..E....L..E.");
}

TEST(HandProximity, TremorMakesNoEvents)
{
    HandProximity proximity;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> tremor(-0.0019, 0.0019);
    history(proximity, {-0.001});
    for (int i = 0; i < 200; ++i)
    {
        proximity.update({object(7)}, finger(0.002 + tremor(random)), 1.0 + 0.01 * i);
        EXPECT_TRUE(proximity.events().empty()) << i;
    }
}

TEST(HandProximity, EventsSayWhatWasTouched)
{
    HandProximity proximity;
    proximity.update({object(7)}, finger(-0.001), 0.5);
    ASSERT_EQ(proximity.events().size(), 1u);
    const TouchEvent event = proximity.events()[0];
    EXPECT_EQ(event.kind, TouchEvent::ENTER);
    EXPECT_EQ(event.object, 7u);
    EXPECT_EQ(event.path, "scene/square7");
    EXPECT_EQ(event.time_s, 0.5);
    EXPECT_NEAR(event.contact.distance_m, -0.001, 1e-14);
    EXPECT_TRUE(event.contact.touching);
    proximity.update({object(7)}, finger(0.1), 0.6);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].kind, TouchEvent::LEAVE);
    EXPECT_FALSE(proximity.events()[0].contact.touching);
    EXPECT_TRUE(proximity.contacts().empty());
}

TEST(HandProximity, ALostHandIsHeldForAMoment)
{
    HandProximity proximity; // holds for 0.1 s
    proximity.update({object(7)}, finger(-0.001), 0.0);
    HandFrame lost = finger(-0.001);
    lost.hands[0].joints[INDEX_TIP].positionValid = false;
    proximity.update({object(7)}, lost, 0.05);
    EXPECT_TRUE(proximity.events().empty());
    proximity.update({object(7)}, finger(-0.001), 0.08);
    EXPECT_TRUE(proximity.events().empty()); // found again before the hold ended: no second enter
    proximity.update({object(7)}, {}, 0.17);
    EXPECT_TRUE(proximity.events().empty());
    proximity.update({object(7)}, {}, 0.19);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].kind, TouchEvent::LEAVE);
}

TEST(HandProximity, ARemovedObjectIsLeftAtOnce)
{
    HandProximity proximity;
    proximity.update({object(7), object(8)}, finger(-0.001), 0.0);
    EXPECT_EQ(proximity.events().size(), 2u);
    proximity.update({object(8)}, finger(-0.001), 0.01);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].object, 7u);
    EXPECT_EQ(proximity.events()[0].path, "scene/square7");
}

TEST(HandProximity, TwoHandsTouchEachForItself)
{
    HandProximity proximity;
    HandFrame both = finger(-0.001, 0);
    both.hands.push_back(finger(0.01, 1).hands[0]);
    proximity.update({object(7)}, both, 0.0);
    EXPECT_EQ(proximity.contacts().size(), 2u);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].contact.hand, 0);
    both.hands.erase(both.hands.begin()); // the left hand is gone, the right one touches
    both.hands[0] = finger(-0.001, 1).hands[0];
    proximity.update({object(7)}, both, 0.2);
    ASSERT_EQ(proximity.events().size(), 2u);
    EXPECT_EQ(proximity.events()[0].kind, TouchEvent::ENTER);
    EXPECT_EQ(proximity.events()[0].contact.hand, 1);
    EXPECT_EQ(proximity.events()[1].kind, TouchEvent::LEAVE);
    EXPECT_EQ(proximity.events()[1].contact.hand, 0);
}

TEST(HandProximity, ForceIsRadiationPressureTimesOverlap)
{
    HapticObject pressed = object(7);
    pressed.properties.pressureInPa = true;
    pressed.properties.pressure = 5000.0;
    HandProximity proximity;
    proximity.update({pressed}, finger(-0.002), 0.0);
    ASSERT_EQ(proximity.contacts().size(), 1u);
    const HandContact& contact = proximity.contacts()[0];
    // The ball of 8 mm cut 6 mm from its centre: a disc of 28 mm^2, chords of two millimetres round
    // it.
    EXPECT_NEAR(contact.overlap_m2, M_PI * (64e-6 - 36e-6), 0.02 * M_PI * 28e-6);
    // 2 p^2 / (2 rho c^2) with rho = 1.204 kg/m^3 and c = 343.2 m/s at 20 degrees: 176 Pa, to their
    // digits.
    EXPECT_NEAR(contact.force_N,
                25e6 / (1.204 * 343.2 * 343.2) * contact.overlap_m2,
                2e-3 * contact.force_N);
    pressed.properties.pressureInPa = false;
    pressed.properties.pressure = 0.5;
    proximity.update({pressed}, finger(-0.002), 0.1);
    EXPECT_EQ(proximity.contacts()[0].force_N, 0.0); // what 1 stands for is not known
    pressed.properties.pressureInPa = true;
    proximity.update({pressed}, finger(0.001), 0.2);
    EXPECT_EQ(proximity.contacts()[0].force_N, 0.0);
}

TEST(HandProximity, TouchesGoOnInEachUpdateUntilTheyEnd)
{
    HandProximity proximity;
    std::string history;
    double time = 0.0;
    for (const double gap : {0.01, -0.001, -0.003, 0.002, 0.01})
    {
        proximity.update({object(7)}, finger(gap), time += 0.01);
        history += proximity.ongoing().empty() ? "." : "S";
        for (const TouchEvent& event : proximity.ongoing())
            EXPECT_NEAR(event.contact.distance_m, gap, 1e-14);
    }
    EXPECT_EQ(history, "..SS.");
    proximity.update({object(7)}, finger(-0.001), time += 0.01);
    proximity.update({object(7)}, {}, time + 0.01);
    EXPECT_TRUE(proximity.ongoing().empty()) << "nothing is measured of a lost hand";
    EXPECT_EQ(proximity.touches(), 1u);
}

TEST(HandProximity, EachFingerTouchesForItself)
{
    HandProximity proximity;
    HandFrame frame = finger(-0.001);
    Hand& hand = frame.hands[0];
    for (const int joint : {MIDDLE_TIP, MIDDLE_DISTAL})
    {
        hand.joints[joint] = hand.joints[joint - 5];
        hand.joints[joint].position.x() += 0.03;
    }
    proximity.update({object(7)}, frame, 0.0);
    ASSERT_EQ(proximity.events().size(), 2u);
    EXPECT_EQ(proximity.events()[0].contact.finger, INDEX);
    EXPECT_EQ(proximity.events()[1].contact.finger, MIDDLE);
    EXPECT_NEAR(proximity.events()[1].contact.position.x(), 0.03, 1e-14);
    for (const int joint : {INDEX_TIP, INDEX_DISTAL})
        hand.joints[joint].position.z() += 0.1;
    proximity.update({object(7)}, frame, 0.01);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].kind, TouchEvent::LEAVE);
    EXPECT_EQ(proximity.events()[0].contact.finger, INDEX);
    ASSERT_EQ(proximity.ongoing().size(), 1u);
    EXPECT_EQ(proximity.ongoing()[0].contact.finger, MIDDLE);
}

TEST(HandProximity, BonesBelongToFingersAndThePalm)
{
    const std::vector<int> wanted = {PALM_OF_HAND, THUMB, THUMB, THUMB};
    for (int bone = 0; bone < kHandBones; ++bone)
    {
        const int ofFinger = (bone - 4) % 5;
        const int finger = bone < 4        ? wanted[static_cast<std::size_t>(bone)]
                           : ofFinger <= 1 ? static_cast<int>(PALM_OF_HAND)
                                           : INDEX + (bone - 4) / 5;
        EXPECT_EQ(fingerOf(bone), finger) << boneName(bone);
    }
}

TEST(HandProximity, ForceFollowsWhatIsPlayed)
{
    HapticObject pressed = object(7);
    pressed.properties.pressureInPa = true;
    pressed.properties.pressure = 5000.0;
    HandProximity proximity;
    proximity.update({pressed}, finger(-0.002), 0.0);
    const double wanted_N = proximity.contacts()[0].force_N; // nothing is known: what is wanted
    const auto force_N = [&](const Vector3d& place, float pressure_Pa)
    {
        auto played = std::make_shared<PlayedPressure>();
        played->positions = place;
        played->pressure_Pa.setConstant(1, pressure_Pa);
        proximity.setPlayed(played);
        proximity.update({pressed}, finger(-0.002), 0.1);
        return proximity.contacts()[0].force_N;
    };
    EXPECT_NEAR(force_N({0.003, 0.0, 0.0}, 5000.0f), wanted_N, 1e-9 * wanted_N);
    EXPECT_NEAR(force_N({0.003, 0.0, 0.0}, 2500.0f), 0.25 * wanted_N, 1e-9 * wanted_N);
    EXPECT_EQ(force_N({0.05, 0.0, 0.0}, 5000.0f), 0.0) << "nothing is played where it touches";
    proximity.setPlayed(std::make_shared<PlayedPressure>());
    proximity.update({pressed}, finger(-0.002), 0.2);
    EXPECT_EQ(proximity.contacts()[0].force_N, 0.0) << "nothing is played";
}

/// The finger of finger(\a gap), which pushes with \a force_N at \a place.
HandFrame pushing(double gap, double force_N, const Vector3d& place = Vector3d::Zero())
{
    HandFrame frame = finger(gap);
    frame.presses = {{1, handCapsules(frame)[0].bone, place, force_N}};
    return frame;
}

// A ball of r = 8 mm + gap + d that is d deep in a plane cuts out a disc of pi (2 r d - d^2).
TEST(HandProximity, WhatAFingerPushesIsTouchedAndPresses)
{
    HandProximity proximity;
    auto played = std::make_shared<PlayedPressure>();
    played->positions = Vector3d(0.001, 0.0, 0.0);
    played->pressure_Pa.setConstant(1, 5000.0f);
    proximity.setPlayed(played);
    proximity.update({object(7)}, pushing(0.0005, 0.01), 0.0);
    ASSERT_EQ(proximity.events().size(), 1u);
    EXPECT_EQ(proximity.events()[0].kind, TouchEvent::ENTER);
    const HandContact contact = proximity.contacts()[0];
    EXPECT_NEAR(contact.distance_m, 0.0005, 1e-12) << "of the skin as it is tracked";
    EXPECT_NEAR(contact.overlap_m2, 18e-6 * M_PI, 0.02 * 18e-6 * M_PI);
    EXPECT_GT(contact.force_N, 0.0);
    // As deep as the force asks for, but for 2 mm at most; and not where the skin is far.
    proximity.update({object(7)}, pushing(0.0005, 1.0), 0.1);
    EXPECT_NEAR(proximity.contacts()[0].overlap_m2, 38e-6 * M_PI, 0.02 * 38e-6 * M_PI);
    proximity.update({object(7)}, pushing(0.006, 0.01), 0.2);
    EXPECT_EQ(proximity.contacts()[0].force_N, 0.0);
    EXPECT_TRUE(proximity.contacts()[0].touching);
}

TEST(HandProximity, APushOfAnotherFingerOrElsewhereIsNoTouch)
{
    HandFrame other = pushing(0.0005, 0.01);
    other.presses[0].hand = 0;
    HandFrame bone = pushing(0.0005, 0.01);
    bone.presses[0].bone = 0;
    for (const HandFrame& frame : {other, bone, pushing(0.0005, 0.01, Vector3d(0, 0, 0.005))})
    {
        HandProximity proximity;
        proximity.update({object(7)}, frame, 0.0);
        EXPECT_TRUE(proximity.events().empty());
    }
}

TEST(HandProximity, ABodyThatRunsAheadIsNotTouchedAnewEachTime)
{
    HandProximity proximity;
    std::string said;
    double time = 0.0;
    const auto update = [&](const HandFrame& frame, int times)
    {
        for (int i = 0; i < times; ++i)
        {
            proximity.update({object(7)}, frame, time += 0.024);
            for (const TouchEvent& event : proximity.events())
                said += event.kind == TouchEvent::ENTER ? "E" : "L";
            said += ".";
        }
    };
    for (int i = 0; i < 3; ++i)
    {
        update(pushing(0.0005, 0.01), 1);
        update(finger(0.02), 4); // 96 ms
    }
    EXPECT_EQ(said, "E...............");
    update(finger(0.02), 2); // 144 ms
    EXPECT_EQ(said, "E...............L..");
}

TEST(HandProximity, LinesAndPointsAreTouchedAndPress)
{
    HapticObject line = object(7);
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    mesh->vertices.resize(3, 2);
    mesh->vertices << -0.1, 0.1, 0.0, 0.0, 0.0, 0.0;
    mesh->triangles.resize(3, 1);
    mesh->triangles << 0, 1, 1;
    line.mesh = mesh;
    line.meshId = 2;
    HandProximity proximity;
    auto played = std::make_shared<PlayedPressure>();
    played->positions = Vector3d(0.001, 0.0, 0.0);
    played->pressure_Pa.setConstant(1, 5000.0f);
    proximity.setPlayed(played);
    proximity.update({line}, finger(-0.002), 0.0);
    ASSERT_EQ(proximity.events().size(), 1u);
    const HandContact& contact = proximity.contacts()[0];
    EXPECT_NEAR(contact.distance_m, -0.002, 1e-12);
    EXPECT_NEAR(contact.overlap_m2, 0.25 * std::pow(HandProximity::kFelt_m, 2), 1e-12);
    EXPECT_GT(contact.force_N, 0.0);
}

TEST(HandProximity, EmptyObjectsAndNoHandsAreFine)
{
    HandProximity proximity;
    HapticObject nothing = object(1);
    nothing.mesh = std::make_shared<haptics::TriangleMesh>();
    HapticObject null = object(2);
    null.mesh = nullptr;
    proximity.update({nothing, null}, finger(-0.001), 0.0);
    proximity.update({}, {}, 0.1);
    EXPECT_TRUE(proximity.contacts().empty());
    EXPECT_TRUE(proximity.events().empty());
}

TEST(WithinReach, IsTheDistanceFromTheSkin)
{
    const std::vector<HandCapsule> capsules = {
        {{Vector3d(0, 0, 0), Vector3d(0.1, 0, 0), 0.01}, 0, 0},
        {{Vector3d(0, 0.3, 0), Vector3d(0, 0.3, 0), 0.02}, 0, 1}};
    Eigen::Matrix3Xd points(3, 7);
    points << 0.05, 0.05, 0.119, 0.121, 0.0, 0.0, NAN, //
        0.0, 0.021, 0.0, 0.0, 0.3, 0.3, 0.0,           //
        0.0, 0.0, 0.0, 0.0, 0.029, 0.031, 0.0;
    const std::vector<bool> expected = {true, false, true, false, true, false, false};
    EXPECT_EQ(withinReach(points, capsules, 0.01), expected);
    EXPECT_EQ(withinReach(points, {}, 1.0), std::vector<bool>(7, false));
}

} // namespace

} // namespace midair::bridge
