#include "engine-bridge/pipeline/ObjectMotion.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Isometry3d;
using Eigen::Vector3d;

ObjectMotion::Corners boxOf(double half_m)
{
    ObjectMotion::Corners corners;
    for (int i = 0; i < 8; ++i)
        corners.col(i) = half_m * Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    return corners;
}

Isometry3d at(const Vector3d& place)
{
    return Isometry3d(Eigen::Translation3d(place));
}

Isometry3d onLine(double time_s, double speed)
{
    return at({speed * time_s, 0.0, 0.2});
}

/// Shows the motion \a poseAt at \a rate_Hz until \a end_s, that included.
template<class PoseAt>
ObjectMotion shown(const PoseAt& poseAt, double end_s, double rate_Hz = 60.0, int frames = 12)
{
    ObjectMotion motion;
    for (int i = frames; i >= 0; --i)
        motion.see(end_s - i / rate_Hz, poseAt(end_s - i / rate_Hz));
    return motion;
}

} // namespace

TEST(ObjectMotion, GoesOnAlongALine)
{
    const auto line = [](double t) { return onLine(t, 0.3); };
    const ObjectMotion motion = shown(line, 5.0);
    for (const double ahead_s : {0.038, -0.02, 0.1})
        EXPECT_NEAR(
            (motion.at(ahead_s, boxOf(0.02)).translation() - line(5.0 + ahead_s).translation())
                .norm(),
            0.0,
            1e-9);
    // The farthest that is asked for.
    EXPECT_NEAR(motion.at(5.0, boxOf(0.02)).translation().x(), 1.53, 1e-9);
}

// 0.3 m/s on a circle of 50 mm.
TEST(ObjectMotion, GoesOnAlongACurve)
{
    const auto circle = [](double t)
    { return at(0.05 * Vector3d(std::cos(6.0 * t), std::sin(6.0 * t), 0.0)); };
    for (double end_s = 1.0; end_s < 2.0; end_s += 0.1)
    {
        const ObjectMotion motion = shown(circle, end_s);
        const Vector3d truth = circle(end_s + 0.038).translation();
        EXPECT_LT((motion.at(0.038, boxOf(0.02)).translation() - truth).norm(), 1e-3);
        EXPECT_GT((circle(end_s).translation() - truth).norm(), 0.011);
    }
}

TEST(ObjectMotion, TurnsOn)
{
    const auto turned = [](double t)
    { return Isometry3d(Eigen::AngleAxisd(3.0 * t, Vector3d(1.0, 2.0, 2.0) / 3.0)); };
    const ObjectMotion motion = shown(turned, 1.0);
    EXPECT_LT((motion.at(0.04, boxOf(0.05)).matrix() - turned(1.04).matrix()).norm(), 1e-9);
}

// To the last bit, or it would be solved for again.
TEST(ObjectMotion, WhatRestsStaysExactlyWhereItIs)
{
    const Isometry3d place = at({0.1 / 3.0, 0.7, 1e-7});
    ObjectMotion motion = shown([&](double) { return place; }, 3.0);
    EXPECT_FALSE(motion.isMoving());
    EXPECT_EQ(motion.at(0.04, boxOf(0.05)).matrix(), place.matrix());
    // What comes to rest does so after one and a half frames.
    motion = shown([](double t) { return onLine(t, 0.3); }, 3.0);
    const Isometry3d last = onLine(3.0, 0.3);
    motion.see(3.0 + 1.0 / 60.0, last);
    motion.see(3.0 + 2.0 / 60.0, last);
    EXPECT_EQ(motion.at(0.04, boxOf(0.05)).matrix(), last.matrix());
}

// A tracker's noise of 0.1 mm.
TEST(ObjectMotion, NoiseIsNotCarriedOn)
{
    ObjectMotion motion;
    int worst = 0;
    for (int i = 0; i < 200; ++i)
    {
        const Isometry3d pose = at(1e-4 * Vector3d(std::sin(3.7 * i), std::sin(5.1 * i), 0.0));
        motion.see(i / 60.0, pose);
        if (motion.at(0.02, boxOf(0.02)).matrix() != pose.matrix()) ++worst;
    }
    EXPECT_LT(worst, 10);
}

TEST(ObjectMotion, JumpsEndIt)
{
    const auto line = [](double t) { return onLine(t, 0.3); };
    for (const Vector3d& jump : {Vector3d(0.02, 0.0, 0.0), Vector3d(0.0, -0.5, 0.0)})
    {
        ObjectMotion motion = shown(line, 1.0);
        const Isometry3d there = at(line(1.0).translation() + jump);
        motion.see(1.0 + 1.0 / 60.0, there);
        EXPECT_FALSE(motion.isMoving());
        EXPECT_EQ(motion.at(0.04, boxOf(0.02)).matrix(), there.matrix());
    }
    // A wall that it comes back from.
    ObjectMotion motion = shown(line, 1.0);
    motion.see(1.0 + 1.0 / 60.0, line(1.0 - 1.0 / 60.0));
    EXPECT_FALSE(motion.isMoving());
    // A pause, and a clock that runs back.
    motion = shown(line, 1.0);
    motion.see(1.2, line(1.2));
    EXPECT_FALSE(motion.isMoving());
    motion = shown(line, 1.0);
    motion.see(0.9, line(1.1));
    EXPECT_FALSE(motion.isMoving());
}

TEST(ObjectMotion, WhatIsTooFastIsCarriedOnAtTheLargestSpeed)
{
    ObjectMotion motion;
    for (int i = 0; i < 40; ++i) // it begins slowly
        motion.see(i / 60.0, at({0.5 * i * i / 60.0 / 10.0, 0.0, 0.0}));
    const double before_m = 0.5 * 39.0 * 39.0 / 600.0;
    EXPECT_NEAR(motion.at(0.05, boxOf(0.01)).translation().x() - before_m,
                ObjectMotion::kFastest * 0.05,
                1e-9);
}

TEST(ObjectMotion, WhatIsNoNumberStaysAsItIs)
{
    ObjectMotion motion = shown([](double t) { return onLine(t, 0.3); }, 1.0);
    Isometry3d wrong = onLine(1.02, 0.3);
    wrong.translation().x() = std::nan("");
    motion.see(1.02, wrong);
    EXPECT_FALSE(motion.isMoving());
    motion.see(1.04, onLine(1.04, 0.3));
    EXPECT_TRUE(motion.at(0.04, boxOf(0.01)).matrix().allFinite());
}

// A simulation of 30 Hz in frames of 60 Hz.
TEST(ObjectMotion, StepsThatLastTwoFramesAreOneMotion)
{
    ObjectMotion motion;
    for (int i = 0; i <= 24; ++i)
    {
        const int step = i / 2;
        motion.see(i / 60.0, onLine(step / 30.0, 0.3));
    }
    EXPECT_TRUE(motion.isMoving());
    EXPECT_NEAR(motion.at(0.04, boxOf(0.01)).translation().x(), 0.3 * (0.4 + 0.04), 1e-9);
    motion.see(25 / 60.0, onLine(0.4, 0.3));
    EXPECT_NEAR(motion.at(0.04, boxOf(0.01)).translation().x(), 0.3 * (0.4 + 0.04), 1e-9);
}

} // namespace midair::bridge
