#include "haptics/points/FittedLevel.h"

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

// y = (2, 6), a = (1, 2): y.a = 14, a.a = 5, s = 2.8; errors 2/2.8 - 1 = -2/7 and 6/5.6 - 1 = 1/14.
const Eigen::Vector2f kReached(2.0f, 6.0f);
const Eigen::Vector2f kWanted(1.0f, 2.0f);

TEST(FittedLevel, IsTheLeastSquaresFit)
{
    EXPECT_FLOAT_EQ(fittedLevel(kReached, kWanted), 2.8f);
    EXPECT_DOUBLE_EQ(fittedLevelInOrder(kReached, kWanted), 2.8);
    EXPECT_DOUBLE_EQ(fittedLevel(kReached.cast<double>(), kWanted.cast<double>()), 2.8);
}

TEST(FittedLevel, ErrorsAreRelativeToIt)
{
    const double rms = std::sqrt(0.5 * (4.0 / 49.0 + 1.0 / 196.0));
    const RelativeErrors errors = relativeErrors(kReached, kWanted, 2.8);
    EXPECT_DOUBLE_EQ(errors.rms, rms);
    EXPECT_DOUBLE_EQ(errors.max, 2.0 / 7.0);
    EXPECT_NEAR(relativeRms(kReached, kWanted, 2.8f), rms, 1e-7);
}

TEST(FittedLevel, DoesNotDependOnTheUnitOfTheTargets)
{
    const Eigen::Vector2f other = 1000.0f * kWanted;
    EXPECT_DOUBLE_EQ(relativeErrors(kReached, other, fittedLevelInOrder(kReached, other)).rms,
                     relativeErrors(kReached, kWanted, 2.8).rms);
}

// A point that wants next to nothing, as where a contact begins, and gets 3 Pa.
TEST(FittedLevel, ErrorsOfWhatWantsNextToNothingAreOfTheLargest)
{
    const Eigen::Vector3d wanted(600.0, 4e-10, 6.1), reached(660.0, 3.0, 12.2);
    const RelativeErrors errors = relativeErrors(reached, wanted, 1.0);
    EXPECT_DOUBLE_EQ(errors.max, 1.0) << "a target of 1 % has its own error";
    const double rms = std::sqrt((0.01 + 25e-6 + 1.0) / 3.0);
    EXPECT_NEAR(errors.rms, rms, 1e-6);
    EXPECT_NEAR(relativeErrors(reached.head(2), wanted.head(2), 1.0).max, 0.1, 1e-9);
    EXPECT_NEAR(errors.maxOfLargest, 0.1, 1e-9);
}

} // namespace
} // namespace midair::haptics
