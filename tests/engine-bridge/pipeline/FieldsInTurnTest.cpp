#include "engine-bridge/pipeline/HologramPipeline.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldOrder.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// Real solver, fake device.
HologramOptions turnOptions(const std::shared_ptr<FakeLog>& log)
{
    HologramOptions options = fakeOptions(log);
    options.solverFactory = {};
    return options;
}

/// The newest result once nothing is left to be made; the first one where there is nothing.
std::shared_ptr<const HologramResult> settled(HologramPipeline& pipeline,
                                              std::shared_ptr<const HologramResult> result)
{
    for (int k = 0; k < 1000 && pipeline.rest_s() == 0.0; ++k)
        if (auto next = pipeline.attend()) result = next;
    return result;
}

// By the formula in double precision, apart from everything that solves.
Eigen::VectorXd pressures(const Eigen::Matrix3Xd& points, const Eigen::VectorXcf& q)
{
    return (haptics::referencePropagationMatrix(
                points, haptics::TransducerArray::octagonalPrism(), haptics::Medium()) *
            q.cast<std::complex<double>>())
        .cwiseAbs();
}

double variation(const Eigen::Matrix3Xd& places, const std::vector<Eigen::VectorXcf>& fields)
{
    Eigen::VectorXd square = Eigen::VectorXd::Zero(places.cols());
    for (const Eigen::VectorXcf& q : fields)
        square += pressures(places, q).cwiseAbs2();
    return std::sqrt((square.array() - square.mean()).square().mean()) / square.mean();
}

/// 1.5 mm apart, the margin left out.
Eigen::Matrix3Xd placesOnSquare()
{
    Eigen::Matrix3Xd places(3, 23 * 23);
    for (int i = 0; i < 23; ++i)
        for (int k = 0; k < 23; ++k)
            places.col(23 * i + k) = 1.5e-3 * Eigen::Vector3d(i - 11, 0.0, k - 11);
    return places;
}

SceneSnapshot twoSquares()
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].mesh = squareMesh(0.02);
    snapshot.objects[0].pose.translation().x() = -0.02;
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].path = "Scene/Other";
    snapshot.objects[1].pose.translation().x() = 0.02;
    return snapshot;
}

} // namespace

TEST(FieldsInTurn, WhatRestsIsSmoothedByShiftedFields)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = turnOptions(log);
    options.cycle = 6;
    options.even = 0;
    HologramPipeline pipeline(options);
    const auto first = pipeline.process(squareSnapshot());
    EXPECT_TRUE(first->sequence.isHeld());
    const auto last = settled(pipeline, first);
    ASSERT_EQ(last->sequence.fields.size(), 6u);
    EXPECT_EQ(last->frame, first->frame);
    EXPECT_GT(last->points.size(), 5 * first->points.size()); // no set has the first one's corners
    EXPECT_EQ(last->report().points, last->points.size());
    EXPECT_EQ(last->achieved_Pa.size(), last->points.size());
    EXPECT_LT(last->report().rms, 0.01);
    EXPECT_GT(last->report().driveChange, 0.0);
    // Each point gets its pressure in the field that is for it.
    EXPECT_GT(last->achieved_Pa.minCoeff(), 0.85f * last->achieved_Pa.maxCoeff());
    const Eigen::Matrix3Xd places = placesOnSquare();
    EXPECT_LT(variation(places, last->sequence.fields),
              0.65 * variation(places, {first->played()}));
    // The device is given them again and again.
    const int sent = log->sends;
    EXPECT_TRUE(eventually([&] { return log->sends >= sent + 20; }));
    EXPECT_EQ(pipeline.attend(), nullptr) << "nothing is left to be made";
    EXPECT_GT(pipeline.rest_s(), 0.0);
}

TEST(FieldsInTurn, OfWhatMovesEachUpdateTakesTheNextSet)
{
    HologramOptions options = turnOptions(std::make_shared<FakeLog>());
    options.cycle = 3;
    HologramPipeline pipeline(options);
    std::vector<Eigen::Matrix3Xd> sets;
    Eigen::VectorXcf before;
    for (int k = 0; k < 6; ++k)
    {
        const auto result = pipeline.process(squareSnapshot(0.001 * k));
        EXPECT_TRUE(result->sequence.isHeld());
        Eigen::Matrix3Xd points = result->points.positions;
        points.row(0).array() -= 0.001 * k;
        sets.push_back(points);
        // The common phase is the one that is nearest to the field before, to half a level.
        if (before.size() > 0)
        {
            EXPECT_NEAR(std::arg(result->played().dot(before)), 0.0f, M_PI / 256 + 1e-3);
            EXPECT_NEAR(result->report().driveChange,
                        haptics::cycleSteps({before, result->played()}).driveChange,
                        1e-3);
        }
        before = result->played();
        // Begun for what might rest, and given up.
        EXPECT_EQ(pipeline.attend(), nullptr);
    }
    for (int k = 0; k < 3; ++k)
    {
        const auto set = static_cast<std::size_t>(k);
        EXPECT_TRUE(sets[set].isApprox(sets[set + 3], 1e-9)) << k;
        EXPECT_FALSE(sets[set].cols() == sets[(set + 1) % 3].cols() &&
                     sets[set].isApprox(sets[(set + 1) % 3], 1e-3));
    }
}

