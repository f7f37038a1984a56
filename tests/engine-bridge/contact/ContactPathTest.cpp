#include "engine-bridge/contact/ContactPath.h"

#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"
#include "tests/engine-bridge/contact/ContactScenes.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

ContactPatch patchOf(const HandFrame& hands, const std::vector<HapticObject>& objects)
{
    ContactFinder finder;
    finder.update(objects, hands);
    return finder.patches().at(0);
}

ContactPatch ballInSheet(double depth_m)
{
    return patchOf(test::ball({0, 0, kR - depth_m}), {test::object(test::sheet())});
}

/// Distance of \a place from the skin of the union; under 0: in the flesh. \a facing: how far the
/// skin there looks along \a way.
double fromSkin(const std::vector<Capsule>& skin,
                const Vector3d& place,
                const Vector3d& way,
                double& facing)
{
    double least = INFINITY;
    for (const Capsule& capsule : skin)
    {
        const AxisDistance axis(capsule.a, capsule.b, place);
        if (axis.distance - capsule.radius_m >= least) continue;
        least = axis.distance - capsule.radius_m;
        facing = axis.slope.dot(way);
    }
    return least;
}

TEST(ContactPath, TurnsAtItsRateOnTheShrunkCircleOnTheSkin)
{
    // a^2 = 2 R d - d^2 = 36 mm^2 at d = 2.708 mm: path radius 3.5 mm.
    const double depth = kR - std::sqrt(kR * kR - 36e-6);
    ContactPath path({}, ballInSheet(depth));
    double turned = 0.0;
    Vector3d before = path.foci()[0].position;
    for (int i = 0; i < 1000; ++i)
    {
        ASSERT_TRUE(path.advance(kField_s));
        const Vector3d now = path.foci()[0].position;
        const double radius = std::hypot(now.x(), now.y());
        EXPECT_NEAR(radius, 3.5e-3, 0.05e-3);
        // By sqrt(R^2 - r^2) - (R - d) into the object, d in the middle.
        EXPECT_NEAR(-now.z(), std::sqrt(kR * kR - radius * radius) - (kR - depth), 0.02e-3);
        EXPECT_LE((now - before).norm(), 0.5e-3);
        turned += std::atan2(before.x() * now.y() - before.y() * now.x(),
                             before.x() * now.x() + before.y() * now.y());
        before = now;
    }
    EXPECT_NEAR(std::abs(turned) / base::kTwoPi, 5.0, 0.05);
    EXPECT_NEAR(path.turningRate_Hz(), 5.0, 1e-9);
}

TEST(ContactPath, SharesFociOutByCircumference)
{
    EXPECT_EQ(ContactPath({}, ballInSheet(1e-3)).foci().size(), 1u); // 3.9 mm
    const double depth = kR - std::sqrt(kR * kR - 49e-6);            // 7 mm; path 28 mm long
    EXPECT_EQ(ContactPath({}, ballInSheet(depth)).foci().size(), 3u);
    ContactPatch large = ballInSheet(1e-3);
    large.covariance *= 400.0;
    EXPECT_EQ(ContactPath({}, large).foci().size(), 10u);
    ContactPathOptions options;
    ContactPath tiny(options, ballInSheet(0.05e-3));
    EXPECT_NEAR(tiny.semiMajor_m(), options.leastRadius_m, 1e-9);
}

TEST(ContactPath, TurnsMoreSlowlyWhereTheStepWouldBeTooLong)
{
    ContactPathOptions options;
    options.rate_Hz = 50.0;
    ContactPath path(options, ballInSheet(3e-3));
    std::vector<PathFocus> before = path.foci();
    for (int i = 0; i < 200; ++i)
    {
        path.advance(2e-3);
        for (std::size_t j = 0; j < before.size(); ++j)
            EXPECT_LE((path.foci()[j].position - before[j].position).norm(), 0.5e-3 + 1e-9);
        before = path.foci();
    }
    EXPECT_LT(path.turningRate_Hz(), 50.0);
    EXPECT_LT(path.lag_m(), 1e-9);
}

// A patch whose long axis turns, swaps with the short one and flips: neither angle nor foci jump.
TEST(ContactPath, TheAngleGoesOnWhereThePatchIsFittedAnew)
{
    ContactPatch patch = ballInSheet(3e-3);
    ContactPath path({}, patch);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    std::vector<PathFocus> before = path.foci();
    double angle = path.angle_rad();
    for (int i = 0; i < 2000; ++i)
    {
        if (i % 11 == 0)
        {
            const double squeeze = 1.0 + 0.1 * normal(random);
            patch.covariance = Eigen::Vector3d(8.5e-6 * squeeze, 8.5e-6 / squeeze, 0).asDiagonal();
            patch.normal = Vector3d(0.02 * normal(random), 0.02 * normal(random), 1).normalized();
            // The axes of a nearly round patch are anywhere.
            const Vector3d u = patch.normal.unitOrthogonal();
            const double axis = normal(random);
            patch.major = std::cos(axis) * u + std::sin(axis) * patch.normal.cross(u);
            patch.minor = patch.normal.cross(patch.major);
            path.fit(patch);
        }
        path.advance(kField_s);
        EXPECT_LT(path.lag_m(), 1.5e-3); // nearly where its angle says, so no twist
        EXPECT_EQ(path.foci()[0].weight, 1.0);
        EXPECT_NEAR(std::remainder(path.angle_rad() - angle, base::kTwoPi),
                    base::kTwoPi * 5.0 * kField_s,
                    1e-9);
        angle = path.angle_rad();
        ASSERT_EQ(path.foci().size(), before.size());
        for (std::size_t j = 0; j < before.size(); ++j)
            EXPECT_LE((path.foci()[j].position - before[j].position).norm(), 0.5e-3 + 1e-9);
        before = path.foci();
    }
}

