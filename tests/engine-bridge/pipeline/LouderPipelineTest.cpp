#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/solvers/production/LouderPhases.h"
#include "tests/engine-bridge/pipeline/AtRest.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

TEST(LouderPipeline, AFieldAtRestIsWalkedToALouderOne)
{
    AtRest scene;
    const auto first = scene.show(pointsSnapshot());
    ASSERT_TRUE(first->sequence.isHeld());
    const auto results = scene.rest(10.0);
    ASSERT_GT(results.size(), 10u);
    EXPECT_EQ(scene.pipeline->counters().walked, results.size());
    EXPECT_GT(results.back()->report().loudness, 1.005 * first->report().loudness);
    for (const auto& result : results)
    {
        EXPECT_TRUE(result->playing);
        EXPECT_FALSE(result->outline);
        EXPECT_LE(result->report().meanPhaseStep_rad, haptics::PhaseWalk::kMostTurn_rad + 1e-6);
        EXPECT_LE(result->report().levelJump, haptics::PhaseWalk::kMostJump + 1e-3);
        EXPECT_LE(result->report().rms, 2e-3);
        EXPECT_GT(result->report().loudness, 0.9 * first->report().loudness);
    }
    EXPECT_TRUE(scene.rest(1.0).empty()) << "nothing is left to be made";
    // A later update goes on from there.
    const auto moved = scene.show(pointsSnapshot(0.0005));
    EXPECT_GT(moved->report().loudness, 0.99 * results.back()->report().loudness);
}

TEST(LouderPipeline, AMovedSceneIsSolvedAtOnce)
{
    AtRest scene;
    scene.show(pointsSnapshot());
    while (scene.pipeline->counters().walked < 5)
        ASSERT_FALSE(scene.rest(0.02).size() > 50);
    const std::uint64_t walked = scene.pipeline->counters().walked;
    const auto moved = scene.show(pointsSnapshot(0.002));
    EXPECT_LT(moved->report().rms, 2e-3);
    EXPECT_TRUE(scene.rest(0.1).empty()) << "it rests only after a while";
    EXPECT_EQ(scene.pipeline->counters().walked, walked);
}

TEST(LouderPipeline, WhatMayNotBeLouderStays)
{
    AtRest capped([](HologramOptions& options) { options.maxPressure = 500.0; });
    EXPECT_LT(capped.show(pointsSnapshot())->report().capFactor, 1.0);
    EXPECT_TRUE(capped.rest(3.0).empty());
    AtRest inPa;
    SceneSnapshot snapshot = pointsSnapshot();
    snapshot.objects.front().properties.pressureInPa = true;
    snapshot.objects.front().properties.pressure = 300.0;
    EXPECT_NEAR(inPa.show(snapshot)->report().level_Pa, 300.0, 3.0);
    EXPECT_TRUE(inPa.rest(3.0).empty());
    AtRest off([](HologramOptions& options) { options.even = 0; });
    off.show(pointsSnapshot());
    EXPECT_TRUE(off.rest(3.0).empty());
}
