// Reflectors of a scene while it plays: followed, told, and capped; against fields in double.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/pipeline/AtRest.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/engine-bridge/pipeline/Plate.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

SceneSnapshot above(std::vector<haptics::FlatFace> faces)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.reflectors = std::move(faces);
    return snapshot;
}

HologramOptions octagon()
{
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    return options;
}

/// |p| of what is played with \a reflectors, in double precision.
Eigen::VectorXd inTruth(const HologramResult& result,
                        const std::vector<haptics::Reflector>& reflectors)
{
    haptics::TransducerArray array = *result.array;
    array.reflectors = reflectors;
    return (haptics::referencePropagationMatrix(result.points.positions, array, result.medium) *
            result.played().cast<std::complex<double>>())
        .cwiseAbs();
}

double rmsOf(const Eigen::VectorXd& y, const Eigen::VectorXd& targets)
{
    const double s = y.dot(targets) / targets.squaredNorm();
    return std::sqrt((y.array() / (s * targets.array()) - 1.0).square().mean());
}

/// Number of messages with \a text that hold now.
int told(const HologramResult& result, const std::string& text)
{
    return static_cast<int>(std::count_if(result.told.begin(),
                                          result.told.end(),
                                          [&](const base::Message& message) {
                                              return message.isActive &&
                                                     message.text.find(text) != std::string::npos;
                                          }));
}

} // namespace

TEST(ReflectorPipeline, AMovingOneIsFollowed)
{
    HologramPipeline pipeline(octagon());
    for (const double y_m : {-0.05, -0.06, -0.0601, -0.08})
    {
        const auto result = pipeline.process(above({plateAt(y_m)}));
        ASSERT_GT(result->points.size(), 0);
        ASSERT_EQ(result->array->reflectors.size(), 1u);
        EXPECT_EQ(result->array->reflectors[0].position.y(), y_m);
        const Eigen::VectorXd y = inTruth(*result, {plateAt(y_m).rectangle});
        EXPECT_LT(rmsOf(y, result->points.targets), 5e-3) << y_m;
        EXPECT_LT((result->achieved_Pa.cast<double>() - y).norm(), 1e-3 * y.norm()) << y_m;
        EXPECT_GT(rmsOf(inTruth(*result, {}), result->points.targets), 0.02)
            << "it isn't the free field";
        EXPECT_EQ(result->report().reflectorCount, 1);
        EXPECT_TRUE(result->messages.empty());
    }
    const std::uint64_t solves = pipeline.counters().solves;
    pipeline.process(above({plateAt(-0.08 + 1e-8)}));
    EXPECT_EQ(pipeline.counters().solves, solves) << "within the tolerance nothing has moved";
}

TEST(ReflectorPipeline, WithoutOneTheFieldIsFreeToTheBit)
{
    HologramPipeline free(octagon());
    HologramPipeline silentOne(octagon());
    haptics::FlatFace none = plateAt(-0.06);
    none.rectangle.reflection = 0.0;
    const auto expected = free.process(above({}));
    EXPECT_EQ(silentOne.process(above({none}))->played(), expected->played());
    EXPECT_EQ(expected->report().reflectorCount, 0);
    HologramPipeline other(octagon());
    other.process(above({plateAt(-0.06)}));
    const auto after = other.process(above({}));
    EXPECT_TRUE(after->array->reflectors.empty()) << "it has gone";
    EXPECT_LT(rmsOf(inTruth(*after, {}), after->points.targets), 5e-3);
}

TEST(ReflectorPipeline, OneWhosePlaceIsUncertainIsToldAndNotCorrected)
{
    HologramPipeline free(octagon());
    HologramPipeline pipeline(octagon());
    const auto expected = free.process(above({}));
    const auto result = pipeline.process(above({plateAt(-0.05, 5.0)}));
    EXPECT_EQ(result->played(), expected->played());
    EXPECT_EQ(told(*result, "aren't corrected for reflector 'plate': its accuracy is 5 mm"), 1);
    const Eigen::VectorXd y = inTruth(*result, {plateAt(-0.05).rectangle});
    EXPECT_LT((result->achieved_Pa.cast<double>() - y).norm(), 1e-3 * y.norm())
        << "figures know it";
    EXPECT_NEAR(result->report().rms, rmsOf(y, result->points.targets), 1e-3);
    EXPECT_GT(result->report().rms, 0.02);
    const auto better = pipeline.process(above({plateAt(-0.05, 0.2)}));
    EXPECT_EQ(told(*better, "aren't corrected"), 0);
    EXPECT_LT(better->report().rms, 5e-3);
}

