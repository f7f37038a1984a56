// samples/hands/star.csv is what its program writes, and does what it says.

#include "engine-bridge/hands/HandSource.h"
#include "tests/star-hand/StarHand.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;

namespace
{

const char* const kFile = MIDAIR_ROOT "/samples/hands/star.csv";

} // namespace

TEST(StarRecording, IsWhatItsProgramWrites)
{
    const bridge::RecordedHandSource recorded(kFile);
    const std::vector<bridge::HandFrame> made = tests::starHand();
    ASSERT_EQ(recorded.frames().size(), made.size());
    EXPECT_LT(std::filesystem::file_size(kFile), 2000000U);
    for (std::size_t i = 0; i < made.size(); ++i)
    {
        const bridge::HandFrame& frame = recorded.frames()[i];
        ASSERT_EQ(frame.hands.size(), 1U);
        EXPECT_NEAR(frame.time_s, made[i].time_s, 1.1e-5);
        for (std::size_t j = 0; j < bridge::HAND_JOINTS; ++j)
        {
            const bridge::HandJoint& is = frame.hands[0].joints[j];
            const bridge::HandJoint& should = made[i].hands[0].joints[j];
            // A last digit apart: the mathematical functions of another system.
            ASSERT_LT((is.position - should.position).cwiseAbs().maxCoeff(), 1.1e-5) << i;
            ASSERT_LT(is.orientation.angularDistance(should.orientation), 1e-3) << i;
            ASSERT_NEAR(is.radius_m, should.radius_m, 1e-9) << i;
        }
    }
}

TEST(StarRecording, RepeatsWithoutAJump)
{
    const bridge::RecordedHandSource recorded(kFile);
    EXPECT_NEAR(recorded.duration_s(), tests::kStarPeriod_s, 1e-3);
    for (std::size_t j = 0; j < bridge::HAND_JOINTS; ++j)
        EXPECT_LT((recorded.frames().front().hands[0].joints[j].position -
                   recorded.frames().back().hands[0].joints[j].position)
                      .norm(),
                  3e-5)
            << j;
}

/// The finger slides at up to 0.1 m/s, 1 to 3 mm deep, and lifts off twice.
TEST(StarRecording, SlidesAndLiftsOff)
{
    double fastest_m_s = 0.0;
    int lifts = 0;
    int slid = 0;
    for (int i = 0; i < static_cast<int>(tests::kStarPeriod_s * tests::kStarRate_Hz); ++i)
    {
        const tests::FingerPlace now = tests::fingerAt(i / tests::kStarRate_Hz);
        const tests::FingerPlace next = tests::fingerAt((i + 1) / tests::kStarRate_Hz);
        if (now.gap_m <= 0.0 && next.gap_m > 0.0) ++lifts;
        if (!now.slides || !next.slides) continue;
        ++slid;
        EXPECT_LE(now.gap_m, -0.99e-3) << i;
        EXPECT_GE(now.gap_m, -3.01e-3) << i;
        fastest_m_s = std::max(
            fastest_m_s, tests::kStarRate_Hz * std::hypot(next.x_m - now.x_m, next.z_m - now.z_m));
    }
    EXPECT_EQ(lifts, 2);
    EXPECT_GT(slid, 150);
    EXPECT_GT(fastest_m_s, 0.05);
    EXPECT_LT(fastest_m_s, 0.1);
}

/// Nothing but the index finger is near the star.
TEST(StarRecording, OnlyTheIndexFingerTouches)
{
    const Eigen::Matrix3Xd front = tests::starFront();
    const double nearest_y = front.row(1).minCoeff();
    for (const bridge::HandFrame& frame : tests::starHand())
        for (const bridge::HandCapsule& capsule : bridge::handCapsules(frame))
        {
            if (bridge::fingerOf(capsule.bone) == bridge::INDEX) continue;
            const double reach =
                std::max(capsule.shape.a.y(), capsule.shape.b.y()) + capsule.shape.radius_m;
            ASSERT_LT(reach, nearest_y - 5e-3) << bridge::boneName(capsule.bone);
        }
}
