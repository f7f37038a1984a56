#include "engine-bridge/pipeline/HologramPipeline.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using haptics::StopReason;

namespace
{

struct PipelineTest : testing::Test
{
    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    HologramPipeline pipeline{fakeOptions(log)};
    const double wavelength_m = haptics::Medium().wavelength(40e3);

    void expectRefused(const SceneSnapshot& snapshot, const std::string& message)
    {
        const auto result = pipeline.process(snapshot);
        EXPECT_EQ(result->points.size(), 0);
        EXPECT_EQ(result->played().cwiseAbs().maxCoeff(), 0.0f) << "nothing wrong is played";
        ASSERT_EQ(result->messages.size(), 1u);
        EXPECT_EQ(result->messages[0], message);
        EXPECT_EQ(pipeline.process(snapshot)->messages.size(), 1u) << "said once";
    }
};

} // namespace

TEST_F(PipelineTest, PlaysWhatIsInTheSnapshot)
{
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_EQ(log->solves, 1);
    EXPECT_EQ(log->sends, 1);
    EXPECT_EQ(result->report().stop, StopReason::CONVERGED);
    EXPECT_TRUE(result->playing);
    // 40 mm at a spacing of 8.6 mm: 16 on the edges at least.
    EXPECT_GE(result->points.size(), 16);
    EXPECT_EQ(result->achieved_Pa.size(), result->points.size());
    EXPECT_EQ(result->played().size(), 3984);
    EXPECT_EQ(result->deviceStatus, "fake");
    EXPECT_EQ(result->messages.size(), 0u);
}

TEST_F(PipelineTest, AchievedIsTheFieldOfWhatTheDevicePlays)
{
    const auto result = pipeline.process(squareSnapshot());
    const auto& options = pipeline.options();
    const Eigen::VectorXcd p = haptics::referencePropagationMatrix(
                                   result->points.positions, options.array, options.medium) *
                               result->played().cast<std::complex<double>>();
    // The product computes in float: 3984 terms, relative to the largest pressure.
    EXPECT_LT((p.cwiseAbs() - result->achieved_Pa.cast<double>()).cwiseAbs().maxCoeff(),
              1e-4 * p.cwiseAbs().maxCoeff());
}

TEST_F(PipelineTest, PointsFollowThePose)
{
    const auto still = pipeline.process(squareSnapshot());
    SceneSnapshot turned = squareSnapshot(0.01);
    turned.objects[0].pose.linear() =
        Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const auto after = pipeline.process(turned);
    ASSERT_EQ(after->points.size(), still->points.size());
    EXPECT_TRUE(
        after->points.positions.isApprox(turned.objects[0].pose * still->points.positions, 1e-12));
    EXPECT_TRUE(after->points.normals.isApprox(
        turned.objects[0].pose.linear() * still->points.normals, 1e-12));
    EXPECT_EQ(pipeline.counters().meshesSampled, 1u) << "moved, not sampled again";
}

TEST_F(PipelineTest, WhatDoesNotMoveIsSolvedOnce)
{
    const auto first = pipeline.process(squareSnapshot());
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(pipeline.process(squareSnapshot()), first);
    EXPECT_EQ(log->solves, 1);
    EXPECT_EQ(pipeline.counters().skippedUnmoved, 5u);
    EXPECT_EQ(pipeline.counters().snapshots, 6u);
}

TEST_F(PipelineTest, TheToleranceIsTheLimitAlsoInSmallSteps)
{
    pipeline.process(squareSnapshot());
    pipeline.process(squareSnapshot(0.9e-5 * wavelength_m));
    EXPECT_EQ(log->solves, 1);
    pipeline.process(
        squareSnapshot(1.1e-5 * wavelength_m)); // since the last solve, not the last snapshot
    EXPECT_EQ(log->solves, 2);
}

// Below the solvers' own tolerance too, which would answer SKIPPED and leave the field as it was.
TEST(Pipeline, AFinerToleranceReachesTheSolver)
{
    for (const double tolerance : {0.001, 0.0})
    {
        HologramOptions options = fakeOptions(std::make_shared<FakeLog>());
        options.solverFactory = {};
        options.motionTolerance = tolerance;
        HologramPipeline pipeline(options);
        const double wavelength_m = options.medium.wavelength(options.array.frequency_Hz);
        pipeline.process(squareSnapshot());
        const auto moved = pipeline.process(squareSnapshot(0.005 * wavelength_m));
        EXPECT_NE(moved->report().stop, StopReason::SKIPPED) << tolerance;
        EXPECT_GT(moved->report().rowsBuilt, 0) << tolerance;
    }
}

