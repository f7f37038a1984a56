// Frames in which nothing changes that the field depends on, or next to nothing.
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using haptics::StopReason;

// What moves out of reach, or changes what the field doesn't depend on, costs no field: what is
// played goes on, with its figures.
TEST(SameField, SendsNothingAgainWhereTheFieldIsTheSame)
{
    for (const double cap_Pa : {0.0, 1e5, 300.0})
    {
        SCOPED_TRACE(cap_Pa);
        const auto log = std::make_shared<FakeLog>();
        HologramOptions options = fakeOptions(log);
        options.solverFactory = nullptr;
        options.maxPressure = cap_Pa;
        HologramPipeline pipeline(options);
        SceneSnapshot snapshot = squareSnapshot();
        snapshot.objects[0].topologyId = 1;
        snapshot.objects.push_back(snapshot.objects[0]);
        snapshot.objects[1].id = 2;
        snapshot.objects[1].meshId = 2;
        snapshot.objects[1].path = "Scene/Far";
        snapshot.objects[1].pose.translation() << 3.0, 0.0, 0.0;
        const auto first = pipeline.process(snapshot);
        ASSERT_EQ(log->sends, 1);
        const auto expectSame = [&](const char* what)
        {
            ++snapshot.frame;
            const auto result = pipeline.process(snapshot);
            EXPECT_EQ(log->sends, 1) << what;
            EXPECT_NE(result, first) << what;
            EXPECT_EQ(result->frame, snapshot.frame) << what;
            EXPECT_EQ(result->report().stop, StopReason::SKIPPED) << what;
            EXPECT_EQ(result->played(), first->played()) << what;
            EXPECT_EQ(result->achieved_Pa, first->achieved_Pa) << what;
            EXPECT_EQ(result->report().level_Pa, first->report().level_Pa) << what;
            EXPECT_EQ(result->report().capFactor, first->report().capFactor) << what;
            EXPECT_EQ(result->report().driveChange, 0.0) << what;
            EXPECT_TRUE(result->playing) << what;
        };
        snapshot.objects[1].pose.translation().x() = 3.1;
        expectSame("far away");
        snapshot.objects[0].properties.priority = 3;
        expectSame("priority");
        snapshot.objects[0].meshId = 7;
        expectSame("the same vertices");
        snapshot.objects.pop_back();
        expectSame("far away, gone");
        snapshot.objects[0].pose.translation().x() = 1e-3;
        const auto moved = pipeline.process(snapshot);
        EXPECT_EQ(log->sends, 2);
        EXPECT_NE(moved->played(), first->played());
        snapshot.objects[0].properties.priority = 4;
        pipeline.process(snapshot);
        EXPECT_EQ(log->sends, 2);
        // After other options everything is looked at again.
        options.maxPressure = 200.0;
        pipeline.reconfigure(options);
        const auto capped = pipeline.process(snapshot);
        EXPECT_EQ(log->sends, 3);
        EXPECT_LE(capped->achieved_Pa.maxCoeff(), 200.0f);
        // And after a silence it is played again.
        pipeline.silence();
        snapshot.objects[0].properties.priority = 5;
        EXPECT_TRUE(pipeline.process(snapshot)->playing);
        EXPECT_EQ(log->sends, 4);
    }
}

// The points stay where they are, so that the field goes on from the last one.
TEST(SameField, ATenthOfAKelvinIsOneWarmUpdate)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.solverFactory = nullptr;
    HologramPipeline pipeline(options);
    const SceneSnapshot snapshot = squareSnapshot();
    const auto first = pipeline.process(snapshot);
    options.medium.temperature_C += 0.1;
    pipeline.reconfigure(options);
    const auto warmer = pipeline.process(snapshot);
    EXPECT_EQ(warmer->points.positions, first->points.positions);
    EXPECT_EQ(warmer->points.identity, first->points.identity);
    EXPECT_LT(warmer->report().iterations, 10) << "a start from nothing takes more rounds";
    EXPECT_LT(warmer->report().driveChange, 0.1) << "of two unrelated fields it is about 1";
    EXPECT_LT(warmer->report().rms, 2e-3);
    // Ten kelvins are another wavelength.
    options.medium.temperature_C += 10.0;
    pipeline.reconfigure(options);
    EXPECT_NE(pipeline.process(snapshot)->points.positions, first->points.positions);
}

// A hand far from all paths shadows nothing, and costs no other field.
TEST(SameField, AFarHandCastsNoShadow)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.solverFactory = nullptr;
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.around.shadows = true;
    HandCapsule bone;
    bone.shape = {Eigen::Vector3d(3.0, 0.0, 0.0), Eigen::Vector3d(3.0, 0.05, 0.0), 0.01};
    snapshot.around.hands = {bone};
    const auto first = pipeline.process(snapshot);
    EXPECT_EQ(first->array->gain.size(), 0);
    snapshot.around.hands[0].shape.a.x() = snapshot.around.hands[0].shape.b.x() = 2.0;
    EXPECT_EQ(pipeline.process(snapshot)->report().stop, StopReason::SKIPPED);
    EXPECT_EQ(log->sends, 1);
    snapshot.around.hands[0].shape = {
        Eigen::Vector3d(0.1, 0.0, 0.0), Eigen::Vector3d(0.1, 0.05, 0.0), 0.01};
    const auto shadowed = pipeline.process(snapshot);
    EXPECT_EQ(shadowed->array->gain.size(), 3984);
    EXPECT_LT(shadowed->array->gain.minCoeff(), 0.9);
    EXPECT_EQ(log->sends, 2);
}
