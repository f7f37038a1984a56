#pragma once

#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

#include <cmath>

namespace midair::haptics
{

/// \a n equal targets on a Fibonacci sphere.
inline ControlPoints
spherePoints(int n, double radius_m, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero())
{
    ControlPoints points;
    points.positions.resize(3, n);
    points.normals.resize(3, n);
    points.targets = Eigen::VectorXd::Ones(n);
    for (int l = 0; l < n; ++l)
    {
        const double y = 1.0 - 2.0 * (l + 0.5) / n;
        const double r = std::sqrt(1.0 - y * y);
        const double angle = l * M_PI * (3.0 - std::sqrt(5.0));
        points.normals.col(l) = Eigen::Vector3d(r * std::cos(angle), y, r * std::sin(angle));
        points.positions.col(l) = centre + radius_m * points.normals.col(l);
    }
    return points;
}

/// nx x ny x nz equal targets on a grid around the origin; normals along y.
inline ControlPoints gridPoints(int nx, int ny, int nz, double spacing_m)
{
    ControlPoints points;
    points.positions.resize(3, nx * ny * nz);
    Eigen::Index l = 0;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x)
                points.positions.col(l++) =
                    spacing_m *
                    (Eigen::Vector3d(x, y, z) - 0.5 * Eigen::Vector3d(nx - 1, ny - 1, nz - 1));
    points.normals = Eigen::Vector3d::UnitY().replicate(1, l);
    points.targets = Eigen::VectorXd::Ones(l);
    return points;
}

} // namespace midair::haptics
