#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <cmath>
#include <memory>

/// A sphere of rings of quadrangles from pole to pole, each cut in two; 4 rings^2 triangles.
inline std::shared_ptr<midair::haptics::TriangleMesh> sphere(double radius, int rings)
{
    auto mesh = std::make_shared<midair::haptics::TriangleMesh>();
    const int around = 2 * rings;
    mesh->vertices.resize(3, (rings + 1) * around);
    mesh->triangles.resize(3, 2 * rings * around);
    int t = 0;
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i < around; ++i)
        {
            const double theta = M_PI * j / rings;
            const double phi = 2.0 * M_PI * i / around;
            mesh->vertices.col(j * around + i) =
                radius * Eigen::Vector3d(std::sin(theta) * std::cos(phi),
                                         std::sin(theta) * std::sin(phi),
                                         std::cos(theta));
            if (j == rings) continue;
            const int a = j * around + i;
            const int b = j * around + (i + 1) % around;
            mesh->triangles.col(t++) = Eigen::Vector3i(a, a + around, b + around);
            mesh->triangles.col(t++) = Eigen::Vector3i(a, b + around, b);
        }
    return mesh;
}
