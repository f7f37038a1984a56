// Fields at rest beside rigid plates and bodies are corrected for their full waves; figures and
// caps know them. The truth is that of cells a twelfth of a wavelength wide, where the kit takes an
// eighth.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/ScatteredField.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/solvers/production/LouderPhases.h"
#include "tests/engine-bridge/pipeline/AtRest.h"
#include "tests/engine-bridge/pipeline/Plate.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

using Result = std::shared_ptr<const HologramResult>;

haptics::FlatFace smallPlate(double y_m = -0.03, double accuracy_mm = 0.2)
{
    haptics::FlatFace plate = plateAt(y_m, accuracy_mm);
    plate.rectangle.size_m = {0.09, 0.07};
    return plate;
}

SceneSnapshot pointsBeside(const haptics::FlatFace& plate, double x_m = 0.0)
{
    SceneSnapshot snapshot = pointsSnapshot(x_m);
    snapshot.reflectors = {plate};
    return snapshot;
}

/// |p| of what is played, beside a rigid plate, Pa.
Eigen::VectorXd besidePlate(const HologramResult& result, const haptics::FlatFace& plate)
{
    haptics::TransducerArray array = *result.array;
    array.reflectors.clear();
    haptics::ScatteredField truth(
        {std::make_shared<haptics::ThinScreen>(*haptics::plateOf(plate.rectangle),
                                               result.medium.wavelength(array.frequency_Hz),
                                               12.0)},
        array,
        result.medium);
    truth.setDrive(result.played());
    return (truth.free_Pa(result.points.positions) + truth.scattered_Pa(result.points.positions))
        .cwiseAbs();
}

double rmsBeside(const HologramResult& result, const haptics::FlatFace& plate)
{
    const Eigen::ArrayXd y = besidePlate(result, plate).array();
    return std::sqrt((y / y.mean() - 1.0).square().mean()); // all targets are equal
}

bool isTold(const HologramResult& result, const std::string& text)
{
    return std::any_of(result.told.begin(),
                       result.told.end(),
                       [&](const base::Message& message) {
                           return message.isActive && message.text.find(text) != std::string::npos;
                       });
}

std::string said(const HologramResult& result)
{
    std::string all;
    for (const base::Message& message : result.told)
        all += (message.isActive ? "\n" : "\nended: ") + message.text;
    return all;
}

/// A scene with its own walk to a louder field kept out: targets that the array reaches.
struct BesideAPlate : AtRest
{
    using AtRest::AtRest;

    static SceneSnapshot inPa(const haptics::FlatFace& plate, double x_m = 0.0)
    {
        SceneSnapshot snapshot = pointsBeside(plate, x_m);
        snapshot.objects.front().properties.pressureInPa = true;
        snapshot.objects.front().properties.pressure = 300.0;
        return snapshot;
    }

    /// Attends until the newest result has the text, for at most a minute of real time.
    bool restUntil(const std::string& text, Results* all = nullptr)
    {
        for (int turn = 0; turn < 30000; ++turn)
        {
            const Results some = rest(0.02);
            if (all) all->insert(all->end(), some.begin(), some.end());
            if (newest && isTold(*newest, text)) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        return false;
    }
};

constexpr const char* kSolved = "is solved for the full waves";
constexpr const char* kBegun = "is being solved for the full waves of 1 thing (";

} // namespace

TEST(ScatteringPipeline, PointsAtRestAreSolvedForTheFullWaves)
{
    BesideAPlate scene;
    const haptics::FlatFace plate = smallPlate();
    const Result first = scene.show(BesideAPlate::inPa(plate));
    const double before = rmsBeside(*first, plate);
    EXPECT_GT(before, 0.01);
    AtRest::Results all;
    ASSERT_TRUE(scene.restUntil(kBegun));
    ASSERT_TRUE(scene.restUntil(kSolved, &all));
    const AtRest::Results more = scene.rest(1.0);
    all.insert(all.end(), more.begin(), more.end());
    ASSERT_FALSE(all.empty());
    for (const Result& result : all)
    {
        EXPECT_LE(result->report().meanPhaseStep_rad, haptics::PhaseWalk::kMostTurn_rad + 1e-6);
        EXPECT_TRUE(result->playing);
    }
    const Result& last = all.back();
    const Eigen::VectorXd truth = besidePlate(*last, plate);
    EXPECT_LT(rmsBeside(*last, plate), 0.1 * before);
    EXPECT_LT(rmsBeside(*last, plate), 4e-3);
    EXPECT_LT((last->achieved_Pa.cast<double>() - truth).norm(), 4e-3 * truth.norm());
    EXPECT_NEAR(last->report().rms, rmsBeside(*last, plate), 2e-3);
    EXPECT_NEAR(last->report().level_Pa, 300.0, 3.0);
    EXPECT_TRUE(scene.rest(1.0).empty()) << "nothing is left";

    const Result moved = scene.show(BesideAPlate::inPa(plate, 0.003));
    EXPECT_EQ(moved->sequence.outside, nullptr) << "what moves is solved with images";
    EXPECT_FALSE(isTold(*moved, kSolved));
    EXPECT_GT(rmsBeside(*moved, plate), 0.005);
    ASSERT_TRUE(scene.restUntil(kSolved)) << "it rests again";
    scene.rest(1.0);
    EXPECT_LT(rmsBeside(*scene.newest, plate), 4e-3);
}