TEST(FieldsInTurn, SubsetsArePressedHarder)
{
    HologramOptions options = turnOptions(std::make_shared<FakeLog>());
    HologramPipeline plain(options);
    const auto all = plain.process(squareSnapshot());
    options.subsets = 4;
    HologramPipeline pipeline(options);
    const auto inTurn = pipeline.process(squareSnapshot());
    ASSERT_EQ(inTurn->sequence.fields.size(), 4u);
    EXPECT_EQ(inTurn->points.size(), all->points.size());
    EXPECT_EQ(inTurn->sequence.modulation.fieldRate_Hz, 1000.0);
    EXPECT_GT(inTurn->report().level_Pa, 1.5 * all->report().level_Pa);
    EXPECT_GT(inTurn->achieved_Pa.minCoeff(), 0.98f * inTurn->achieved_Pa.maxCoeff());
    EXPECT_EQ(pipeline.attend(), nullptr);
}

TEST(FieldsInTurn, AnObjectsOwnModulationIsPlayed)
{
    HologramPipeline pipeline(turnOptions(std::make_shared<FakeLog>()));
    SceneSnapshot snapshot = twoSquares();
    snapshot.objects[1].properties.modulationFrequency_Hz = 100.0;
    const auto result = pipeline.process(snapshot);
    ASSERT_EQ(result->sequence.fields.size(), 10u); // 1000 fields/s
    EXPECT_EQ(result->sequence.modulation.fieldRate_Hz, 1000.0);
    const int n = result->points.size();
    const double level = result->report().level_Pa;
    for (std::size_t j = 0; j < 10; ++j)
    {
        const Eigen::VectorXd p = pressures(result->points.positions, result->sequence.fields[j]);
        const double skin = 0.5 * (1.0 + std::cos(2.0 * M_PI * static_cast<double>(j) / 10.0));
        for (int l = 0; l < n; ++l)
        {
            const bool steady = result->points.object[static_cast<std::size_t>(l)] == 0;
            if (!steady && skin < 1e-6) continue;
            EXPECT_NEAR(std::pow(p[l] / level, 2), steady ? 1.0 : skin, 0.03)
                << "point " << l << ", step " << j;
        }
    }
    // Another frequency isn't had at the same time, and that is told.
    snapshot.objects[0].properties.modulationFrequency_Hz = 50.0;
    snapshot.objects[0].properties.modulationDepth = 0.5;
    pipeline.process(snapshot);
    EXPECT_EQ(pipeline.messages().back(),
              "Scene/Other: is modulated at 50 Hz like Scene/Square, not at 100 Hz: the array "
              "plays one field at a time");
    snapshot.objects[1].properties.modulationFrequency_Hz = 50.0000001;
    pipeline.process(snapshot);
    EXPECT_EQ(pipeline.messages().back(),
              "Scene/Other: is modulated at 50 Hz like Scene/Square, not at 50.0000001 Hz: the "
              "array plays one field at a time");
}

TEST(FieldsInTurn, ObjectsThatAreModulatedAlikeAreOneFieldThatIsModulated)
{
    const auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(turnOptions(log));
    SceneSnapshot snapshot = twoSquares();
    for (HapticObject& object : snapshot.objects)
        object.properties.modulationFrequency_Hz = 200.0;
    const auto result = pipeline.process(snapshot);
    EXPECT_TRUE(result->sequence.isHeld());
    EXPECT_NEAR(result->played().cwiseAbs().minCoeff(), 1.0f, 1e-6f);
    EXPECT_TRUE(eventually([&] { return log->sends >= 20; }));
    for (HapticObject& object : snapshot.objects)
        object.properties.modulationFrequency_Hz = 0.0;
    pipeline.process(snapshot);
    const int sent = log->sends;
    EXPECT_TRUE(othersSend(30));
    EXPECT_EQ(log->sends, sent) << "steady again: one field that is held";
}

