#include "haptics/array/Medium.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/points/Workspace.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

const TransducerArray& prism()
{
    static const TransducerArray array = TransducerArray::load("octagon");
    return array;
}

ReachedOutlines reachedAt(const Eigen::Vector3d& centre)
{
    const Workspace workspace(
        prism(), Medium().wavelength(prism().frequency_Hz), SelectorOptions());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(centre);
    return reachedOutlines(test::box({0.04, 0.04, 0.04}), pose, 300.0, workspace);
}

} // namespace

TEST(ReachedOutlines, AreInTheArraysFrameWithTheirTarget)
{
    const Eigen::Vector3d centre(0.01, 0.02, -0.01);
    const ReachedOutlines reached = reachedAt(centre);
    ASSERT_EQ(reached.inside.size(), 12U); // a cube's edges
    EXPECT_EQ(reached.outside, 0);
    double length_m = 0.0;
    for (const Outline& outline : reached.inside)
    {
        EXPECT_EQ(outline.target, 300.0);
        for (const auto& vertex : outline.vertices.colwise())
            EXPECT_NEAR((vertex - centre).cwiseAbs().maxCoeff(), 0.02, 1e-12);
        length_m += outline.length_m();
    }
    EXPECT_NEAR(length_m, 12 * 0.04, 1e-9);
    const double half_m = 0.5 * Medium().wavelength(prism().frequency_Hz);
    EXPECT_NEAR(reached.points, length_m / half_m, 24.0);
}

TEST(ReachedOutlines, AreLeftOutWhereAPartIsOutside)
{
    const ReachedOutlines far = reachedAt({0.0, 0.0, 5.0});
    EXPECT_TRUE(far.inside.empty());
    EXPECT_EQ(far.outside, 12);
    EXPECT_EQ(far.points, 0.0);
    int in = 0;
    for (double y = 0.0; y > -0.3 && in == 0; y -= 0.005)
    {
        const ReachedOutlines some = reachedAt({0.0, 0.0, y});
        EXPECT_EQ(static_cast<int>(some.inside.size()) + some.outside, 12);
        if (some.outside > 0 && !some.inside.empty()) in = static_cast<int>(some.inside.size());
    }
    EXPECT_GT(in, 0); // a place where the cube is reached in part
}
