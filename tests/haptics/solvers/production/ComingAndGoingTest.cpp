// Updates in which some of the points are others than in the last one.
#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/Solvers.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

/// A moving sphere of 120 places, of which another tenth is left out in each update.
class Flickering
{
public:
    explicit Flickering(bool isIdentified) : _isIdentified(isIdentified) {}

    ControlPoints next()
    {
        _all.positions.row(0).array() += 1e-4;
        std::vector<int> places(static_cast<std::size_t>(_all.size()));
        std::iota(places.begin(), places.end(), 0);
        std::shuffle(places.begin(), places.end(), _random);
        places.resize(places.size() * 9 / 10);
        std::sort(places.begin(), places.end());
        ControlPoints points = pick(_all, places);
        if (_isIdentified)
            for (const int place : places)
                points.identity.push_back(static_cast<std::uint64_t>(place) + 1000);
        return points;
    }

private:
    bool _isIdentified;
    ControlPoints _all = spherePoints(120, 0.035);
    std::mt19937 _random{5};
};

struct Updates
{
    double rms = 0.0, loudness = 0.0, change = 0.0, iterations = 0.0; ///< means
};

Updates updatesOf(bool isIdentified)
{
    constexpr int kUpdates = 40;
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeGaussNewton({});
    Flickering scene(isIdentified);
    Eigen::VectorXcf q;
    solver->solve(scene.next(), array, Medium(), q);
    Updates mean;
    for (int i = 0; i < kUpdates; ++i)
    {
        const SolveReport report = solver->solve(scene.next(), array, Medium(), q);
        mean.rms += report.rms / kUpdates;
        mean.loudness += report.loudness / kUpdates;
        mean.change += report.driveChange / kUpdates;
        mean.iterations += static_cast<double>(report.iterations) / kUpdates;
    }
    return mean;
}

} // namespace

TEST(ComingAndGoing, PointsAreFollowedByTheirIdentity)
{
    const Updates followed = updatesOf(true), anew = updatesOf(false);
    EXPECT_LT(followed.iterations, 0.3 * anew.iterations);
    EXPECT_LT(followed.change, 0.7 * anew.change);
    EXPECT_GT(followed.loudness, 0.97 * anew.loudness);
    EXPECT_LT(followed.rms, 1.4e-4) << "as any update of a moving object";
}

TEST(ComingAndGoing, AnotherOrderOfTheSamePointsIsTheSameField)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeGaussNewton({});
    ControlPoints points = spherePoints(60, 0.03);
    points.identity.resize(60);
    std::iota(points.identity.begin(), points.identity.end(), 1);
    Eigen::VectorXcf q;
    solver->solve(points, array, Medium(), q);
    solver->solve(points, array, Medium(), q);
    std::vector<int> reversed(60);
    std::iota(reversed.rbegin(), reversed.rend(), 0);
    const SolveReport report = solver->solve(pick(points, reversed), array, Medium(), q);
    EXPECT_LT(report.driveChange, 0.01) << "the weights and phases go with the points";
}

TEST(ComingAndGoing, OthersThanBeforeBeginAnew)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeGaussNewton({}), fresh = makeGaussNewton({});
    ControlPoints points = spherePoints(60, 0.03);
    points.identity.resize(60);
    std::iota(points.identity.begin(), points.identity.end(), 1);
    Eigen::VectorXcf q;
    solver->solve(points, array, Medium(), q);
    // Four in five are new: the last field says nothing of them.
    std::iota(points.identity.begin(), points.identity.end(), 49);
    points.positions.row(1).array() += 0.05;
    const SolveReport report = solver->solve(points, array, Medium(), q);
    Eigen::VectorXcf r;
    const SolveReport cold = fresh->solve(points, array, Medium(), r);
    EXPECT_GE(report.iterations, cold.iterations / 2);
    EXPECT_GT(report.loudness, 0.97 * cold.loudness);
}

TEST(ComingAndGoing, IdentitiesThatAreAllTheSameDoNoHarm)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeGaussNewton({});
    Eigen::VectorXcf q;
    for (const int n : {30, 20, 40, 1, 30})
    {
        ControlPoints points = spherePoints(n, 0.03);
        points.identity.assign(static_cast<std::size_t>(n), 7);
        const SolveReport report = solver->solve(points, array, Medium(), q);
        EXPECT_LT(report.rms, 2e-3) << n;
        EXPECT_TRUE(q.allFinite());
        points.identity.resize(1); // of another length: as if there were none
        EXPECT_LT(solver->solve(points, array, Medium(), q).rms, 2e-3) << n;
    }
}

} // namespace midair::haptics
