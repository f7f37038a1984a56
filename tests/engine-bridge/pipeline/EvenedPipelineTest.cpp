#include "engine-bridge/pipeline/HologramPipeline.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/solvers/production/LouderPhases.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/AtRest.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/sequence/EvenedScenes.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// All results with another field or message, until nothing is left to be made.
Results settled(HologramPipeline& pipeline)
{
    Results results;
    for (int k = 0; k < 10000 && pipeline.rest_s() == 0.0; ++k)
    {
        auto next = pipeline.attend();
        if (!next) continue;
        const bool isSame = !results.empty() &&
                            results.back()->sequence.fields == next->sequence.fields &&
                            results.back()->messages == next->messages;
        if (!isSame) results.push_back(std::move(next));
    }
    return results;
}

/// 1.5 mm apart on the square, the margin left out.
haptics::SurfaceStatistics
felt(const std::vector<Eigen::VectorXcf>& fields,
     const haptics::TransducerArray& array = haptics::TransducerArray::octagonalPrism())
{
    Eigen::Matrix3Xd places(3, 23 * 23);
    for (int i = 0; i < 23; ++i)
        for (int k = 0; k < 23; ++k)
            places.col(23 * i + k) = 1.5e-3 * Eigen::Vector3d(i - 11, 0.0, k - 11);
    return haptics::statisticsOf(
        haptics::meanRadiationPressure(places, array, haptics::Medium(), fields),
        Eigen::VectorXd());
}

