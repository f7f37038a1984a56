#include "haptics/base/Units.h"
#include "haptics/probe/FingertipForce.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <random>

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

namespace
{

/// A field of twelve foci between the points, which tell little of it.
struct BetweenPoints
{
    BetweenPoints()
    {
        points.positions.resize(3, 36);
        for (int row = 0; row < 6; ++row)
            for (int column = 0; column < 6; ++column)
                points.positions.col(6 * row + column) << 9e-3 * (column - 2.5), 9e-3 * (row - 2.5),
                    0.15;
        points.normals = Eigen::Vector3d::UnitZ().replicate(1, 36);
        points.targets = Eigen::VectorXd::Ones(36);
        sequence.parts = {points};
        const double k = 2.0 * base::kPi / medium.wavelength(array.frequency_Hz);
        Eigen::VectorXcd q = Eigen::VectorXcd::Zero(array.size());
        std::mt19937 random(7);
        std::uniform_real_distribution<double> draw(-1.0, 1.0);
        for (int focus = 0; focus < 12; ++focus)
        {
            const Eigen::Vector3d at(0.025 * draw(random), 0.025 * draw(random), 0.15);
            const double phase = base::kPi * draw(random);
            for (int i = 0; i < array.size(); ++i)
                q[i] += std::polar(1.0,
                                   phase + k * (array.positions.col(i).cast<double>() - at).norm());
        }
        q /= q.cwiseAbs().maxCoeff();
        sequence.fields = {q.cast<std::complex<float>>()};
        achieved_Pa = pressureAt(points.positions, array, medium, sequence.fields.front())
                          .cwiseAbs()
                          .cast<double>();
    }

    /// The force on a disc at \a place, as an integral over rings.
    double force_N(const Eigen::Vector3d& place) const
    {
        constexpr int kRings = 14, kSectors = 40;
        constexpr double kRadius_m = 7e-3;
        Eigen::Matrix3Xd at(3, kRings * kSectors);
        Eigen::VectorXd area_m2(at.cols());
        for (int i = 0; i < kRings; ++i)
            for (int s = 0; s < kSectors; ++s)
            {
                const double r = kRadius_m * (i + 0.5) / kRings;
                const double angle = 2.0 * base::kPi * s / kSectors;
                at.col(kSectors * i + s) =
                    place + r * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
                area_m2[kSectors * i + s] = r * (kRadius_m / kRings) * (2.0 * base::kPi / kSectors);
            }
        const Eigen::VectorXcd q = sequence.fields.front().cast<std::complex<double>>();
        const Eigen::VectorXd p2 = (referencePropagationMatrix(at, array, medium) * q).cwiseAbs2();
        // Twice the mean energy density, because the finger reflects: p^2/(rho c^2).
        const double c = medium.soundSpeed();
        return p2.dot(area_m2) / (medium.density() * c * c);
    }

    TransducerArray array = TransducerArray::load("board");
    Medium medium;
    ControlPoints points;
    FieldSequence sequence;
    Eigen::VectorXd achieved_Pa;
};

} // namespace

// Of all points, by an integral that is written apart.
TEST(FingertipForce, IsTakenWhereItIsStrongest)
{
    const BetweenPoints field;
    double most_N = 0.0;
    for (const auto& place : field.points.positions.colwise())
        most_N = std::max(most_N, field.force_N(place));
    const FingertipForce found =
        strongestForce(field.points, field.achieved_Pa, field.array, field.medium, field.sequence);
    EXPECT_NEAR(found.force_N, most_N, 0.04 * most_N);
}

// A field that moves gets a few points; later ones go on from there.
TEST(FingertipForce, ASearchInStepsFindsTheSame)
{
    const BetweenPoints field;
    const double all_N =
        strongestForce(field.points, field.achieved_Pa, field.array, field.medium, field.sequence)
            .force_N;
    FingertipSearch search;
    const auto begin = [&]
    {
        return search.begin(
            field.points, field.achieved_Pa, field.array, field.medium, field.sequence, false, 2);
    };
    EXPECT_LE(begin().force_N, all_N);
    FingertipForce most;
    int steps = 0;
    for (; search.hasWork(); ++steps)
        most = search.goOn(field.points, field.array, field.medium, field.sequence, false, 5);
    EXPECT_EQ(steps, 7); // of 34
    EXPECT_EQ(most.force_N, all_N);
    EXPECT_EQ(begin().force_N, all_N) << "the strongest place is looked at first";
    EXPECT_EQ(
        search.begin(ControlPoints(), Eigen::VectorXd(), field.array, field.medium, {}, false, 2)
            .force_N,
        0.0);
    EXPECT_FALSE(search.hasWork());
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