TEST(ScatteringPipeline, LouderComesFirstAndTheLevelIsThatOfTheFullWaves)
{
    BesideAPlate scene;
    const haptics::FlatFace plate = smallPlate();
    scene.show(pointsBeside(plate));
    ASSERT_TRUE(scene.restUntil(kSolved));
    scene.rest(1.0);
    const Eigen::VectorXd truth = besidePlate(*scene.newest, plate);
    EXPECT_LT(rmsBeside(*scene.newest, plate), 4e-3);
    EXPECT_NEAR(scene.newest->report().level_Pa, truth.mean(), 4e-3 * truth.mean());
}

// A ball has no images; the rest of its field is known from its own mesh, more finely divided.
TEST(ScatteringPipeline, ABodyIsKnownAtRest)
{
    BesideAPlate scene;
    SceneSnapshot snapshot = BesideAPlate::inPa(smallPlate());
    snapshot.reflectors.clear();
    haptics::ReflectingBody ball;
    ball.mesh = haptics::flatFacesOf(*sphere(0.008, 10)).body; // without its seam
    ASSERT_NE(ball.mesh, nullptr);
    ball.pose.translation() = Eigen::Vector3d(0.005, -0.025, 0.0);
    snapshot.bodies = {ball};
    const auto truthOf = [&](const HologramResult& result)
    {
        haptics::TriangleMesh mesh = *ball.mesh;
        mesh.vertices = ball.pose * mesh.vertices;
        const double wavelength_m = result.medium.wavelength(result.array->frequency_Hz);
        haptics::ScatteredField truth(
            {std::make_shared<haptics::RigidBody>(
                haptics::RigidBody::divided(mesh, wavelength_m, 8.0), wavelength_m)},
            *result.array,
            result.medium);
        truth.setDrive(result.played());
        const Eigen::Matrix3Xd& places = result.points.positions;
        return Eigen::ArrayXd((truth.free_Pa(places) + truth.scattered_Pa(places)).cwiseAbs());
    };
    const auto rms = [&](const HologramResult& result)
    {
        const Eigen::ArrayXd y = truthOf(result);
        return std::sqrt((y / y.mean() - 1.0).square().mean());
    };
    const Result first = scene.show(snapshot);
    EXPECT_GT(rms(*first), 0.01);
    ASSERT_TRUE(scene.restUntil(kSolved)) << said(*scene.newest);
    scene.rest(1.0);
    EXPECT_LT(rms(*scene.newest), 0.2 * rms(*first));
    EXPECT_LT(rms(*scene.newest), 4e-3);
    EXPECT_LT((scene.newest->achieved_Pa.cast<double>().array() / truthOf(*scene.newest) - 1.0)
                  .abs()
                  .maxCoeff(),
              0.015);

    snapshot.bodies.assign(8, ball);
    for (haptics::ReflectingBody& one : snapshot.bodies)
        one.mesh = haptics::flatFacesOf(*sphere(0.1, 30)).body;
    scene.show(snapshot);
    EXPECT_TRUE(scene.restUntil("it would take 6")) << "gigabytes";

    snapshot.bodies = {ball};
    snapshot.bodies[0].pose.translation().y() = 0.0;
    scene.show(snapshot);
    EXPECT_TRUE(scene.restUntil("is inside the body")) << "refused by name";
    EXPECT_EQ(scene.newest->sequence.outside, nullptr);
}

