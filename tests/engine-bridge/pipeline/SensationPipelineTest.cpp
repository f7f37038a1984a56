// How soon a sensation follows what a program and a hand do, through the whole pipeline.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <algorithm>
#include <complex>
#include <memory>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Eigen::Vector3d;
using Trigger = SensationProperties::Trigger;

namespace
{

constexpr double kFrame_s = 1.0 / 60.0;
constexpr double kField_s = 1e-3;

/// A scene of one sensation on a sheet, played at 1,000 fields and 60 frames a second.
struct SensationPipeline : ::testing::Test
{
    SensationPipeline()
    {
        HologramOptions options;
        options.clock = &clock;
        options.array = haptics::TransducerArray::octagonalPrism();
        options.fieldRate = 1.0 / kField_s;
        pipeline = std::make_unique<HologramPipeline>(options);
        scene.objects.push_back(bridge::test::object(bridge::test::sheet()));
        HapticProperties& properties = scene.objects[0].properties;
        properties.pressure = 1000.0;
        properties.pressureInPa = true;
        properties.sensation.isMeant = true;
        properties.sensation.pattern = std::make_shared<const haptics::Sensation>(
            haptics::loadSensation("circle?radius=20mm"));
    }

    SensationProperties& sensation() { return scene.objects[0].properties.sensation; }

    double now_s() const { return clock.now_s(); }

    std::shared_ptr<const HologramResult> frame()
    {
        frame_s = scene.time_s = now_s();
        return pipeline->process(scene);
    }

    /// Lets the time of a field pass, and plays what is due.
    void field()
    {
        clock.jump(std::clamp(pipeline->rest_s(), 1e-4, kField_s));
        pipeline->attend();
        if (now_s() - frame_s >= kFrame_s) frame();
    }
    void run(double duration_s)
    {
        for (const double until_s = now_s() + duration_s; now_s() < until_s;)
            field();
    }

    /// The loudest drive of what the device plays.
    double loudest() const
    {
        double most = 0.0;
        for (const Eigen::VectorXcf& q : pipeline->device().planned())
            most = std::max(most, static_cast<double>(q.cwiseAbs().maxCoeff()));
        return most;
    }

    midair::test::SetClock clock;
    SceneSnapshot scene;
    std::unique_ptr<HologramPipeline> pipeline;
    double frame_s = 0.0; ///< time of the last frame
};

} // namespace

TEST_F(SensationPipeline, HasAParameterInTheFieldOfItsFrame)
{
    frame();
    run(0.1);
    sensation().parameters = {{"radius", 5.0}};
    const auto result = frame();
    ASSERT_EQ(result->foci, 1);
    EXPECT_EQ(result->handedOver_s, now_s());
    EXPECT_NEAR(result->points.positions.col(0).norm(), 5e-3, 1e-5);
}

TEST_F(SensationPipeline, FollowsATouchWithItsFrameAndIsWholeAfterItsFade)
{
    sensation().trigger = Trigger::TOUCH_BEGIN;
    frame();
    run(0.1);
    EXPECT_EQ(loudest(), 0.0);
    scene.hands = bridge::test::ball(Vector3d(0.0, 0.0, 6.5e-3));
    const double touched_s = now_s();
    frame();
    while (loudest() == 0.0 && now_s() < touched_s + 1.0)
        field();
    EXPECT_LE(now_s() - touched_s, kFrame_s + 5e-3);
    double intensity = 0.0;
    while (intensity < 1.0 && now_s() < touched_s + 1.0)
    {
        field();
        intensity = frame()->touched->sensations.at(0).intensity;
    }
    EXPECT_LE(now_s() - touched_s, kFrame_s + 5e-3 + 2 * kField_s);
}

// Finding it at every published field would take much of the processor time of sensations.
TEST_F(SensationPipeline, ItsForceOnAFingertipIsKnownToATenthOfASecond)
{
    frame();
    run(0.3);
    const double quiet_N = frame()->fingertip.force_N;
    EXPECT_GT(quiet_N, 0.0);
    scene.objects[0].properties.pressure *= 2.0;
    const double louder_s = now_s();
    double force_N = quiet_N;
    int frames = 0;
    for (; force_N < 2.0 * quiet_N && now_s() < louder_s + 1.0; ++frames)
    {
        run(kFrame_s);
        force_N = frame()->fingertip.force_N;
    }
    EXPECT_LE(now_s() - louder_s, 0.1 + 2 * kFrame_s);
    EXPECT_GT(frames, 1) << "found anew for every field";
    EXPECT_NEAR(force_N, 4.0 * quiet_N, 0.4 * quiet_N) << "as the square of the pressure";
    scene.objects.clear();
    EXPECT_EQ(frame()->fingertip.force_N, 0.0);
}

TEST_F(SensationPipeline, EndsWithTheFieldInWhichItsPatternStops)
{
    sensation().pattern =
        std::make_shared<const haptics::Sensation>(haptics::loadSensation("click"));
    sensation().trigger = Trigger::PROGRAM;
    sensation().plays = 1;
    frame();
    const double begun_s = now_s();
    run(0.03);
    EXPECT_GT(loudest(), 0.0);
    while (loudest() > 0.0 && now_s() < begun_s + 1.0)
        field();
    EXPECT_NEAR(now_s() - begun_s, 0.1, 2 * kField_s);
}

TEST_F(SensationPipeline, IsMutedAtOnce)
{
    frame();
    run(0.1);
    EXPECT_EQ(pipeline->device().state(), ArrayState::PLAYING);
    pipeline->device().setMuted(true);
    const auto isZero = [&]
    {
        const PlayedDrives played = pipeline->device().playedOfLate(1e-3);
        if (played.fields.empty()) return false;
        const auto& q = played.fields.back().q;
        return std::all_of(q.begin(), q.end(), [](std::complex<float> a) { return a == 0.0f; });
    };
    EXPECT_TRUE(isZero());
    run(0.05);
    EXPECT_TRUE(isZero());
}
