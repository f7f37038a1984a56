#include "engine-bridge/pipeline/HologramPipeline.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// Real solver, fake device.
HologramOptions evenOptions(const std::shared_ptr<FakeLog>& log = std::make_shared<FakeLog>())
{
    HologramOptions options = fakeOptions(log);
    options.solverFactory = {};
    options.cycle = 4;
    return options;
}

using Results = std::vector<std::shared_ptr<const HologramResult>>;

/// All results until nothing is left to be made.
Results settled(HologramPipeline& pipeline)
{
    Results results;
    for (int k = 0; k < 10000 && pipeline.rest_s() == 0.0; ++k)
        if (auto next = pipeline.attend()) results.push_back(std::move(next));
    return results;
}

/// 1.5 mm apart on the square, the margin left out.
haptics::SurfaceStatistics felt(const std::vector<Eigen::VectorXcf>& fields)
{
    Eigen::Matrix3Xd places(3, 23 * 23);
    for (int i = 0; i < 23; ++i)
        for (int k = 0; k < 23; ++k)
            places.col(23 * i + k) = 1.5e-3 * Eigen::Vector3d(i - 11, 0.0, k - 11);
    return haptics::statisticsOf(
        haptics::meanRadiationPressure(
            places, haptics::TransducerArray::octagonalPrism(), haptics::Medium(), fields),
        Eigen::VectorXd());
}

/// Attends until a cycle that is being evened out was played.
void attendUntilEvened(HologramPipeline& pipeline)
{
    for (int k = 0; k < 10000; ++k)
    {
        const auto next = pipeline.attend();
        if (next && next->sequence.evened) return;
    }
    FAIL() << "nothing is evened out";
}

} // namespace

TEST(EvenedPipeline, WhatRestsIsEvenedOutAndPlayedAsItImproves)
{
    const auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(evenOptions(log));
    pipeline.process(squareSnapshot());
    const Results results = settled(pipeline);
    ASSERT_GE(results.size(), 4u);
    EXPECT_FALSE(results.front()->sequence.evened) << "the cycle is played before it is even";
    const haptics::SurfaceStatistics before = felt(results.front()->sequence.fields);
    double last = before.coefficientOfVariation;
    for (std::size_t k = 1; k < results.size(); ++k)
    {
        const haptics::FieldSequence& sequence = results[k]->sequence;
        EXPECT_TRUE(sequence.evened);
        EXPECT_EQ(sequence.fields.size(), 4u);
        EXPECT_TRUE(results[k]->playing);
        const haptics::SurfaceStatistics now = felt(sequence.fields);
        EXPECT_LT(now.coefficientOfVariation, last);
        EXPECT_GT(now.mean_Pa, 0.97 * before.mean_Pa);
        last = now.coefficientOfVariation;
        // Its figures are of what is felt, at the points of all fields.
        EXPECT_EQ(results[k]->achieved_Pa.size(), results[k]->points.size());
        EXPECT_LT(results[k]->report().rms, 0.6 * now.coefficientOfVariation + 0.05);
        EXPECT_NEAR(results[k]->achieved_Pa.mean(), results[k]->report().level_Pa, 10.0);
    }
    EXPECT_LT(last, 0.35 * before.coefficientOfVariation);
    EXPECT_GT(felt(results.back()->sequence.fields).mean_Pa, before.mean_Pa);
    // The device is given them again and again.
    const int sent = log->sends;
    EXPECT_TRUE(eventually([&] { return log->sends >= sent + 20; }));
    EXPECT_EQ(pipeline.attend(), nullptr) << "nothing is left to be made";
    EXPECT_GT(pipeline.rest_s(), 0.0);
}

/// The same for a single field, at once.
HologramOptions heldOptions(const std::shared_ptr<FakeLog>& log = std::make_shared<FakeLog>())
{
    HologramOptions options = evenOptions(log);
    options.cycle = 1;
    options.restAfter_s = 0.0;
    return options;
}

