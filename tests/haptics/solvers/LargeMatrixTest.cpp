#include "haptics/solvers/LargeMatrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

/// Hermitian with the eigenvalues 1 .. n.
Eigen::MatrixXcd matrix(int n)
{
    std::srand(1);
    const Eigen::MatrixXcd Q =
        Eigen::HouseholderQR<Eigen::MatrixXcd>(Eigen::MatrixXcd::Random(n, n)).householderQ();
    const Eigen::VectorXcd values =
        Eigen::VectorXd::LinSpaced(n, 1.0, n).cast<std::complex<double>>();
    const Eigen::MatrixXcd A = Q * values.asDiagonal() * Q.adjoint();
    return 0.5 * (A + A.adjoint());
}

} // namespace

TEST(LargeMatrix, ACholeskyFactorInStepsIsThatOfOneGo)
{
    for (const int n : {1, 5, 128, 129, 200})
    {
        const Eigen::MatrixXcd A = matrix(n);
        const BlockCholesky factor(A);
        ASSERT_TRUE(factor.isPositive());
        EXPECT_TRUE(factor.isFinite());
        const auto unit = Eigen::MatrixXcd::Identity(n, n);
        EXPECT_LT((A * factor.inverse() - unit).norm(), 1e-10 * n) << n;
        const Eigen::VectorXcd b = Eigen::VectorXcd::Random(n);
        EXPECT_LT((A * factor.solve(b) - b).norm(), 1e-10 * n) << n;
    }
}

TEST(LargeMatrix, WhatIsNotPositiveIsSaidToBeSo)
{
    for (const int n : {5, 200})
    {
        Eigen::MatrixXcd A = matrix(n);
        A.diagonal().array() -= 1.5;
        EXPECT_FALSE(BlockCholesky(A).isPositive()) << n;
        EXPECT_TRUE(BlockCholesky(matrix(n)).isPositive());
    }
}

TEST(LargeMatrix, TheLeadingPairIsThatOfTheWholeDecomposition)
{
    for (const int n : {5, 128, 200})
    {
        const Eigen::MatrixXcd A = matrix(n);
        const LeadingPair pair = leadingPair(A);
        EXPECT_NEAR(pair.value, n, 1e-8 * n);
        EXPECT_NEAR(pair.vector.norm(), 1.0, 1e-12);
        EXPECT_LT((A * pair.vector - pair.value * pair.vector).norm(), 1e-7 * n) << n;
    }
}

TEST(LargeMatrix, ALeadingValueThatIsThereTwiceHasAVectorToo)
{
    Eigen::MatrixXcd A = Eigen::MatrixXcd::Identity(150, 150);
    A(3, 3) = A(7, 7) = 2.0;
    const LeadingPair pair = leadingPair(A);
    EXPECT_NEAR(pair.value, 2.0, 1e-12);
    EXPECT_LT(pair.residual, 1e-9);
}

TEST(LargeMatrix, StepsAreBrokenOff)
{
    midair::base::StopSource source;
    source.request();
    const Eigen::MatrixXcd A = matrix(150);
    EXPECT_THROW(BlockCholesky(A, source.token()), midair::base::Stopped);
    EXPECT_THROW(BlockCholesky(A).inverse(source.token()), midair::base::Stopped);
    EXPECT_THROW(leadingPair(A, 1e-10, source.token()), midair::base::Stopped);
}
