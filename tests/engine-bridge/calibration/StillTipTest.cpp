#include "engine-bridge/calibration/StillTip.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace
{

using Eigen::Vector3d;
using midair::bridge::StillTip;

/// Feeds a tip that is at \a place from \a from_s to \a to_s with a jitter of 3 mm; what is found.
std::vector<Vector3d>
hold(StillTip& still, const Vector3d& place, double from_s, double to_s, bool isSeen = true)
{
    std::vector<Vector3d> found;
    for (int k = 0; from_s + 0.01 * k < to_s; ++k)
    {
        std::optional<StillTip::Sample> sample;
        if (isSeen)
            sample = StillTip::Sample{
                place + 0.003 * Vector3d(std::sin(2.1 * k), std::cos(3.7 * k), std::sin(5.3 * k)),
                Eigen::Isometry3d::Identity()};
        if (const auto one = still.add(from_s + 0.01 * k, sample)) found.push_back(one->tip);
    }
    return found;
}

} // namespace

TEST(StillTip, FindsEachPlaceOnceAsTheMeanOfItsSamples)
{
    StillTip still(0.5);
    const std::vector<Vector3d> first = hold(still, {0.1, 0.2, 0.3}, 0.0, 3.0);
    ASSERT_EQ(first.size(), 1U);
    EXPECT_LT((first[0] - Vector3d(0.1, 0.2, 0.3)).norm(), 0.5e-3);
    const std::vector<Vector3d> second = hold(still, {0.1, 0.25, 0.3}, 3.0, 4.0);
    ASSERT_EQ(second.size(), 1U);
    EXPECT_LT((second[0] - Vector3d(0.1, 0.25, 0.3)).norm(), 0.5e-3);
}

TEST(StillTip, FindsNothingWhereTheTipMovesOrIsLost)
{
    StillTip still(0.5);
    for (int k = 0; k < 300; ++k)
        EXPECT_FALSE(still.add(
            0.01 * k, StillTip::Sample{Vector3d(0.001 * k, 0, 0), Eigen::Isometry3d::Identity()}));
    EXPECT_TRUE(hold(still, {1.0, 0.0, 0.0}, 4.0, 4.4).empty());
    EXPECT_TRUE(hold(still, {1.0, 0.0, 0.0}, 4.4, 4.5, false).empty());
    EXPECT_TRUE(hold(still, {1.0, 0.0, 0.0}, 4.5, 4.9).empty());
}