TEST(EvenedPipeline, AHeldFieldIsEvenedOutAndItsFiguresAreOfWhatIsPlayed)
{
    HologramPipeline pipeline(heldOptions());
    const auto first = pipeline.process(squareSnapshot());
    const Results results = settled(pipeline);
    ASSERT_GE(results.size(), 2u);
    const haptics::SurfaceStatistics before = felt(first->sequence.fields);
    double last = before.coefficientOfVariation;
    for (const auto& result : results)
    {
        ASSERT_TRUE(result->sequence.evened && result->sequence.isHeld());
        EXPECT_FALSE(result->outline);
        EXPECT_TRUE(result->playing);
        const haptics::SurfaceStatistics now = felt(result->sequence.fields);
        // Here the margin is left out, which the equaliser sees, too.
        EXPECT_LT(now.coefficientOfVariation, 1.02 * last);
        EXPECT_GT(now.mean_Pa, 0.97 * before.mean_Pa);
        last = now.coefficientOfVariation;
        const Eigen::VectorXd achieved_Pa = haptics::pressureAt(result->points.positions,
                                                                *result->array,
                                                                result->medium,
                                                                result->sequence.fields.front())
                                                .cwiseAbs()
                                                .cast<double>();
        const double level_Pa = achieved_Pa.mean(); // all targets are the same
        EXPECT_NEAR(result->report().level_Pa, level_Pa, 1e-3 * level_Pa);
        EXPECT_NEAR(result->report().rms,
                    std::sqrt((achieved_Pa.array() / level_Pa - 1.0).square().mean()),
                    1e-3);
        EXPECT_GT(result->report().driveChange, 0.0);
    }
    EXPECT_LT(last, 0.7 * before.coefficientOfVariation);
    EXPECT_EQ(pipeline.attend(), nullptr) << "nothing is left to be made";
    EXPECT_GT(pipeline.rest_s(), 0.0);
}

// It belongs to no points, and is measured all the same.
TEST(EvenedPipeline, AMonitorMeasuresAHeldFieldThatIsEvenedOut)
{
    HologramOptions options = heldOptions();
    options.monitorInterval = 0.1;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    std::shared_ptr<const HologramResult> last;
    EXPECT_TRUE(eventually(
        [&]
        {
            if (auto next = pipeline.attend()) last = std::move(next);
            return last && last->sequence.evened && last->monitored &&
                   (!last->monitored->error.empty() ||
                    last->monitored->surface.coefficientOfVariation < 0.6);
        }));
    ASSERT_TRUE(last && last->monitored);
    EXPECT_EQ(last->monitored->error, "");
}

TEST(EvenedPipeline, AHeldFieldIsEvenedOutOnlyWhenItHasRested)
{
    midair::test::SetClock clock;
    HologramOptions options = heldOptions();
    options.clock = &clock;
    options.restAfter_s = 0.15;
    HologramPipeline pipeline(options);
    for (int frame = 0; frame < 5; ++frame)
    {
        pipeline.process(squareSnapshot(1e-3 * frame));
        clock.pass(0.1);
        EXPECT_NEAR(pipeline.rest_s(), 0.05, 1e-9);
        EXPECT_EQ(pipeline.attend(), nullptr);
    }
    clock.pass(0.06);
    EXPECT_EQ(pipeline.rest_s(), 0.0);
    EXPECT_TRUE(settled(pipeline).back()->sequence.evened);
}

TEST(EvenedPipeline, HeldFieldsOfPointsEdgesAndPressuresInPaStay)
{
    for (const auto sampling :
         {haptics::Sampling::SURFACE, haptics::Sampling::VERTICES, haptics::Sampling::EDGES})
    {
        HologramPipeline pipeline(heldOptions());
        SceneSnapshot snapshot = squareSnapshot();
        snapshot.objects[0].properties.sampling = sampling;
        snapshot.objects[0].properties.pressureInPa = sampling == haptics::Sampling::SURFACE;
        snapshot.objects[0].properties.pressure = 500.0;
        pipeline.process(snapshot);
        for (const auto& result : settled(pipeline))
            EXPECT_FALSE(result->sequence.evened) << static_cast<int>(sampling);
    }
    HologramOptions off = heldOptions();
    off.even = 0;
    HologramPipeline pipeline(off);
    pipeline.process(squareSnapshot());
    for (const auto& result : settled(pipeline)) // of the walk to a louder field
        EXPECT_FALSE(result->sequence.evened);
}

