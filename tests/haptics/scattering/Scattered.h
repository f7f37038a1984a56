#pragma once

#include "haptics/scattering/Scatterer.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <vector>

namespace midair::test
{

constexpr double kWavelength_m = 8.58e-3;

/// A ball of triangles without an edge over \a longest_m, of the volume of a ball of \a radius_m:
/// each face of an icosahedron in a lattice.
inline haptics::TriangleMesh ballOf(double radius_m, double longest_m)
{
    const double t = 0.5 * (1.0 + std::sqrt(5.0));
    const std::vector<Eigen::Vector3d> corners = {{-1, t, 0},
                                                  {1, t, 0},
                                                  {-1, -t, 0},
                                                  {1, -t, 0},
                                                  {0, -1, t},
                                                  {0, 1, t},
                                                  {0, -1, -t},
                                                  {0, 1, -t},
                                                  {t, 0, -1},
                                                  {t, 0, 1},
                                                  {-t, 0, -1},
                                                  {-t, 0, 1}};
    constexpr int kFaces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                   {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                   {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                   {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const int steps = static_cast<int>(std::ceil(1.46 * radius_m / longest_m));
    std::map<std::array<long, 3>, int> known;
    std::vector<Eigen::Vector3d> vertices;
    const auto number = [&](const Eigen::Vector3d& place)
    {
        const Eigen::Vector3d on = place.normalized() * radius_m;
        const std::array<long, 3> key = {
            std::lround(on.x() * 1e9), std::lround(on.y() * 1e9), std::lround(on.z() * 1e9)};
        const auto [found, isNew] = known.emplace(key, static_cast<int>(vertices.size()));
        if (isNew) vertices.push_back(on);
        return found->second;
    };
    std::vector<Eigen::Vector3i> triangles;
    for (const auto& face : kFaces)
    {
        const Eigen::Vector3d &a = corners[face[0]], &b = corners[face[1]], &c = corners[face[2]];
        const auto at = [&](int i, int j)
        { return number(a + (b - a) * i / steps + (c - a) * j / steps); };
        for (int i = 0; i < steps; ++i)
            for (int j = 0; i + j < steps; ++j)
            {
                triangles.emplace_back(at(i, j), at(i + 1, j), at(i, j + 1));
                if (i + j + 1 < steps)
                    triangles.emplace_back(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
    }
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
        mesh.vertices.col(static_cast<Eigen::Index>(i)) = vertices[i];
    mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    double volume = 0.0;
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
        mesh.triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
        const Eigen::Vector3d a = vertices[triangles[i][0]], b = vertices[triangles[i][1]],
                              c = vertices[triangles[i][2]];
        volume += a.dot(b.cross(c)) / 6.0;
    }
    mesh.vertices *= std::cbrt(4.0 / 3.0 * M_PI * std::pow(radius_m, 3) / std::abs(volume));
    return mesh;
}

/// A box from 0 to \a size, closed.
inline haptics::TriangleMesh boxOf(const Eigen::Vector3d& size)
{
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, 8);
    for (int i = 0; i < 8; ++i)
        mesh.vertices.col(i) =
            size.cwiseProduct(Eigen::Vector3d(i & 1, (i >> 1) & 1, (i >> 2) & 1));
    mesh.triangles.resize(3, 12);
    mesh.triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1, //
        2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,               //
        3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
    return mesh;
}

/// The field e^{-jkr}/r of a source at \a source on the elements of \a scatterer.
inline haptics::IncidentField
fieldOf(const Eigen::Vector3d& source, double k, const haptics::Scatterer& scatterer)
{
    const Eigen::Index n = scatterer.places().cols();
    haptics::IncidentField field{Eigen::VectorXcd(n), Eigen::VectorXcd(n)};
    for (Eigen::Index i = 0; i < n; ++i)
    {
        const Eigen::Vector3d d = scatterer.places().col(i) - source;
        const double r = d.norm();
        field.pressure_Pa[i] = std::polar(1.0 / r, -k * r);
        field.slope_Pa_m[i] = -std::complex<double>(1.0 / r, k) * field.pressure_Pa[i] *
                              d.dot(scatterer.normals().col(i)) / r;
    }
    return field;
}

} // namespace midair::test