// The cap holds in truth, under each other limit; images alone would leave points above it.
TEST(ScatteringPipeline, CapsHoldWithTheFullWaves)
{
    const haptics::FlatFace plate = smallPlate();
    const std::vector<std::function<void(HologramOptions&)>> limits = {
        [](HologramOptions&) {},
        [](HologramOptions& options) { options.maxAmplitude = 0.7; },
        [](HologramOptions& options) { options.earLimit = 150.0; },
        [](HologramOptions& options) { options.deviceUri = "sim:?max-pressure=290"; }};
    for (std::size_t k = 0; k < limits.size(); ++k)
    {
        BesideAPlate scene(
            [&](HologramOptions& options)
            {
                options.maxPressure = 290.0;
                options.deviceFactory = {}; // the fake one has no amplitude cap
                limits[k](options);
            });
        scene.show(k % 2 > 0 ? BesideAPlate::inPa(plate) : pointsBeside(plate));
        ASSERT_TRUE(scene.restUntil(kSolved)) << k << said(*scene.newest);
        scene.rest(1.0);
        const Result& last = scene.newest;
        EXPECT_NE(last->sequence.outside, nullptr);
        EXPECT_LT(last->report().capFactor, 1.0);
        const Eigen::VectorXd truth = besidePlate(*last, plate);
        EXPECT_LE(truth.maxCoeff(), 290.0) << k;
        EXPECT_GT(truth.maxCoeff(), 220.0) << k;
        EXPECT_LT((last->achieved_Pa.cast<double>() - truth).norm(), 5e-3 * truth.norm());
    }
}

TEST(ScatteringPipeline, OtherScenesAreLeftAlone)
{
    const auto isAsked =
        [](const SceneSnapshot& snapshot, const std::function<void(HologramOptions&)>& change = {})
    {
        AtRest scene(change);
        scene.show(snapshot);
        scene.rest(2.0);
        return isTold(*scene.newest, "full waves");
    };
    ASSERT_TRUE(isAsked(BesideAPlate::inPa(smallPlate()))) << "it could be";
    EXPECT_FALSE(isAsked(pointsSnapshot())) << "nothing reflects";
    EXPECT_FALSE(isAsked(BesideAPlate::inPa(smallPlate(-0.03, 5.0)))) << "its place is uncertain";
    haptics::FlatFace soft = smallPlate();
    soft.rectangle.reflection = 0.7;
    EXPECT_FALSE(isAsked(BesideAPlate::inPa(soft))) << "it isn't rigid";
    haptics::FlatFace endless = smallPlate();
    endless.rectangle.size_m.setConstant(haptics::Reflector::kEndless);
    EXPECT_FALSE(isAsked(BesideAPlate::inPa(endless))) << "its image is exact";
    const SceneSnapshot beside = BesideAPlate::inPa(smallPlate());
    EXPECT_FALSE(isAsked(beside, [](HologramOptions& options) { options.even = 0; }));
    EXPECT_FALSE(isAsked(beside, [](HologramOptions& options) { options.cycle = 2; }));
    EXPECT_FALSE(isAsked(beside, [](HologramOptions& options) { options.restAfter_s = 0.0; }));
}

TEST(ScatteringPipeline, WhatMovesMeanwhileIsNotCorrectedForTheOldPlace)
{
    BesideAPlate scene;
    scene.show(BesideAPlate::inPa(smallPlate()));
    ASSERT_TRUE(scene.restUntil(kBegun));
    const Result moved = scene.show(BesideAPlate::inPa(smallPlate(-0.04)));
    EXPECT_FALSE(isTold(*moved, "full waves"));
    ASSERT_TRUE(scene.restUntil(kSolved));
    scene.rest(1.0);
    EXPECT_LT(rmsBeside(*scene.newest, smallPlate(-0.04)), 4e-3);

    SceneSnapshot empty = BesideAPlate::inPa(smallPlate(-0.04));
    empty.objects.clear();
    const Result gone = scene.show(empty);
    EXPECT_EQ(gone->points.size(), 0);
    EXPECT_EQ(gone->sequence.outside, nullptr);
    EXPECT_FALSE(isTold(*gone, "full waves"));
}

TEST(ScatteringPipeline, SilenceAndTheEndComeAtOnceWhileItSolves)
{
    haptics::FlatFace large = smallPlate();
    large.rectangle.size_m = {0.25, 0.2};
    const auto scene = std::make_unique<BesideAPlate>();
    scene->show(BesideAPlate::inPa(large));
    ASSERT_TRUE(scene->restUntil(kBegun));
    const std::uint64_t sends = scene->log->sends;
    scene->pipeline->silence();
    EXPECT_FALSE(scene->pipeline->device().isPlaying());
    EXPECT_TRUE(scene->rest(1.0).empty());
    EXPECT_EQ(scene->log->sends, sends) << "a silent array isn't walked anywhere";
}