/// Pressures of the played field at its points.
Eigen::VectorXd pressuresOf(const HologramResult& result)
{
    return haptics::pressureAt(result.points.positions,
                               haptics::TransducerArray::octagonalPrism(),
                               haptics::Medium(),
                               result.played())
        .cwiseAbs()
        .cast<double>();
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

TEST(EvenedPipeline, AHeldFieldIsWalkedToAnEvenedOne)
{
    AtRest scene;
    auto last = scene.show(squareSnapshot());
    const haptics::SurfaceStatistics before = felt(last->sequence.fields);
    const auto results = scene.rest(10.0);
    ASSERT_GE(results.size(), 50u);
    EXPECT_EQ(scene.pipeline->counters().walked, results.size());
    double level_Pa = pressuresOf(*last).mean();
    double felt_Pa = before.mean_Pa;
    for (const auto& result : results)
    {
        ASSERT_TRUE(result->sequence.evened && result->sequence.isHeld());
        EXPECT_FALSE(result->outline);
        EXPECT_TRUE(result->playing);
        // No step is felt: neither at the points nor on the surface.
        const double turn_rad = haptics::meanTurn(last->played(), result->played());
        EXPECT_LE(turn_rad, 1.05 * haptics::PhaseWalk::kMostTurn_rad);
        EXPECT_NEAR(result->report().meanPhaseStep_rad, turn_rad, 0.02);
        EXPECT_LT(result->report().driveChange, 0.1);
        const Eigen::VectorXd now_Pa = pressuresOf(*result); // all targets are the same
        const double ratio = now_Pa.mean() / level_Pa;
        level_Pa = now_Pa.mean();
        EXPECT_LE(std::max(ratio, 1.0 / ratio), haptics::PhaseWalk::kMostJump + 1e-3);
        EXPECT_NEAR(result->report().levelJump, std::max(ratio, 1.0 / ratio), 1e-3);
        const double mean_Pa = felt(result->sequence.fields).mean_Pa;
        EXPECT_LE(std::fabs(mean_Pa / felt_Pa - 1.0), 0.04);
        EXPECT_GT(mean_Pa, 0.75 * before.mean_Pa);
        felt_Pa = mean_Pa;
        // The figures are of what is played.
        EXPECT_NEAR(result->report().level_Pa, level_Pa, 1e-3 * level_Pa);
        EXPECT_NEAR(result->report().rms,
                    std::sqrt((now_Pa.array() / level_Pa - 1.0).square().mean()),
                    1e-3);
        EXPECT_GT(result->report().surface.samples, 400) << "from the first one on";
        last = result;
    }
    const haptics::SurfaceStatistics after = felt(last->sequence.fields);
    EXPECT_LT(after.coefficientOfVariation, 0.7 * before.coefficientOfVariation);
    EXPECT_GT(after.mean_Pa, 0.97 * before.mean_Pa);
    // Here the margin of the square is left out.
    const haptics::SurfaceStatistics& told = last->report().surface;
    EXPECT_NEAR(told.mean_Pa, after.mean_Pa, 0.1 * after.mean_Pa);
    EXPECT_NEAR(told.coefficientOfVariation, after.coefficientOfVariation, 0.1);
    EXPECT_TRUE(scene.rest(1.0).empty()) << "nothing is left to be made";
    EXPECT_GT(scene.pipeline->rest_s(), 0.0);
}

// It belongs to no points, and is measured all the same.
TEST(EvenedPipeline, AMonitorMeasuresAHeldFieldThatIsEvenedOut)
{
    HologramOptions options = evenOptions();
    options.cycle = 1;
    options.monitorInterval = 0.1;
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    std::shared_ptr<const HologramResult> last;
    EXPECT_TRUE(eventually(
        [&]
        {
            for (int k = 0; k < 50; ++k)
                if (auto next = pipeline.attend()) last = std::move(next);
            return last && last->sequence.evened && last->monitored &&
                   (!last->monitored->error.empty() ||
                    last->monitored->surface.coefficientOfVariation < 0.6);
        }));
    ASSERT_TRUE(last && last->monitored);
    EXPECT_EQ(last->monitored->error, "");
    EXPECT_TRUE(last->monitored->isEvened);
    EXPECT_EQ(last->monitored->certificate.points, 0);
}

TEST(EvenedPipeline, AHeldFieldIsEvenedOutOnlyWhenItHasRested)
{
    AtRest scene;
    for (int frame = 0; frame < 5; ++frame)
    {
        scene.show(squareSnapshot(1e-3 * frame));
        EXPECT_NEAR(scene.pipeline->rest_s(), 0.15, 1e-9);
        EXPECT_TRUE(scene.rest(0.1).empty());
    }
    EXPECT_FALSE(scene.rest(2.0).empty());
    EXPECT_TRUE(scene.newest->sequence.evened);
}

TEST(EvenedPipeline, WhatMovesOnTheWayIsSolvedForAtOnce)
{
    AtRest scene;
    scene.show(squareSnapshot());
    while (scene.pipeline->counters().walked < 5)
        scene.rest(0.005);
    const auto moved = scene.show(squareSnapshot(0.002));
    EXPECT_FALSE(moved->sequence.evened);
    EXPECT_LT(moved->report().rms, 2e-3);
    EXPECT_EQ(moved->report().surface.samples, 0);
    EXPECT_TRUE(scene.rest(0.14).empty());
    EXPECT_FALSE(scene.rest(2.0).empty());
    EXPECT_TRUE(scene.newest->sequence.evened);
}

TEST(EvenedPipeline, HeldFieldsOfPointsEdgesAndPressuresInPaStay)
{
    for (const auto sampling :
         {haptics::Sampling::SURFACE, haptics::Sampling::VERTICES, haptics::Sampling::EDGES})
    {
        AtRest scene;
        SceneSnapshot snapshot = squareSnapshot();
        snapshot.objects[0].properties.sampling = sampling;
        snapshot.objects[0].properties.pressureInPa = sampling == haptics::Sampling::SURFACE;
        snapshot.objects[0].properties.pressure = 500.0;
        scene.show(snapshot);
        for (const auto& result : scene.rest(3.0))
            EXPECT_FALSE(result->sequence.evened) << static_cast<int>(sampling);
    }
    AtRest plain([](HologramOptions& options) { options.even = 0; });
    plain.show(squareSnapshot());
    EXPECT_TRUE(plain.rest(3.0).empty());
    AtRest off([](HologramOptions& options)
               { options.restAfter_s = std::numeric_limits<double>::infinity(); });
    off.show(squareSnapshot());
    EXPECT_TRUE(off.rest(3.0).empty());
}

// The cap is one at the points, whose pressures fall: raised to it, the field would pass it between
// them.
TEST(EvenedPipeline, AHeldFieldThatACapLowersIsEvenedOutAtItsShareOfTheDrive)
{
    AtRest lowered([](HologramOptions& options) { options.maxPressure = 800.0; });
    const auto first = lowered.show(squareSnapshot());
    const double share = first->report().capFactor;
    const double before_Pa = felt(first->sequence.fields).mean_Pa;
    ASSERT_LT(share, 0.5);
    const auto results = lowered.rest(5.0);
    ASSERT_GE(results.size(), 50u);
    for (const auto& result : results)
    {
        EXPECT_LE(pressuresOf(*result).maxCoeff(), 800.0 * 1.0001);
        EXPECT_LE(result->played().cwiseAbs().maxCoeff(), share * 1.0001);
        EXPECT_LE(result->report().capFactor, share * 1.0001);
        EXPECT_GT(result->report().capFactor, 0.8 * share) << "levels of 13";
        EXPECT_LT(result->report().driveChange, 0.1);
        ASSERT_FALSE(result->messages.empty());
        EXPECT_EQ(result->messages[0],
                  "the field is held down to the cap of 800 Pa at any control point, by "
                  "MaxPressure");
    }
    const auto& last = results.back()->sequence;
    EXPECT_LT(felt(last.fields).coefficientOfVariation, 0.6);
    EXPECT_NEAR(felt(last.fields).mean_Pa, before_Pa, 0.05 * before_Pa);
    // A cap that isn't reached changes nothing, and holds on the way.
    AtRest free;
    const double level_Pa = free.show(squareSnapshot())->achieved_Pa.maxCoeff();
    AtRest below([&](HologramOptions& options) { options.maxPressure = 1.02 * level_Pa; });
    EXPECT_EQ(below.show(squareSnapshot())->report().capFactor, 1.0);
    for (const auto& result : below.rest(5.0))
        EXPECT_LE(pressuresOf(*result).maxCoeff(), 1.02 * level_Pa * 1.0001);
    EXPECT_TRUE(below.newest->sequence.evened);
    EXPECT_LT(felt(below.newest->sequence.fields).coefficientOfVariation, 0.6);
}

// As for a recording: what is even from the first field on needs no walk.
TEST(EvenedPipeline, WithoutATimeToRestEachFieldOfASlowSurfaceIsEvenAtOnce)
{
    AtRest scene([](HologramOptions& options) { options.restAfter_s = 0.0; });
    const auto shown = [&](double x_m)
    {
        auto result = scene.show(squareSnapshot(x_m));
        while (scene.pipeline->rest_s() <= 0.0)
            if (auto next = scene.pipeline->attend()) result = next;
        return result;
    };
    const auto feltAt = [&](double x_m, const HologramResult& result)
    {
        // The square's own places: the array is moved to the other side.
        haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
        array.positions.colwise() -= Eigen::Vector3d(x_m, 0.0, 0.0);
        return felt(result.sequence.fields, array);
    };
    AtRest plain([](HologramOptions& options) { options.even = 0; });
    const auto solved = feltAt(0.0, *plain.show(squareSnapshot()));
    std::shared_ptr<const HologramResult> last;
    for (int frame = 0; frame < 6; ++frame)
    {
        const double x_m = 5e-4 * frame;
        const auto result = shown(x_m);
        ASSERT_TRUE(result->sequence.evened && result->sequence.isHeld());
        EXPECT_EQ(scene.pipeline->counters().walked, 0u);
        const haptics::SurfaceStatistics now = feltAt(x_m, *result);
        EXPECT_LT(now.coefficientOfVariation, 0.7 * solved.coefficientOfVariation) << frame;
        EXPECT_GT(now.mean_Pa, 0.95 * solved.mean_Pa) << frame;
        if (last)
        {
            EXPECT_LT(haptics::meanTurn(last->played(), result->played()), 0.6) << frame;
        }
        last = result;
    }
    EXPECT_EQ(shown(2.5e-3)->played(), last->played()) << "nothing has moved";
    // What moves fast would be switched between unrelated fields.
    EXPECT_FALSE(shown(0.01)->sequence.evened);
    EXPECT_FALSE(shown(0.02)->sequence.evened);
    EXPECT_TRUE(shown(0.0205)->sequence.evened);
}

// Neither a mute on the way nor one at the end throws it away.
TEST(EvenedPipeline, AfterAMuteTheEvenedFieldComesBack)
{
    for (const double before_s : {0.3, 10.0})
    {
        AtRest scene;
        scene.show(squareSnapshot());
        scene.rest(before_s);
        ASSERT_TRUE(scene.newest->sequence.evened);
        scene.pipeline->device().setMuted(true);
        scene.rest(1.0);
        scene.show(squareSnapshot()); // frames go on
        EXPECT_FALSE(scene.newest->playing);
        EXPECT_TRUE(scene.newest->played().isZero(0.0f));
        scene.rest(1.0);
        EXPECT_TRUE(scene.newest->played().isZero(0.0f)) << "nothing is played";
        scene.pipeline->device().setMuted(false);
        scene.show(squareSnapshot());
        scene.rest(10.0);
        EXPECT_TRUE(scene.newest->playing);
        EXPECT_TRUE(scene.newest->sequence.evened);
        EXPECT_LT(felt({scene.newest->played()}).coefficientOfVariation, 0.6);
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