TEST_F(PipelineTest, TurningCountsAtTheFarEnd)
{
    pipeline.process(squareSnapshot());
    SceneSnapshot turned = squareSnapshot();
    // The corners are 28 mm out: 28 mm * 0.004 is 0.0132 wavelengths.
    turned.objects[0].pose.linear() =
        Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitY()).toRotationMatrix();
    pipeline.process(turned);
    EXPECT_EQ(log->solves, 2);
}

TEST_F(PipelineTest, OtherPropertiesAreSolvedAnew)
{
    pipeline.process(squareSnapshot());
    SceneSnapshot stronger = squareSnapshot();
    stronger.objects[0].properties.pressure = 2.0;
    pipeline.process(stronger);
    EXPECT_EQ(log->solves, 2);
    stronger.objects[0].properties.spacing_m = 0.02;
    pipeline.process(stronger);
    EXPECT_EQ(log->solves, 3);
    EXPECT_EQ(pipeline.counters().meshesSampled, 2u);
}

TEST_F(PipelineTest, WhatIsGoneGoesSilent)
{
    pipeline.process(squareSnapshot());
    const int silencesBefore = log->silences;
    const auto result = pipeline.process({});
    EXPECT_EQ(log->silences, silencesBefore + 1);
    EXPECT_EQ(result->report().stop, StopReason::NOTHING_TO_DO);
    EXPECT_EQ(result->played().cwiseAbs().maxCoeff(), 0.0f);
    pipeline.process({});
    EXPECT_EQ(log->silences, silencesBefore + 1) << "nothing moved";
    pipeline.process(squareSnapshot());
    EXPECT_EQ(log->solves, 2) << "back again";
}

TEST_F(PipelineTest, OfTwoObjectsTheOtherGoesOn)
{
    SceneSnapshot two = squareSnapshot(-0.05);
    two.objects.push_back(two.objects[0]);
    two.objects[1].id = 2;
    two.objects[1].pose.translation().x() = 0.05;
    const auto both = pipeline.process(two);
    EXPECT_EQ(pipeline.counters().meshesSampled, 1u) << "one mesh";
    EXPECT_EQ(both->points.object.front(), 0);
    EXPECT_EQ(both->points.object.back(), 1);
    const auto one = pipeline.process(squareSnapshot(-0.05));
    EXPECT_EQ(2 * one->points.size(), both->points.size());
}

TEST_F(PipelineTest, AbsoluteTargetsWhereAnyObjectWantsThem)
{
    SceneSnapshot two = squareSnapshot(-0.05);
    two.objects.push_back(two.objects[0]);
    two.objects[1].id = 2;
    two.objects[1].pose.translation().x() = 0.05;
    two.objects[0].properties.pressure = 800.0;
    two.objects[0].properties.pressureInPa = true;
    two.objects[1].properties.pressure = 0.5; // of the strongest
    const auto result = pipeline.process(two);
    EXPECT_TRUE(result->points.absolute);
    EXPECT_TRUE(log->absolute);
    EXPECT_EQ(result->points.targets.maxCoeff(), 800.0);
    EXPECT_EQ(result->points.targets.minCoeff(), 400.0);
}

TEST_F(PipelineTest, PaintedBlackIsNotFelt)
{
    SceneSnapshot snapshot = squareSnapshot();
    auto painted = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    painted->intensity = Eigen::Vector4f(0.0f, 1.0f, 1.0f, 0.0f); // black on the left
    snapshot.objects[0].mesh = painted;
    const auto result = pipeline.process(snapshot);
    ASSERT_GT(result->points.size(), 0);
    for (int i = 0; i < result->points.size(); ++i)
        EXPECT_NEAR(result->points.targets[i],
                    (result->points.positions(0, i) + 0.02) / 0.04,
                    1e-6); // linear across the square; intensity is a float
}

TEST_F(PipelineTest, BadObjectsAreNamedAndLeftOut)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].mesh = std::make_shared<haptics::TriangleMesh>();
    expectRefused(snapshot, "Scene/Square: has no triangles; it can't be felt");
}

TEST_F(PipelineTest, APoseThatIsNotFiniteIsNamed)
{
    expectRefused(squareSnapshot(std::numeric_limits<double>::quiet_NaN()),
                  "Scene/Square: its pose is not finite; it can't be felt");
}

TEST_F(PipelineTest, ABadPressureIsNamed)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.pressure = -1.0;
    expectRefused(snapshot, "Scene/Square: pressure is -1, should be over 0; it can't be felt");
}

TEST_F(PipelineTest, VerticesThatAreNotFiniteAreNamed)
{
    SceneSnapshot snapshot = squareSnapshot();
    auto broken = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    broken->vertices(1, 2) = std::numeric_limits<double>::quiet_NaN();
    snapshot.objects[0].mesh = broken;
    const auto result = pipeline.process(snapshot);
    EXPECT_EQ(result->points.size(), 0);
    ASSERT_EQ(result->messages.size(), 1u);
    EXPECT_EQ(result->messages[0].rfind("Scene/Square: ", 0), 0u) << result->messages[0];
}

