#include "haptics/probe/FingertipForce.h"
#include "tests/engine-bridge/pipeline/AtRest.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// The most that a fingertip gets at any point of \a result.
double most_N(const HologramResult& result)
{
    double most = 0.0;
    for (int l = 0; l < result.points.size(); ++l)
        most = std::max(most,
                        haptics::fingertipForce(result.points.positions.col(l),
                                                result.points.normals.col(l),
                                                *result.array,
                                                result.medium,
                                                result.sequence,
                                                false)
                            .force_N);
    return most;
}

} // namespace

TEST(FingertipStage, OfAFieldAtRestAllPointsAreTried)
{
    for (const bool isEvened : {false, true})
    {
        AtRest scene(
            [&](HologramOptions& options)
            {
                options.feelThreshold = 0.25;
                if (!isEvened) options.restAfter_s = std::numeric_limits<double>::infinity();
            });
        const auto first = scene.show(squareSnapshot());
        EXPECT_GT(first->fingertip.force_N, 0.0);
        EXPECT_LE(first->fingertip.force_N, most_N(*first));
        scene.rest(10.0);
        EXPECT_EQ(scene.newest->sequence.evened, isEvened);
        EXPECT_EQ(scene.newest->fingertip.force_N, most_N(*scene.newest));
        EXPECT_EQ(scene.newest->fingertip.threshold_N, 0.25);
        EXPECT_EQ(scene.pipeline->rest_s(), HologramPipeline::kAttend_s) << "nothing is left";
    }
}

TEST(FingertipStage, OfAFieldThatMovesItFollows)
{
    AtRest scene;
    for (int frame = 0; frame < 60; ++frame)
    {
        scene.show(squareSnapshot(2e-4 * frame));
        scene.clock.pass(0.016);
        if (frame < 40) continue; // by then each point has had its turn
        EXPECT_GT(scene.newest->fingertip.force_N, 0.7 * most_N(*scene.newest)) << frame;
        EXPECT_LE(scene.newest->fingertip.force_N, most_N(*scene.newest)) << frame;
    }
}

TEST(FingertipStage, OfSilenceItIsNothing)
{
    AtRest scene;
    scene.show(squareSnapshot());
    EXPECT_GT(scene.newest->fingertip.force_N, 0.0);
    scene.show(SceneSnapshot());
    EXPECT_EQ(scene.newest->fingertip.force_N, 0.0);
    scene.rest(1.0);
    EXPECT_EQ(scene.newest->fingertip.force_N, 0.0);
}
