// What an update makes of points that are not near those of the last one.
#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/Solvers.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

using Change = std::function<void(Eigen::Matrix3Xd&, std::mt19937&)>;

void permute(Eigen::Matrix3Xd& positions, std::mt19937& random)
{
    std::vector<int> order(static_cast<std::size_t>(positions.cols()));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    const Eigen::Matrix3Xd before = positions;
    for (std::size_t l = 0; l < order.size(); ++l)
        positions.col(static_cast<Eigen::Index>(l)) = before.col(order[l]);
}

// The mean loudness of the fifth update after a change, over that of a start from nothing at the
// same place.
double loudnessAfter(int n, const Change& change)
{
    constexpr int kScenes = 6;
    const TransducerArray array = TransducerArray::octagonalPrism();
    double updated = 0.0, cold = 0.0;
    for (int scene = 0; scene < kScenes; ++scene)
    {
        std::mt19937 random(static_cast<unsigned>(scene));
        SolverOptions options;
        options.seed = static_cast<std::uint64_t>(scene) + 1;
        ControlPoints points = spherePoints(n, 0.03);
        const auto solver = makeGaussNewton(options);
        Eigen::VectorXcf q;
        for (int k = 0; k < 20; ++k)
        {
            points.positions.row(0).array() += 1e-4;
            solver->solve(points, array, Medium(), q);
        }
        change(points.positions, random);
        for (int k = 0; k < 4; ++k)
        {
            solver->solve(points, array, Medium(), q);
            points.positions.row(0).array() += 1e-4;
        }
        updated += solver->solve(points, array, Medium(), q).loudness;
        Eigen::VectorXcf fresh;
        cold += makeGaussNewton(options)->solve(points, array, Medium(), fresh).loudness;
    }
    return updated / cold;
}

} // namespace

TEST(Recovery, AFieldIsAsLoudAsANewOneFiveUpdatesAfterAJump)
{
    const Change jump = [](Eigen::Matrix3Xd& positions, std::mt19937&)
    { positions.colwise() += Eigen::Vector3d(0.02, 0.05, -0.026); };
    for (const int n : {25, 50, 100})
        EXPECT_GT(loudnessAfter(n, jump), 0.98) << n;
}

TEST(Recovery, AFieldIsAsLoudAsANewOneFiveUpdatesAfterATurn)
{
    const Change turn = [](Eigen::Matrix3Xd& positions, std::mt19937&)
    {
        const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 0.5, -0.8).normalized();
        positions = Eigen::AngleAxisd(1.0, axis).toRotationMatrix() * positions;
    };
    for (const int n : {25, 50, 100})
        EXPECT_GT(loudnessAfter(n, turn), 0.98) << n;
}

// The phases of the last field then belong to other points. They used to be improved over tens of
// updates.
TEST(Recovery, AFieldIsAsLoudAsANewOneFiveUpdatesAfterAPermutation)
{
    for (const int n : {25, 50, 100})
        EXPECT_GT(loudnessAfter(n, permute), 0.98) << n;
}

} // namespace midair::haptics
