#include "tests/samples/installations/Run.h"

#include <gtest/gtest.h>

TEST(Water, PointsOfWaterMoveWithIt)
{
    const OwnFolder out("water");
    const Visit run = visit("water", "--frames 480 --set render=object --rain 0.4", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    const nlohmann::json& scene = run.report.at("scene");
    EXPECT_GT(scene.at("fieldsCompared"), 50);
    EXPECT_GT(scene.at("dips"), 0);
    EXPECT_GT(scene.at("pointsOffRest_mm"), 2.0);
    EXPECT_LT(scene.at("pointsOffSurface_mm"), 0.2);
    EXPECT_GT(run.report.at("largestForce_mN"), 0.0);
}
