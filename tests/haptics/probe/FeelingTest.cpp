#include "haptics/base/Units.h"
#include "haptics/probe/FingertipForce.h"

#include <complex>
#include <limits>

#include <gtest/gtest.h>

namespace midair::haptics
{

TEST(Feeling, HasFourWordsThatDependOnHowItIsPlayed)
{
    EXPECT_EQ(strengthOf(0.5e-3, PlayedAs::HELD), Strength::TOO_WEAK);
    EXPECT_EQ(strengthOf(0.5e-3, PlayedAs::VIBRATING), Strength::FAINT);
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::HELD), Strength::FAINT);
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::VIBRATING), Strength::CLEAR);
    EXPECT_EQ(strengthOf(18e-3, PlayedAs::HELD), Strength::CLEAR);
    EXPECT_EQ(strengthOf(18e-3, PlayedAs::CIRCLING), Strength::STRONG);
    EXPECT_EQ(strengthOf(std::numeric_limits<double>::quiet_NaN(), PlayedAs::CIRCLING),
              Strength::TOO_WEAK);
    EXPECT_STREQ(strengthName(Strength::TOO_WEAK), "too weak to feel");
    EXPECT_STREQ(strengthName(Strength::STRONG), "strong");
}

TEST(Feeling, AThresholdOfOnesOwnMovesAllSteps)
{
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::HELD, 6e-3), Strength::TOO_WEAK);
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::HELD, 5e-3), Strength::FAINT);
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::HELD, 1e-3), Strength::CLEAR); // from 3.75 mN on
    EXPECT_EQ(strengthOf(5e-3, PlayedAs::HELD, 0.4e-3), Strength::STRONG);
}

// Two fields that press one place in turn: half of the force, and it goes up and down by as much.
TEST(FingertipForce, OfFieldsInTurnAlternates)
{
    const TransducerArray array = TransducerArray::load("board");
    const Medium medium;
    const Eigen::Vector3d place(0.0, 0.0, 0.15);
    const auto focusAt = [&](const Eigen::Vector3d& at)
    {
        Eigen::VectorXcf q(array.size());
        const double k = 2.0 * base::kPi / medium.wavelength(array.frequency_Hz);
        for (int i = 0; i < array.size(); ++i)
            q[i] = std::complex<float>(
                std::polar(1.0, k * (array.positions.col(i).cast<double>() - at).norm()));
        return q;
    };
    FieldSequence held;
    held.fields = {focusAt(place)};
    const FingertipForce one =
        fingertipForce(place, Eigen::Vector3d::Zero(), array, medium, held, false);
    EXPECT_GT(one.force_N, 1e-3);
    EXPECT_EQ(one.alternating_N, 0.0);
    EXPECT_EQ(one.how, PlayedAs::HELD);
    FieldSequence turn = held;
    turn.fields.push_back(focusAt(place + Eigen::Vector3d(0.06, 0.0, 0.0)));
    turn.modulation.fieldRate_Hz = 400.0;
    const FingertipForce two =
        fingertipForce(place, Eigen::Vector3d::Zero(), array, medium, turn, false);
    EXPECT_NEAR(two.force_N, 0.5 * one.force_N, 0.05 * one.force_N);
    EXPECT_NEAR(two.alternating_N, 0.5 * one.force_N, 0.05 * one.force_N);
    EXPECT_GE(two.strength(), strengthOf(two.force_N, PlayedAs::HELD));
    turn.modulation.fieldRate_Hz = 20.0; // each ten times a second
    EXPECT_EQ(
        fingertipForce(place, Eigen::Vector3d::Zero(), array, medium, turn, false).alternating_N,
        0.0);
    EXPECT_EQ(fingertipForce(place, Eigen::Vector3d::Zero(), array, medium, turn, true).how,
              PlayedAs::CIRCLING);
}

TEST(Feeling, ForcesAreReadInMillinewtons)
{
    EXPECT_EQ(forceText(12.34e-3), "12 mN");
    EXPECT_EQ(forceText(9.96e-3), "10 mN");
    EXPECT_EQ(forceText(3.42e-3), "3.4 mN");
    EXPECT_EQ(forceText(0.01e-3), "under 0.1 mN");
    EXPECT_EQ(forceText(std::numeric_limits<double>::quiet_NaN()), "under 0.1 mN");
}

} // namespace midair::haptics
