#include "haptics/solvers/PhaseObjective.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/solvers/PhaseScenes.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

TEST(PhaseObjective, IsTheLeastMisfitAndPowerOverAllActivations)
{
    // For the q that the weights give, |G q - diag(a) u|^2 + lambda |q|^2 is u* M u; any other q
    // has more.
    std::mt19937_64 random(3);
    const Eigen::MatrixXcd G = randomMatrix(6, 20, random);
    Eigen::VectorXd a(6);
    a << 1.0, 0.5, 2.0, 1.0, 0.0, 0.3;
    const PhaseObjective objective(gramMatrix(G), a, 0.1);
    EXPECT_NEAR(objective.lambda(), 0.1 * G.squaredNorm() / 6.0, 1e-12 * G.squaredNorm());
    const Eigen::VectorXcd u = randomPhases(6, random);
    const Eigen::VectorXcd q = G.adjoint() * objective.weights(u);
    const auto cost = [&](const Eigen::VectorXcd& z)
    { return (G * z - a.asDiagonal() * u).squaredNorm() + objective.lambda() * z.squaredNorm(); };
    // Rounding of sums of about a hundred terms.
    EXPECT_NEAR(cost(q), objective.value(u), 1e-11);
    for (int i = 0; i < 50; ++i)
        EXPECT_GT(cost(q + 1e-3 * randomMatrix(20, 1, random)), objective.value(u));
    // The field's own measure allows any phases and scale, so it is at most that.
    EXPECT_LE(objective.misfitAndPower(G * q, q.squaredNorm()), objective.value(u) + 1e-11);
}

TEST(PhaseObjective, GradientIsTheDifferenceQuotient)
{
    const PhaseObjective objective = prismObjective(spherePoints(12, 0.03));
    std::mt19937_64 random(5);
    const Eigen::VectorXcd u = randomPhases(12, random);
    const Eigen::VectorXd gradient = objective.gradient(u);
    const double h = 1e-5;
    for (int l = 0; l < 12; ++l)
    {
        Eigen::VectorXcd ahead = u, behind = u;
        ahead[l] *= std::polar(1.0, h);
        behind[l] *= std::polar(1.0, -h);
        // Central differences: h^2 of the third derivative, about trace(M).
        EXPECT_NEAR(gradient[l],
                    (objective.value(ahead) - objective.value(behind)) / (2.0 * h),
                    1e-8 * objective.trace());
    }
}

TEST(PhaseObjective, DescentEndsWhereNoSinglePhaseCanBeBettered)
{
    const PhaseObjective objective = prismObjective(spherePoints(30, 0.03));
    std::mt19937_64 random(7);
    for (int start = 0; start < 5; ++start)
    {
        Eigen::VectorXcd u = randomPhases(30, random);
        const double before = objective.value(u);
        const double value = objective.descend(u, 5000, 1e-14);
        EXPECT_LT(value, before);
        EXPECT_NEAR(value, objective.value(u), 1e-12 * objective.trace());
        // The step that stops the descent is below 1e-9.
        EXPECT_LT(objective.gradient(u).cwiseAbs().maxCoeff(), 1e-6 * objective.trace());
        const Eigen::VectorXcd r =
            objective.M() * u - (objective.M().diagonal().array() * u.array()).matrix();
        for (int l = 0; l < 30; ++l)
            EXPECT_NEAR(std::abs(u[l] + r[l] / std::abs(r[l])), 0.0, 1e-5);
        // From the same start in float: the same minimum, to what float tells apart.
        Eigen::VectorXcd fast = u;
        EXPECT_NEAR(objective.descendFast(fast, 100, 1e-6), value, 1e-5 * objective.trace());
    }
}

TEST(PhaseObjective, FloatMatrixGivesTheSameForm)
{
    // G in float is good to 1e-5 of its entries; K + lambda I is well conditioned, so that M is
    // too.
    for (int n : {1, 2, 17, 50})
    {
        const ControlPoints points = spherePoints(n, 0.03);
        PropagationMatrix G;
        G.bind(TransducerArray::octagonalPrism(), Medium());
        G.build(points.positions);
        const PhaseObjective fast(gramMatrix(G), points.targets), exact = prismObjective(points);
        EXPECT_NEAR(fast.lambda() / exact.lambda(), 1.0, 1e-5);
        EXPECT_LT((fast.M() - exact.M()).norm(), 1e-5 * exact.M().norm()) << "n = " << n;
        EXPECT_EQ(fast.M(), Eigen::MatrixXcd(fast.M().adjoint())); // exactly Hermitian
    }
}

TEST(PhaseObjective, RefusesWhatPosesNoProblem)
{
    const Eigen::MatrixXcd K = Eigen::MatrixXcd::Identity(2, 2);
    const auto text =
        [&](const Eigen::MatrixXcd& matrix, const Eigen::VectorXd& a, double lambdaRel)
    {
        try
        {
            const PhaseObjective objective(matrix, a, lambdaRel);
        }
        catch (const midair::base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const Eigen::Vector2d ones = Eigen::Vector2d::Ones();
    EXPECT_EQ(text(K, ones, 0.1), "accepted");
    EXPECT_EQ(text(Eigen::MatrixXcd(0, 0), Eigen::VectorXd(), 0.1),
              "phase objective: K is 0 x 0; it must be square and not empty");
    EXPECT_EQ(text(K, Eigen::VectorXd::Ones(3), 0.1),
              "phase objective: 3 targets for 2 control points");
    const char* const targets =
        "phase objective: targets must be finite and at least 0, one of them more";
    EXPECT_EQ(text(K, Eigen::Vector2d(1.0, -1.0), 0.1), targets);
    EXPECT_EQ(text(K, Eigen::Vector2d::Zero(), 0.1), targets);
    EXPECT_EQ(text(K, Eigen::Vector2d(1.0, std::nan("")), 0.1), targets);
    EXPECT_EQ(text(K, ones, 0.0), "phase objective: lambdaRel is 0; it must be from 1e-5 to 1e9");
    EXPECT_EQ(text(0.0 * K, ones, 0.1),
              "phase objective: K is not finite or zero; no transducer reaches a control point");
}
