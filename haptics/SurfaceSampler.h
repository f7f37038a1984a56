#pragma once

#include "haptics/TriangleMesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

enum class Sampling
{
    SURFACE, ///< corners, then feature edges, then faces
    EDGES,   ///< feature and boundary edges only
    VERTICES ///< the (welded) vertices themselves
};

struct SamplerOptions
{
    double spacing_m =
        8.5e-3; ///< > 0; smallest distance between two points; callers take it from c(T)/f
    Sampling sampling = Sampling::SURFACE;
    double creaseAngle_rad =
        0.61; ///< 0 .. pi; an edge whose faces turn by more is a feature (about 35 degrees)
    std::uint64_t seed = 1;

    bool isValid(std::string* error = nullptr) const;
};

/// Points on a mesh, held by triangle and barycentrics so that a deformed mesh moves them.
struct SurfaceSamples
{
    Eigen::Matrix3Xd positions;   ///< 3 x n, metres, mesh frame
    Eigen::Matrix3Xd normals;     ///< 3 x n, unit length
    std::vector<int> triangle;    ///< n
    Eigen::Matrix3Xd barycentric; ///< 3 x n, each column sums to 1
    Eigen::VectorXf intensity;    ///< n, 1 where the mesh has none

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Features first, then faces: every point on the surface, no two nearer than the spacing, no spot of the surface
/// farther than 1.1 spacings from a point (SURFACE). The same mesh and options give the same points.
/// Throws InputError for options out of range, NaN vertices, and meshes without a triangle of positive area.
SurfaceSamples sampleSurface(const TriangleMesh& mesh, const SamplerOptions& options);

} // namespace midair::haptics
