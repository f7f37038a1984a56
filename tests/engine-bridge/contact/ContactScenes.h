#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactFinder.h"
#include "engine-bridge/hands/Hand.h"

#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <vector>

namespace midair::bridge::test
{

/// A sheet in z = 0 of squares of \a cell_m, each cut in two; \a cells along x and y, the middle of
/// the sheet at the origin. Its winding has z up, or down if \a isTurned. Small enough to be
/// prepared at once (TouchMeshes::kAtOnce).
inline std::shared_ptr<const haptics::TriangleMesh>
sheet(int cells = 30, double cell_m = 2e-3, bool isTurned = false)
{
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    const int side = cells + 1;
    mesh->vertices.resize(3, side * side);
    mesh->triangles.resize(3, 2 * cells * cells);
    int t = 0;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
        {
            const int v = j * side + i;
            mesh->vertices.col(v) = cell_m * Eigen::Vector3d(i - 0.5 * cells, j - 0.5 * cells, 0.0);
            if (i == cells || j == cells) continue;
            Eigen::Vector3i a(v, v + 1, v + side + 1), b(v, v + side + 1, v + side);
            if (isTurned)
            {
                std::swap(a[1], a[2]);
                std::swap(b[1], b[2]);
            }
            mesh->triangles.col(t++) = a;
            mesh->triangles.col(t++) = b;
        }
    return mesh;
}

/// A closed plate: two sheets \a thick_m apart and a rim; its top in z = 0.
inline std::shared_ptr<const haptics::TriangleMesh> plate(double thick_m, int cells = 16)
{
    const auto top = sheet(cells), bottom = sheet(cells, 2e-3, true);
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    const Eigen::Index n = top->vertices.cols(), t = top->triangles.cols();
    mesh->vertices.resize(3, 2 * n);
    mesh->vertices << top->vertices, bottom->vertices;
    mesh->vertices.rightCols(n).row(2).array() -= thick_m;
    mesh->triangles.resize(3, 2 * t + 8 * cells);
    mesh->triangles.leftCols(t) = top->triangles;
    mesh->triangles.middleCols(t, t) = bottom->triangles.array() + static_cast<int>(n);
    const int side = cells + 1;
    std::vector<int> rim; // anticlockwise, seen from above
    for (int i = 0; i < cells; ++i)
        rim.push_back(i);
    for (int i = 0; i < cells; ++i)
        rim.push_back(i * side + cells);
    for (int i = cells; i > 0; --i)
        rim.push_back(cells * side + i);
    for (int i = cells; i > 0; --i)
        rim.push_back(i * side);
    Eigen::Index next = 2 * t;
    for (std::size_t i = 0; i < rim.size(); ++i)
    {
        const int a = rim[i], b = rim[(i + 1) % rim.size()], down = static_cast<int>(n);
        mesh->triangles.col(next++) = Eigen::Vector3i(a, a + down, b + down);
        mesh->triangles.col(next++) = Eigen::Vector3i(a, b + down, b);
    }
    return mesh;
}

inline HapticObject object(std::shared_ptr<const haptics::TriangleMesh> mesh,
                           std::uint64_t id = 1,
                           const Eigen::Isometry3d& pose = Eigen::Isometry3d::Identity())
{
    HapticObject result;
    result.id = id;
    result.meshId = id;
    result.mesh = std::move(mesh);
    result.pose = pose;
    return result;
}

/// Adds the last bone of a finger, whose tip is \a tip, from \a from to \a to; nothing else of the
/// hand is tracked.
inline void addBone(Hand& hand,
                    HandJointName tip,
                    const Eigen::Vector3d& from,
                    const Eigen::Vector3d& to,
                    double radius_m = 8e-3)
{
    const auto joint = [&](const Eigen::Vector3d& place) {
        return HandJoint{place, Eigen::Quaterniond::Identity(), radius_m, true, true};
    };
    hand.joints[static_cast<std::size_t>(tip) - 1] = joint(from);
    hand.joints[static_cast<std::size_t>(tip)] = joint(to);
}

/// One ball of a finger with its middle at \a place.
inline HandFrame ball(const Eigen::Vector3d& place, double radius_m = 8e-3)
{
    HandFrame frame;
    frame.hands.resize(1);
    addBone(frame.hands[0], INDEX_TIP, place, place, radius_m);
    return frame;
}

} // namespace midair::bridge::test