// The cap holds with the reflectors and, as they may be gone, without.
TEST(ReflectorPipeline, TheCapIsKeptWhereverTheyAre)
{
    HologramOptions options = octagon();
    options.maxPressure = 300.0;
    for (const double accuracy_mm : {0.2, 5.0})
    {
        HologramPipeline pipeline(options);
        for (const double y_m : {-0.04, -0.05, -0.063, -0.1})
        {
            const auto result = pipeline.process(above({plateAt(y_m, accuracy_mm)}));
            EXPECT_EQ(result->maxPressure_Pa, 300.0);
            EXPECT_LE(inTruth(*result, {plateAt(y_m).rectangle}).maxCoeff(), 300.0) << y_m;
            EXPECT_LE(inTruth(*result, {}).maxCoeff(), 300.0) << y_m;
            EXPECT_GT(result->report().level_Pa, 100.0) << y_m;
        }
    }
}

// A solver that isn't asked again before the test says so: what still plays is lowered first.
TEST(ReflectorPipeline, WhatPlaysIsLoweredBeforeTheNextFieldIsSolved)
{
    auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    double free_Pa = 0.0, with_Pa = 0.0;
    haptics::FlatFace loudest;
    {
        HologramPipeline loud(options);
        const auto result = loud.process(above({}));
        free_Pa = inTruth(*result, {}).maxCoeff();
        for (double y_m = -0.03; y_m > -0.05; y_m -= 0.001)
        {
            const double here_Pa = inTruth(*result, {plateAt(y_m).rectangle}).maxCoeff();
            if (here_Pa > with_Pa) loudest = plateAt(y_m);
            with_Pa = std::max(with_Pa, here_Pa);
        }
    }
    ASSERT_GT(with_Pa, 1.1 * free_Pa);
    options.maxPressure = 1.02 * free_Pa;
    HologramPipeline pipeline(options);
    EXPECT_EQ(pipeline.process(above({}))->report().capFactor, 1.0);
    const int sent = log->sends;
    log->throwInSolve = true; // no new field comes
    pipeline.process(above({loudest}));
    EXPECT_GT(log->sends, sent) << "it is sent anew, lower, before the solver is asked";
}

TEST(ReflectorPipeline, PointsBesideOneAreLeftOutAndNamed)
{
    HologramPipeline pipeline(octagon());
    const int all = pipeline.process(above({}))->points.size();
    haptics::FlatFace beside = plateAt(0.0);
    beside.rectangle.position.x() = 0.11; // its edge is 10 mm right of the square's middle
    const auto result = pipeline.process(above({beside}));
    EXPECT_GT(result->points.size(), 0);
    EXPECT_LT(result->points.size(), all);
    for (int l = 0; l < result->points.size(); ++l)
        EXPECT_GE(beside.rectangle.distanceTo(result->points.positions.col(l)),
                  pipeline.options().wavelength_m());
    EXPECT_EQ(told(*result, "points nearer than a wavelength to reflector 'plate' are left out"),
              1);
    EXPECT_EQ(told(*pipeline.process(above({plateAt(-0.06)})), "left out"), 0);
}

TEST(ReflectorPipeline, TooManyAndBadOnesAreNamed)
{
    std::vector<haptics::FlatFace> faces;
    for (int i = 0; i < 9; ++i)
    {
        faces.push_back(plateAt(-0.06));
        faces.back().rectangle.name = "plate " + std::to_string(i);
        faces.back().rectangle.position.x() = 0.3 * i;
    }
    HologramPipeline pipeline(octagon());
    const auto result = pipeline.process(above(faces));
    EXPECT_EQ(result->array->reflectors.size(), haptics::kMostReflectors);
    EXPECT_EQ(told(*result, "reflector 'plate 8' is left out"), 1);
    haptics::FlatFace bad = plateAt(-0.06);
    bad.rectangle.position.y() = std::nan("");
    const auto second = pipeline.process(above({bad}));
    EXPECT_TRUE(second->array->reflectors.empty());
    EXPECT_EQ(told(*second, "reflector 'plate': its position is not finite"), 1);
    EXPECT_TRUE(second->playing);
}

