// The vibration of pressures against small steps in time, and its derivative against differences.
#include "haptics/sequence/CycleVibration.h"

#include "haptics/propagation/FingertipVibration.h"
#include "tests/haptics/sequence/SteppedCycle.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

constexpr double kTau_s = 190e-6;

/// n x K, of about 1.
Eigen::MatrixXcd randomPressures(Eigen::Index n, int K)
{
    std::mt19937 random(5);
    std::normal_distribution<double> part(0.0, 1.0);
    return Eigen::MatrixXcd::NullaryExpr(
        n, K, [&] { return std::complex<double>(part(random), part(random)); });
}

CycleVibration::Pressures rowOf(const Eigen::MatrixXcd& p, Eigen::Index l)
{
    CycleVibration::Pressures row;
    for (const std::complex<double>& one : p.row(l))
        row.emplace_back(one);
    return row;
}

double squaredOf(CycleVibration& vibration, const Eigen::MatrixXcd& p, double mean)
{
    for (Eigen::Index l = 0; l < p.rows(); ++l)
        vibration.set(l, rowOf(p, l));
    return vibration.squared(mean);
}

TEST(CycleVibration, IsThatOfSmallStepsInTime)
{
    const Eigen::Matrix3Xd places = spherePoints(50, 0.012, {0.0, 0.0, 0.1}).positions;
    for (const int K : {2, 3, 8})
        for (const double step_s : {2e-4, 1e-3})
        {
            const Eigen::MatrixXcd p = randomPressures(places.cols(), K);
            CycleVibration vibration(places, K, step_s, kTau_s);
            const double slow = steppedVibration2(places, p, step_s, kTau_s, 1.7);
            EXPECT_NEAR(squaredOf(vibration, p, 1.7), slow, 2e-3 * slow + 1e-9)
                << K << " " << step_s;
        }
}

TEST(CycleVibration, ItsDerivativeIsThatOfDifferences)
{
    constexpr double kSmall = 1e-2;
    const Eigen::Matrix3Xd places = spherePoints(40, 0.012, {0.0, 0.0, 0.1}).positions;
    for (const int K : {2, 3, 5})
    {
        Eigen::MatrixXcd p = randomPressures(places.cols(), K);
        CycleVibration vibration(places, K, 1e-3, kTau_s);
        squaredOf(vibration, p, 2.0);
        for (const Eigen::Index l : {0, 17})
        {
            CycleVibration::Pressures u(static_cast<std::size_t>(K));
            squaredOf(vibration, p, 2.0);
            vibration.addTo(l, 3.0f, rowOf(p, l), u);
            for (int k = 0; k < K; ++k)
                for (const std::complex<double> direction :
                     {std::complex<double>(1.0, 0.0), std::complex<double>(0.0, 1.0)})
                {
                    const auto at = [&](double share)
                    {
                        Eigen::MatrixXcd moved = p;
                        moved(l, k) += share * direction;
                        return steppedVibration2(places, moved, 1e-3, kTau_s, 2.0);
                    };
                    const double slow = (at(kSmall) - at(-kSmall)) / (2.0 * kSmall);
                    const double fast =
                        std::real(std::conj(direction) *
                                  std::complex<double>(u[static_cast<std::size_t>(k)])) /
                        3.0;
                    EXPECT_NEAR(fast, slow, 0.01 * std::fabs(slow) + 2e-6) << K << " " << k;
                }
        }
    }
}

TEST(CycleVibration, WithoutFeltWavesThereIsNone)
{
    const Eigen::Matrix3Xd places = spherePoints(20, 0.012, {0.0, 0.0, 0.1}).positions;
    CycleVibration none(places, 2, 1e-4, kTau_s);
    EXPECT_TRUE(none.isEmpty());
    EXPECT_EQ(none.squared(1.0), 0.0);
    EXPECT_TRUE(CycleVibration().isEmpty());
}

} // namespace
} // namespace midair::haptics