TEST(ContactPath, FociComeAndGoByFading)
{
    ContactPath path({}, ballInSheet(1e-3));
    ASSERT_EQ(path.foci().size(), 1u);
    path.fit(ballInSheet(6e-3)); // 7.7 mm: 3.9 foci
    std::size_t most = 1;
    double weight = 0.0;
    for (int i = 0; i < 1500; ++i)
    {
        path.advance(kField_s);
        if (path.foci().size() > most)
        {
            EXPECT_LT(path.foci().back().weight, 0.06);
        }
        most = std::max(most, path.foci().size());
        weight = path.foci().back().weight;
    }
    EXPECT_EQ(path.foci().size(), 4u);
    EXPECT_NEAR(weight, 1.0, 1e-9);
    // They share the circle evenly.
    const Vector3d sum = (path.foci()[0].position + path.foci()[1].position +
                          path.foci()[2].position + path.foci()[3].position) /
                         4.0;
    EXPECT_LT(std::hypot(sum.x(), sum.y()), 0.1e-3);
    path.fit(ballInSheet(1e-3));
    for (int i = 0; i < 1500; ++i)
        path.advance(kField_s);
    EXPECT_EQ(path.foci().size(), 1u);
}

TEST(ContactPath, RefusesNumbersThatAreNone)
{
    ContactPath path({}, ballInSheet(1e-3));
    const Vector3d before = path.foci()[0].position;
    for (const double dt : {kNan, double(INFINITY), -1e-3})
        EXPECT_FALSE(path.advance(dt));
    EXPECT_EQ(path.foci()[0].position, before);
    ContactPathOptions options;
    options.largestStep_m = kNan;
    EXPECT_THROW(ContactPath(options, ballInSheet(1e-3)), base::InputError);
}

// A sheet at each of the 26 joints, in 1000 poses of the hand: every focus is within 1 mm of the
// skin of the whole hand, where it looks into the object.
TEST(ContactPath, EveryFocusIsOnTheSkinOnTheContactsSide)
{
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const auto direction = [&]
    { return Vector3d(normal(random), normal(random), normal(random)).normalized(); };
    const auto mesh = test::sheet(6, 5e-3);
    ContactFinderOptions options;
    options.resolution_m = 2e-3; // outlines need not be exact here
    ContactFinder finder(options);
    int patches = 0, foci = 0, wrong = 0;
    for (int pose = 0; pose < 1000; ++pose)
    {
        Eigen::Isometry3d palm = Eigen::Isometry3d::Identity();
        palm.linear() = Eigen::AngleAxisd(3.0 * uniform(random), direction()).toRotationMatrix();
        palm.translation() = 0.1 * direction();
        HandFrame hands;
        hands.hands.push_back(openHand(pose % 2, palm));
        for (HandJoint& joint : hands.hands[0].joints) // bent a little
            joint.position += 3e-3 * direction();
        std::vector<HapticObject> objects;
        for (std::size_t j = 0; j < HAND_JOINTS; ++j)
        {
            const HandJoint& joint = hands.hands[0].joints[j];
            const Vector3d n = direction();
            Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
            place.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n).matrix();
            place.translation() = joint.position - (joint.radius_m - 4e-3 * uniform(random)) * n;
            objects.push_back(test::object(mesh, j + 1, place));
            objects.back().meshId = 1;
        }
        finder.update(objects, hands);
        patches += static_cast<int>(finder.patches().size());
        for (const ContactPatch& patch : finder.patches())
        {
            for (int quarter = 0; quarter < 4; ++quarter)
            {
                ContactPath path({}, patch, 0.5 * base::kPi * (quarter + uniform(random)));
                path.advance(kField_s);
                for (const PathFocus& focus : path.foci())
                {
                    double facing = 0.0;
                    const double away =
                        fromSkin(*patch.skin, focus.position, -patch.normal, facing);
                    ++foci;
                    wrong += !(std::abs(away) <= 1e-3) || !(facing > 0.0);
                }
            }
        }
    }
    EXPECT_GT(patches, 24000);
    EXPECT_GT(foci, 100000);
    EXPECT_EQ(wrong, 0);
}

} // namespace

} // namespace midair::bridge