TEST(FieldsInTurn, CurvesThatRestAreOneFieldWithoutRipples)
{
    HologramPipeline pipeline(turnOptions(std::make_shared<FakeLog>()));
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.sampling = haptics::Sampling::EDGES;
    const auto points = pipeline.process(snapshot);
    EXPECT_FALSE(points->outline);
    const auto curve = settled(pipeline, points);
    EXPECT_TRUE(curve->outline);
    EXPECT_TRUE(curve->sequence.isHeld());
    EXPECT_EQ(curve->report().solver, "outline");
    // Its figures are its own, not those of the field before it.
    const haptics::CycleSteps step = haptics::cycleSteps({points->played(), curve->played()});
    EXPECT_GT(step.driveChange, 0.01);
    EXPECT_NEAR(curve->report().driveChange, step.driveChange, 1e-6);
    EXPECT_NEAR(curve->report().meanPhaseStep_rad, step.meanPhaseStep_rad, 1e-6);
    EXPECT_GT(curve->report().audibleChange, 0.0);
    EXPECT_GT(curve->points.size(), 3 * points->points.size());
    Eigen::Matrix3Xd places(3, 160);
    for (int k = 0; k < 40; ++k)
        for (int side = 0; side < 4; ++side)
            places.col(4 * k + side) =
                Eigen::AngleAxisd(0.5 * M_PI * side, Eigen::Vector3d::UnitY()) *
                Eigen::Vector3d(0.02, 0.0, 1e-3 * (k - 20));
    EXPECT_LT(variation(places, {curve->played()}), 0.5 * variation(places, {points->played()}));
    // Moving, it is points again, at once.
    snapshot.objects[0].pose.translation().x() = 0.002;
    EXPECT_FALSE(pipeline.process(snapshot)->outline);
    EXPECT_TRUE(settled(pipeline, nullptr)->outline);
    // In Pa it is as loud as asked, to half a level of amplitude.
    snapshot.objects[0].properties.pressureInPa = true;
    snapshot.objects[0].properties.pressure = 3000.0;
    pipeline.process(snapshot);
    const auto quiet = settled(pipeline, nullptr);
    EXPECT_TRUE(quiet->outline);
    EXPECT_NEAR(quiet->report().level_Pa, 3000.0, 60.0);
}

TEST(FieldsInTurn, ACurvesLoudnessIsTheOptions)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.sampling = haptics::Sampling::EDGES;
    double level_Pa[2];
    for (const int k : {0, 1})
    {
        HologramOptions options = turnOptions(std::make_shared<FakeLog>());
        options.solverOptions.loudness = k == 0 ? 1.0 : 0.5;
        HologramPipeline pipeline(options);
        level_Pa[k] = settled(pipeline, pipeline.process(snapshot))->report().level_Pa;
    }
    EXPECT_NEAR(level_Pa[1] / level_Pa[0], 0.5, 0.01);
}

TEST(FieldsInTurn, KeepToTheCapInEveryField)
{
    HologramOptions options = turnOptions(std::make_shared<FakeLog>());
    options.cycle = 3;
    options.cycleSteps = 1;
    options.even = 0;
    options.maxPressure = 800.0;
    HologramPipeline pipeline(options);
    const auto result = settled(pipeline, pipeline.process(squareSnapshot()));
    ASSERT_EQ(result->sequence.fields.size(), 6u);
    EXPECT_LT(result->report().capFactor, 1.0);
    for (const Eigen::VectorXcf& q : result->sequence.fields)
        EXPECT_LE(pressures(result->points.positions, q).maxCoeff(), 800.0 * 1.0001);
    EXPECT_GT(result->achieved_Pa.maxCoeff(), 600.0f);
}

TEST(FieldsInTurn, TheMonitorsFindingsComeWithTheResult)
{
    HologramOptions options = turnOptions(std::make_shared<FakeLog>());
    options.monitorInterval = 0.001;
    options.cycle = 4;
    options.even = 0;
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    std::shared_ptr<const HologramResult> result;
    eventually(
        [&]
        {
            result = thread.latestResult();
            return result && result->sequence.changes() && result->monitored &&
                   result->report().surface.coefficientOfVariation < 0.8;
        },
        800.0); // the monitor runs only when nobody else wants to
    ASSERT_TRUE(result && result->monitored);
    const haptics::FieldMonitor::Result& found = *result->monitored;
    EXPECT_EQ(found.error, "");
    EXPECT_GT(found.certificate.bound, 0.0);
    EXPECT_GT(found.certificate.gapOfField(), 0.0);
    const haptics::SurfaceStatistics& surface = result->report().surface;
    EXPECT_GT(surface.samples, 400); // 40 mm square, a fifth of a wavelength
    EXPECT_NEAR(surface.coefficientOfVariation,
                variation(placesOnSquare(), result->sequence.fields),
                0.15); // the places leave the margin out
}

TEST(FieldsInTurn, OptionsOutOfRangeAreNamed)
{
    HologramOptions options = fakeOptions(std::make_shared<FakeLog>());
    std::string error;
    options.cycle = 0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "cycle is 0; it must be within 1 .. 64");
    options.cycle = 1;
    options.cycleSteps = 17;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "cycleSteps is 17; it must be within 0 .. 16");
    options.cycleSteps = 0;
    options.even = -1;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "even is -1; it must be within 0 .. 1000");
    options.even = 0;
    options.subsets = 65;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "subsets is 65; it must be within 1 .. 64");
    options.subsets = 1;
    options.monitorInterval = -1.0;
    EXPECT_FALSE(options.isValid(&error));
}
