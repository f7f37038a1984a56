#pragma once

#include "engine-bridge/calibration/PointPairs.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <random>

namespace midair::bridge
{

/// Point pairs as someone would measure them, with known noise and a known answer.
class Simulation
{
public:
    explicit Simulation(std::uint64_t seed) : _random(seed) {}

    Eigen::Vector3d inBox(double halfEdge)
    {
        std::uniform_real_distribution<double> uniform(-halfEdge, halfEdge);
        return {uniform(_random), uniform(_random), uniform(_random)};
    }

    Eigen::Vector3d noise(double sigma)
    {
        std::normal_distribution<double> normal(0.0, sigma);
        return {normal(_random), normal(_random), normal(_random)};
    }

    Eigen::Isometry3d motion()
    {
        std::normal_distribution<double> normal;
        const Eigen::Quaterniond turn(
            normal(_random), normal(_random), normal(_random), normal(_random));
        Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
        result.linear() = turn.normalized().toRotationMatrix();
        result.translation() = inBox(2.0);
        return result;
    }

    /// \a n points in a box of 200 mm round the array's origin, the array's side with noise.
    PointPairs pairs(const Eigen::Isometry3d& worldToArray, int n, double sigma)
    {
        PointPairs result;
        result.world.resize(3, n);
        result.array.resize(3, n);
        for (int k = 0; k < n; ++k)
        {
            const Eigen::Vector3d spot = inBox(0.1);
            result.world.col(k) = worldToArray.inverse() * spot;
            result.array.col(k) = spot + noise(sigma);
        }
        return result;
    }

private:
    std::mt19937_64 _random;
};

} // namespace midair::bridge
