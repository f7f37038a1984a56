#include "haptics/solvers/dense/QuasiNewton.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

TEST(QuasiNewton, ReachesTheMinimumOfAQuadraticMuchSoonerThanSteepestDescent)
{
    constexpr int n = 40;
    const Eigen::VectorXf curvature = Eigen::VectorXf::LinSpaced(n, 1.0f, 100.0f);
    const auto rest = [&](int memory)
    {
        QuasiNewton descent(memory);
        Eigen::VectorXf x = Eigen::VectorXf::Ones(n), direction, before;
        Eigen::VectorXf gradient = curvature.cwiseProduct(x);
        for (int k = 0; k < 30; ++k)
        {
            if (memory == 0) descent.forget();
            descent.direct(gradient, direction);
            EXPECT_LT(gradient.dot(direction), 0.0f);
            // The exact minimum along the direction.
            const float share =
                -gradient.dot(direction) / direction.cwiseProduct(curvature).dot(direction);
            x += share * direction;
            before = gradient;
            gradient = curvature.cwiseProduct(x);
            descent.remember(direction, share, before, gradient);
        }
        return x.norm();
    };
    EXPECT_LT(rest(8), 0.02f * rest(0));
}

TEST(QuasiNewton, LeavesOutStepsThatTellNoCurvature)
{
    QuasiNewton descent(3);
    const Eigen::Vector3f gradient(1.0f, -2.0f, 3.0f);
    Eigen::VectorXf direction;
    descent.direct(gradient, direction);
    EXPECT_EQ(direction, -gradient);
    const Eigen::Vector3f step(1.0f, 0.0f, 0.0f);
    descent.remember(step, 1.0f, gradient, gradient);        // no change at all
    descent.remember(step, 1.0f, gradient, gradient - step); // curved downwards
    descent.remember(step, 0.0f, gradient, gradient + step); // no step
    EXPECT_TRUE(descent.isEmpty());
    descent.remember(step, 1.0f, gradient, gradient + step);
    EXPECT_FALSE(descent.isEmpty());
    descent.forget();
    EXPECT_TRUE(descent.isEmpty());
}

TEST(QuasiNewton, FollowsASecantExactly)
{
    QuasiNewton descent(2);
    const Eigen::Vector2f before(4.0f, 0.0f), step(-1.0f, 0.0f), after(2.0f, 0.0f);
    descent.remember(step, 1.0f, before, after);
    Eigen::VectorXf direction;
    descent.direct(after, direction);
    // Curvature 2 along x: the minimum is one more step of the same length away.
    EXPECT_NEAR(direction[0], -1.0f, 1e-6f);
    EXPECT_NEAR(direction[1], 0.0f, 1e-6f);
}

} // namespace
} // namespace midair::haptics
