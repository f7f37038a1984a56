#pragma once

#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

/// Meshes with known shapes, and slow checks of samples written apart from the sampler.
namespace midair::haptics::test
{

inline TriangleMesh makeMesh(const std::vector<Eigen::Vector3d>& vertices,
                             const std::vector<Eigen::Vector3i>& triangles)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
        mesh.vertices.col(static_cast<Eigen::Index>(i)) = vertices[i];
    }
    mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
        mesh.triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
    }
    return mesh;
}

/// Each triangle in four.
inline TriangleMesh subdivided(const TriangleMesh& mesh)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3i> triangles;
    for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v)
        vertices.push_back(mesh.vertices.col(v));
    for (const auto& t : mesh.triangles.colwise())
    {
        // The middles are doubled at each edge: the sampler has to weld them.
        const int first = static_cast<int>(vertices.size());
        for (int k = 0; k < 3; ++k)
        {
            vertices.emplace_back(0.5 * (mesh.vertices.col(std::min(t[k], t[(k + 1) % 3])) +
                                         mesh.vertices.col(std::max(t[k], t[(k + 1) % 3]))));
        }
        triangles.emplace_back(t[0], first, first + 2);
        triangles.emplace_back(first, t[1], first + 1);
        triangles.emplace_back(first + 2, first + 1, t[2]);
        triangles.emplace_back(first, first + 1, first + 2);
    }
    return makeMesh(vertices, triangles);
}

/// Axis-aligned, centred, 12 triangles.
inline TriangleMesh box(const Eigen::Vector3d& size)
{
    std::vector<Eigen::Vector3d> vertices;
    for (int i = 0; i < 8; ++i)
    {
        vertices.emplace_back(size.x() * ((i & 1) - 0.5),
                              size.y() * ((i >> 1 & 1) - 0.5),
                              size.z() * ((i >> 2 & 1) - 0.5));
    }
    return makeMesh(vertices,
                    {{0, 2, 1},
                     {1, 2, 3},
                     {4, 5, 6},
                     {5, 7, 6},
                     {0, 1, 4},
                     {1, 5, 4},
                     {2, 6, 3},
                     {3, 6, 7},
                     {0, 4, 2},
                     {2, 4, 6},
                     {1, 3, 5},
                     {3, 7, 5}});
}

/// An octahedron subdivided \a levels times and blown up to \a radius.
inline TriangleMesh sphere(double radius, int levels)
{
    TriangleMesh mesh = makeMesh(
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
    for (int i = 0; i < levels; ++i)
        mesh = subdivided(mesh);
    mesh.vertices.colwise().normalize();
    mesh.vertices *= radius;
    return mesh;
}

/// A flat disc as a fan of \a sides triangles: its boundary is a circle.
inline TriangleMesh disc(double radius, int sides)
{
    std::vector<Eigen::Vector3d> vertices = {Eigen::Vector3d::Zero()};
    std::vector<Eigen::Vector3i> triangles;
    for (int i = 0; i < sides; ++i)
    {
        const double angle = 2.0 * M_PI * i / sides;
        vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
        triangles.emplace_back(0, i + 1, (i + 1) % sides + 1);
    }
    return makeMesh(vertices, triangles);
}

/// Triangles of random corners in a cube: they cross, are of all sizes, and share nothing.
inline TriangleMesh triangleSoup(double size, int count, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-0.5 * size, 0.5 * size);
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3i> triangles;
    for (int i = 0; i < count; ++i)
    {
        const Eigen::Vector3d middle(coordinate(random), coordinate(random), coordinate(random));
        const double scale = std::pow(10.0, -3.0 * i / count);
        for (int k = 0; k < 3; ++k)
        {
            vertices.emplace_back(middle + scale * Eigen::Vector3d(coordinate(random),
                                                                   coordinate(random),
                                                                   coordinate(random)));
        }
        triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    return makeMesh(vertices, triangles);
}

/// m; by trying all pairs.
inline double smallestDistance(const Eigen::Matrix3Xd& points)
{
    double smallest = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < points.cols(); ++i)
    {
        for (Eigen::Index j = 0; j < i; ++j)
        {
            smallest = std::min(smallest, (points.col(i) - points.col(j)).norm());
        }
    }
    return smallest;
}

/// m; of the closest point of the triangle, by minimising over the plane, the edges and the corners
/// in turn.
inline double distanceToTriangle(const Eigen::Vector3d& point,
                                 const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c)
{
    double best = std::min({(point - a).norm(), (point - b).norm(), (point - c).norm()});
    const auto edge = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to)
    {
        const double length2 = (to - from).squaredNorm();
        if (!(length2 > 0.0)) return;
        const double t = (point - from).dot(to - from) / length2;
        if (t > 0.0 && t < 1.0) best = std::min(best, (point - from - t * (to - from)).norm());
    };
    edge(a, b);
    edge(b, c);
    edge(c, a);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const bool inside = (b - a).cross(point - a).dot(normal) >= 0.0 &&
                        (c - b).cross(point - b).dot(normal) >= 0.0 &&
                        (a - c).cross(point - c).dot(normal) >= 0.0;
    if (inside && normal.norm() > 0.0)
    {
        best = std::min(best, std::abs((point - a).dot(normal.normalized())));
    }
    return best;
}

/// m; the farthest that a point is from all triangles.
inline double farthestOffSurface(const TriangleMesh& mesh, const Eigen::Matrix3Xd& points)
{
    double farthest = 0.0;
    for (const auto& point : points.colwise())
    {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& t : mesh.triangles.colwise())
        {
            nearest = std::min(nearest,
                               distanceToTriangle(point,
                                                  mesh.vertices.col(t[0]),
                                                  mesh.vertices.col(t[1]),
                                                  mesh.vertices.col(t[2])));
        }
        farthest = std::max(farthest, nearest);
    }
    return farthest;
}

/// m; the farthest that a spot of the surface is from all points; spots are a lattice of at most \a
/// step on each triangle, its corners included.
inline double largestGap(const TriangleMesh& mesh, const Eigen::Matrix3Xd& points, double step)
{
    double largest2 = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Eigen::Vector3d a = mesh.vertices.col(t[0]);
        const Eigen::Vector3d ab = mesh.vertices.col(t[1]) - a;
        const Eigen::Vector3d ac = mesh.vertices.col(t[2]) - a;
        if (!(ab.cross(ac).norm() > 1e-10 * std::max(ab.squaredNorm(), ac.squaredNorm()))) continue;
        const int rows = std::max(1, static_cast<int>(std::ceil(ab.norm() / step)));
        const int columns = std::max(1, static_cast<int>(std::ceil(ac.norm() / step)));
        for (int i = 0; i <= rows; ++i)
        {
            for (int j = 0; j <= columns; ++j)
            {
                const double u = static_cast<double>(i) / rows;
                const double v = (1.0 - u) * j / columns;
                const Eigen::Vector3d spot = a + u * ab + v * ac;
                largest2 = std::max(largest2,
                                    (points.colwise() - spot).colwise().squaredNorm().minCoeff());
            }
        }
    }
    return std::sqrt(largest2);
}

} // namespace midair::haptics::test