TEST(EvenedPipeline, AHeldFieldKeepsToTheCapOnTheWay)
{
    HologramOptions options = heldOptions();
    options.maxPressure = 800.0;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    const Results results = settled(pipeline);
    ASSERT_FALSE(results.empty());
    for (const auto& result : results)
    {
        EXPECT_LT(result->report().capFactor, 1.0);
        EXPECT_LE(haptics::pressureAt(result->points.positions,
                                      options.array,
                                      options.medium,
                                      result->sequence.fields.front())
                      .cwiseAbs()
                      .maxCoeff(),
                  800.0 * 1.0001);
    }
}

TEST(EvenedPipeline, WhatMovesIsSolvedForAsIfNothingHadBeenEvenedOut)
{
    HologramOptions options = evenOptions();
    HologramPipeline evened(options);
    options.even = 0;
    HologramPipeline plain(options);
    for (int update = 0; update < 3; ++update)
    {
        // In the midst of the evening out, something moves.
        const double x_m = 0.001 * update;
        const auto now = evened.process(squareSnapshot(x_m));
        const auto then = plain.process(squareSnapshot(x_m));
        EXPECT_TRUE(now->sequence.isHeld());
        EXPECT_FALSE(now->sequence.evened);
        EXPECT_EQ(now->report().iterations, then->report().iterations);
        EXPECT_TRUE(now->points.positions == then->points.positions);
        // One and the same field; its common phase continues what was played before.
        EXPECT_NEAR(
            std::abs(now->played().dot(then->played())) / now->played().squaredNorm(), 1.0f, 1e-5f);
        settled(plain);
        attendUntilEvened(evened);
        for (int k = 0; k < 7; ++k)
            evened.attend();
        EXPECT_EQ(evened.rest_s(), 0.0) << "work is left";
    }
    EXPECT_EQ(evened.counters().solves, plain.counters().solves);
}

TEST(EvenedPipeline, SnapshotsThatMoveNothingDontInterrupt)
{
    HologramPipeline pipeline(evenOptions());
    pipeline.process(squareSnapshot());
    std::shared_ptr<const HologramResult> last;
    for (int k = 0; k < 10000 && pipeline.rest_s() == 0.0; ++k)
    {
        if (auto next = pipeline.attend()) last = next;
        pipeline.process(squareSnapshot());
    }
    HologramPipeline alone(evenOptions());
    alone.process(squareSnapshot());
    const Results results = settled(alone);
    ASSERT_TRUE(last);
    EXPECT_TRUE(last->sequence.evened);
    EXPECT_EQ(last->sequence.fields, results.back()->sequence.fields);
    EXPECT_GT(pipeline.counters().skippedUnmoved, 100u);
}

TEST(EvenedPipeline, EveryCycleOnTheWayKeepsToTheCap)
{
    HologramOptions options = evenOptions();
    options.cycleSteps = 1;
    options.maxPressure = 800.0;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    const Results results = settled(pipeline);
    ASSERT_GE(results.size(), 3u);
    EXPECT_TRUE(results.back()->sequence.evened);
    for (const auto& result : results)
    {
        ASSERT_EQ(result->sequence.fields.size(), 8u);
        EXPECT_LT(result->report().capFactor, 1.0);
        for (const Eigen::VectorXcf& q : result->sequence.fields)
            EXPECT_LE(
                haptics::pressureAt(result->points.positions, options.array, options.medium, q)
                    .cwiseAbs()
                    .maxCoeff(),
                800.0 * 1.0001);
    }
}

TEST(EvenedPipeline, PointsInPaKeepTheirPressureInTheirOwnField)
{
    HologramPipeline pipeline(evenOptions());
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.pressureInPa = true;
    snapshot.objects[0].properties.pressure = 500.0;
    pipeline.process(snapshot);
    const Results results = settled(pipeline);
    ASSERT_EQ(results.size(), 1u);
    EXPECT_FALSE(results.front()->sequence.evened);
    EXPECT_NEAR(results.front()->report().level_Pa, 500.0, 15.0);
}

