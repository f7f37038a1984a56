// What is known of a field, from its solver, and how a cap uses it.
#include "engine-bridge/playing/FieldBounds.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"

#include <random>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

Eigen::VectorXcf decoded(const device::DriveSignal& signal)
{
    std::vector<std::complex<float>> q;
    device::decode(signal, q);
    return Eigen::Map<Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

struct Solved
{
    Solved() : array(haptics::TransducerArray::octagonalPrism())
    {
        std::mt19937 random(11);
        std::uniform_real_distribution<double> place(-0.03, 0.03);
        points.positions.resize(3, 30);
        for (double& x : points.positions.reshaped())
            x = place(random);
        points.targets = Eigen::VectorXd::Ones(30);
        const auto solver = haptics::makeSolver("gauss-newton");
        report = solver->solve(points, array, medium, q);
        known = {1.0, q, solver->achieved_Pa()};
    }
    double loudest_Pa(const Eigen::VectorXcf& field) const
    {
        return loudestInDouble(points.positions, array, medium, field);
    }

    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::ControlPoints points;
    haptics::SolveReport report;
    Eigen::VectorXcf q;
    CappedField known;
};

} // namespace

TEST(FieldBounds, ACapHoldsByWhatTheSolverKnows)
{
    const Solved of;
    ASSERT_EQ(of.known.achieved_Pa.size(), 30);
    device::DriveSignal wanted;
    ASSERT_TRUE(device::encode(of.q.data(), of.array.size(), wanted));
    const double level_Pa = of.loudest_Pa(of.q);
    const CappedPlaces where{of.points.positions, {&of.array}, of.medium};
    for (const double share : {0.1, 0.37, 0.7, 0.999, 0.99999, 1.00001, 1.001, 1.5})
    {
        SCOPED_TRACE(share);
        const PressureCap cap(share * level_Pa, decoded);
        device::DriveSignal byItself = wanted, byKnown = wanted;
        const CappedField alone = cap.hold(where, byItself);
        const CappedField held = cap.hold(where, byKnown, of.known);
        EXPECT_EQ(byKnown.duty, byItself.duty);
        EXPECT_EQ(byKnown.phase, byItself.phase);
        EXPECT_NEAR(held.factor, alone.factor, 1e-3);
        const double loudest_Pa = of.loudest_Pa(decoded(byKnown));
        EXPECT_LE(loudest_Pa, share * level_Pa);
        EXPECT_NEAR(held.achieved_Pa.maxCoeff(), loudest_Pa, 1e-4 * loudest_Pa);
    }
}

// Figures that are half the truth show where they are used.
TEST(FieldBounds, WhatIsInProportionIsTakenAtItsWordAndNothingElseIs)
{
    Solved of;
    const double level_Pa = of.loudest_Pa(of.q);
    of.known.achieved_Pa *= 0.5f;
    const CappedPlaces where{of.points.positions, {&of.array}, of.medium};
    const device::DriveAbility ability;
    const FieldBounds bounds(where, ability, of.known);
    const auto boundOf = [&](const FieldBounds& one, const Eigen::VectorXcf& q, float rounding)
    {
        Eigen::MatrixXf achieved_Pa;
        return one.of({q}, {rounding}, achieved_Pa, 10.0 * level_Pa).front() / level_Pa;
    };
    EXPECT_NEAR(boundOf(bounds, of.q, 0.0f), 0.5, 0.02);
    EXPECT_NEAR(boundOf(bounds, 0.3f * of.q, 0.0f), 0.15, 0.02);
    Eigen::VectorXcf other = of.q;
    other[17] = 0.0f;
    EXPECT_GE(boundOf(bounds, other, 0.0f), of.loudest_Pa(other) / level_Pa);
    EXPECT_GE(boundOf(bounds, of.q, 0.01f), 1.0);
    EXPECT_GE(boundOf(bounds, -of.q, 0.0f), 1.0);
    // Nor where the array may sound otherwise, or the cap is looked for exactly.
    const CappedPlaces both{of.points.positions, {&of.array, &of.array}, of.medium};
    EXPECT_GE(boundOf(FieldBounds(both, ability, of.known), of.q, 0.0f), 1.0);
    device::DriveAbility inParts;
    inParts.part.assign(static_cast<std::size_t>(of.array.size()), 0);
    inParts.part.back() = 1;
    EXPECT_GE(boundOf(FieldBounds(where, inParts, of.known), of.q, 0.0f), 0.999);
    Eigen::MatrixXf achieved_Pa;
    EXPECT_GE(bounds.of({of.q}, {0.0f}, achieved_Pa).front(), level_Pa);
    of.known.achieved_Pa[3] = std::nanf("");
    EXPECT_GE(boundOf(FieldBounds(where, ability, of.known), of.q, 0.0f), 1.0);
}