TEST(ReflectorPipeline, ABodyCountsByTheFaceThatTheArraySees)
{
    HologramOptions options;
    options.array = haptics::TransducerArray::singleBoard();
    haptics::FlatFace top = plateAt(0.0), bottom = top, side = top;
    top.isOfBody = bottom.isOfBody = side.isOfBody = true;
    top.rectangle.position = {0.0, 0.0, 0.3};
    top.rectangle.normal = -Eigen::Vector3d::UnitZ();
    bottom.rectangle.position = {0.0, 0.0, 0.4};
    bottom.rectangle.normal = Eigen::Vector3d::UnitZ();
    side.rectangle.position = {0.0, 0.0, 0.35}; // through the middle of the board
    const SceneReflectors beside = reflectorsBeside(options.array, {top, bottom, side});
    ASSERT_EQ(beside.all.size(), 1u);
    EXPECT_EQ(beside.all[0], top.rectangle);
    ASSERT_EQ(beside.problems.size(), 1u);
    EXPECT_NE(beside.problems[0].find("make it a sheet"), std::string::npos);
}

TEST(ReflectorPipeline, TheArraysOwnComeFirst)
{
    HologramOptions options = octagon();
    options.array.reflectors = {plateAt(-0.1).rectangle};
    HologramPipeline pipeline(options);
    EXPECT_EQ(pipeline.process(above({}))->array->reflectors.size(), 1u);
    const auto both = pipeline.process(above({plateAt(-0.06)}));
    ASSERT_EQ(both->array->reflectors.size(), 2u);
    EXPECT_EQ(both->array->reflectors[0], options.array.reflectors[0]);
    HologramOptions later = options; // as settings change while it plays
    later.solverOptions.loudness = 1.1;
    pipeline.reconfigure(later);
    EXPECT_EQ(pipeline.process(above({plateAt(-0.06)}))->array->reflectors.size(), 2u);
    EXPECT_EQ(pipeline.process(above({}))->array->reflectors.size(), 1u);
}

// A screen before a board sends the sound back to the operator.
TEST(ReflectorPipeline, EarsHearIt)
{
    HologramOptions options;
    options.array = haptics::TransducerArray::singleBoard();
    haptics::FlatFace screen = plateAt(0.0, 5.0); // the same drive with it and without
    screen.rectangle.position = {0.0, 0.0, 0.25};
    screen.rectangle.normal = Eigen::Vector3d::UnitZ();
    screen.rectangle.size_m = {0.5, 0.3};
    SceneSnapshot snapshot = above({});
    snapshot.objects[0].pose.translation() = Eigen::Vector3d(0.0, 0.0, 0.15);
    options.earPoints = Eigen::Vector3d(0.12, 0.0, 0.05); // beside the beam, in what comes back
    HologramPipeline pipeline(options);
    const double free_dB = pipeline.process(snapshot)->exposure.level_dB;
    ASSERT_GT(free_dB, 100.0);
    pipeline.process(SceneSnapshot());
    HologramPipeline other(options);
    snapshot.reflectors = {screen};
    EXPECT_GT(other.process(snapshot)->exposure.level_dB, free_dB + 1.0);
    options.earLimit = free_dB;
    HologramPipeline limited(options);
    const auto result = limited.process(snapshot);
    EXPECT_LE(result->exposure.level_dB, free_dB + 0.01);
    EXPECT_LT(result->report().capFactor, 0.95);
    EXPECT_GT(result->report().level_Pa, 0.0);
}

// The rms to expect, against fields whose plate is off by its accuracy to either side.
TEST(ReflectorPipeline, AtRestItSaysWhatTheAccuracyLeaves)
{
    for (const double accuracy_mm : {0.2, 1.2})
    {
        AtRest scene([](HologramOptions& options) { options.even = 0; });
        EXPECT_EQ(scene.show(above({plateAt(-0.05, accuracy_mm)}))->report().reflectorRms, 0.0);
        scene.rest(1.0);
        const HologramResult& result = *scene.newest;
        const double expected = result.report().reflectorRms;
        EXPECT_GE(expected, result.report().rms);
        for (const double side : {-1.0, 1.0})
        {
            const double y_m = -0.05 + side * 1e-3 * accuracy_mm;
            const double truth =
                rmsOf(inTruth(result, {plateAt(y_m).rectangle}), result.points.targets);
            EXPECT_GT(expected, truth / 1.5) << accuracy_mm << " " << side;
            EXPECT_LT(expected, truth * 1.5) << accuracy_mm << " " << side;
        }
        scene.show(above({plateAt(-0.06, accuracy_mm)}));
        EXPECT_EQ(scene.newest->report().reflectorRms, 0.0) << "another field";
    }
}