TEST(EvenedPipeline, ObjectsOfDifferentPressureKeepTheirRatio)
{
    HologramPipeline pipeline(evenOptions());
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].mesh = squareMesh(0.02);
    snapshot.objects[0].pose.translation().x() = -0.02;
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].path = "Scene/Other";
    snapshot.objects[1].pose.translation().x() = 0.02;
    snapshot.objects[1].properties.pressure *= 0.5;
    pipeline.process(snapshot);
    const Results results = settled(pipeline);
    ASSERT_TRUE(!results.empty() && results.back()->sequence.evened);
    const HologramResult& last = *results.back();
    double sum[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
    for (int l = 0; l < last.points.size(); ++l)
    {
        const int object = last.points.object[static_cast<std::size_t>(l)];
        sum[object] += static_cast<double>(last.achieved_Pa[l]);
        ++count[object];
    }
    EXPECT_NEAR(sum[1] / count[1] / (sum[0] / count[0]), 0.5, 0.06);
    EXPECT_LT(last.report().rms, 0.15);
}

TEST(EvenedPipeline, ASurfaceTooLargeIsToldAndPlayedAsItIs)
{
    HologramOptions options = evenOptions();
    options.array = haptics::TransducerArray::singleBoard();
    options.maxPoints = 5000;
    options.cycle = 2;
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].mesh = squareMesh(0.4);
    snapshot.objects[0].pose.translation() = Eigen::Vector3d(0.0, 0.0, 0.25);
    pipeline.process(snapshot);
    const Results results = settled(pipeline);
    ASSERT_EQ(results.size(), 2u) << "one with the fields in turn, one with the message";
    EXPECT_FALSE(results.back()->sequence.evened);
    EXPECT_EQ(results.back()->sequence.fields, results.front()->sequence.fields);
    ASSERT_FALSE(pipeline.messages().empty());
    EXPECT_NE(pipeline.messages().back().find("is not evened out: its surfaces have more than"),
              std::string::npos)
        << pipeline.messages().back();
}

// Beside the thread that evens out, frames go on, and each newest one is taken.
TEST(EvenedPipeline, TheThreadTakesTheNewestSnapshotAndEvensOutWhatComesToRest)
{
    HologramThread thread(evenOptions());
    double x_m = 0.0;
    for (std::uint64_t frame = 1; frame <= 20; ++frame)
    {
        x_m = 0.0005 * static_cast<double>(frame);
        SceneSnapshot snapshot = squareSnapshot(x_m);
        snapshot.frame = frame;
        thread.submit(snapshot);
        ASSERT_TRUE(eventually(
            [&] { return thread.latestResult() && thread.latestResult()->frame == frame; }));
    }
    EXPECT_EQ(thread.counters().superseded, 0u);
    std::shared_ptr<const HologramResult> result;
    eventually(
        [&]
        {
            result = thread.latestResult();
            return result->sequence.evened && result->report().rms < 0.1;
        });
    EXPECT_TRUE(result->sequence.evened);
    EXPECT_LT(result->report().rms, 0.1);
}

TEST(EvenedPipeline, TheMonitorMeasuresTheSurfaceButCertifiesNoPointsOfAField)
{
    HologramOptions options = evenOptions();
    options.monitorInterval = 0.05;
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    std::shared_ptr<const HologramResult> result;
    eventually(
        [&]
        {
            result = thread.latestResult();
            return result && result->sequence.evened && result->monitored &&
                   result->report().surface.coefficientOfVariation < 0.35 &&
                   result->monitored->certificate.points == 0;
        },
        800.0); // the monitor runs only when nobody else wants to
    ASSERT_TRUE(result && result->monitored);
    EXPECT_EQ(result->monitored->error, "");
    EXPECT_EQ(result->monitored->certificate.points, 0);
    EXPECT_GT(result->report().surface.samples, 400);
    EXPECT_LT(result->report().surface.coefficientOfVariation, 0.35);
}