TEST_F(PipelineTest, ABadObjectDoesNotTakeTheGoodOnesAlong)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].mesh = nullptr;
    EXPECT_GT(pipeline.process(snapshot)->points.size(), 0);
    EXPECT_EQ(log->sends, 1);
}

TEST_F(PipelineTest, WhenTheSolverThrowsTheArrayIsSilent)
{
    pipeline.process(squareSnapshot());
    log->throwInSolve = true;
    const auto result = pipeline.process(squareSnapshot(0.02));
    EXPECT_EQ(result->report().stop, StopReason::REFUSED);
    EXPECT_EQ(result->report().message, "the fake solver throws");
    EXPECT_FALSE(result->playing);
    EXPECT_EQ(log->silences, 1);
    log->throwInSolve = false;
    EXPECT_EQ(pipeline.process(squareSnapshot(0.02))->report().stop, StopReason::CONVERGED)
        << "and goes on with the next, though nothing moved";
}

TEST_F(PipelineTest, ActivationsThatAreNotFiniteNeverReachTheDevice)
{
    log->notFinite = true;
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_EQ(log->sends, 0);
    EXPECT_EQ(log->silences, 1);
    EXPECT_EQ(result->report().stop, StopReason::REFUSED);
    EXPECT_EQ(result->played().cwiseAbs().maxCoeff(), 0.0f);
}

TEST_F(PipelineTest, ARefusedFieldIsTriedAgain)
{
    log->refuseSends = true;
    const auto refused = pipeline.process(squareSnapshot());
    EXPECT_FALSE(refused->playing);
    EXPECT_EQ(refused->achieved_Pa.maxCoeff(), 0.0f);
    ASSERT_EQ(refused->messages.size(), 1u);
    EXPECT_EQ(refused->messages[0], "device refused a field: fake");
    log->refuseSends = false;
    EXPECT_TRUE(pipeline.process(squareSnapshot())->playing);
}

TEST(HologramPipeline, ADeviceThatCannotBeOpenedIsAMessage)
{
    auto options = fakeOptions(std::make_shared<FakeLog>());
    options.deviceFactory = nullptr;
    options.deviceUri = "nonsense:";
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_GT(result->achieved_Pa.minCoeff(), 0.0f) << "solved and shown all the same";
    ASSERT_EQ(result->messages.size(), 1u);
    EXPECT_NE(result->messages[0].find("nonsense:"), std::string::npos) << result->messages[0];
    EXPECT_EQ(result->deviceStatus, "not open: " + result->messages[0]);
}

// The show isn't begun: its file is not even looked for.
TEST(HologramPipeline, ARecordingIsNoDeviceForAScene)
{
    for (const std::string uri : {"play:show.rec?to=sim:", "sim:,play:show.rec?to=sim:"})
    {
        auto options = fakeOptions(std::make_shared<FakeLog>());
        options.deviceFactory = nullptr;
        options.deviceUri = uri;
        HologramPipeline pipeline(options);
        const auto result = pipeline.process(squareSnapshot());
        EXPECT_GT(result->achieved_Pa.minCoeff(), 0.0f) << "solved and shown all the same";
        ASSERT_EQ(result->messages.size(), 1u);
        EXPECT_EQ(result->messages[0],
                  "device \"" + uri +
                      "\": a recording can't play a scene; play it with midair-device "
                      "play FILE");
    }
}

TEST(HologramPipeline, ClosingSilencesTheDevice)
{
    auto log = std::make_shared<FakeLog>();
    {
        HologramPipeline pipeline(fakeOptions(log));
        pipeline.process(squareSnapshot());
    }
    EXPECT_EQ(log->silences, 1);
    EXPECT_EQ(log->closed, 1);
}

TEST(HologramPipeline, BadOptionsThrowNamingThem)
{
    auto fails = [](auto change) -> std::string
    {
        auto options = fakeOptions(std::make_shared<FakeLog>());
        change(options);
        try
        {
            HologramPipeline pipeline(options);
        }
        catch (const base::InputError& error)
        {
            return error.what();
        }
        return "no error";
    };
    EXPECT_EQ(fails([](HologramOptions& o) { o.array = {}; }),
              "array \"\" has no transducers; it must have at least one");
    EXPECT_EQ(fails([](HologramOptions& o) { o.motionTolerance = -1.0; }),
              "motionTolerance is -1 wavelengths; it must be within 0 .. 1000");
    EXPECT_EQ(fails([](HologramOptions& o) { o.maxPoints = -1; }),
              "maxPoints is -1; it must be within 0 .. 5000");
    EXPECT_NE(fails([](HologramOptions& o) { o.medium.temperature_C = 1000.0; }).find("1000"),
              std::string::npos);
}
