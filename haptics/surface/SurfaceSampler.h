#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/surface/TriangleMesh.h"

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

/// How a surface is sampled; isValid() names the first setting that is out of its range.
struct SamplerOptions
{
    /// > 0, metres; the smallest distance between two points. Callers take it from the wavelength.
    double spacing_m = 8.5e-3;
    Sampling sampling = Sampling::SURFACE;
    /// 0 .. pi; an edge whose faces turn by more is a feature. The default is about 35 degrees.
    double creaseAngle_rad = 0.61;
    std::uint64_t seed = 1;
    /// 0 .. spacing_m; the smallest distance along outlines and creases. 0: spacing_m.
    double edgeSpacing_m = 0.0;
    int maxPoints = 20000; ///< >= 1; a mesh that needs more is refused
    base::StopToken stop;  ///< where it asks for that, Stopped is thrown

    bool isValid(std::string* error = nullptr) const;
};

/// Points on a mesh, held by triangle and barycentrics so that a deformed mesh moves them.
struct SurfaceSamples
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres, mesh frame
    Eigen::Matrix3Xd normals; ///< 3 x n, unit length; which side is out is up to the mesh's winding
    std::vector<int> triangle;    ///< n
    Eigen::Matrix3Xd barycentric; ///< 3 x n, each column sums to 1
    Eigen::VectorXf intensity;    ///< n, 1 where the mesh has none

    /// A normal is the weighted sum of those of the triangles normalTriangle[normalStart[i] ..
    /// normalStart[i + 1]): one inside a face, two on an edge, all around a vertex by their angles.
    std::vector<int> normalStart; ///< n + 1
    std::vector<int> normalTriangle;
    std::vector<double> normalWeight; ///< as long; negative where windings contradict each other

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Samples a surface, features first, then faces. Corners come before everything else, convex tips
/// before notches (of corners nearer to each other than the spacing the sharper one is kept), then
/// equal steps along creases and boundaries, then the faces. No two points are nearer than
/// spacing_m (two on features: edgeSpacing_m), by straight distance.
/// SURFACE: no place on the surface is farther than 1.1 spacings from a point. EDGES: no place on a
/// feature edge is farther than 1.1 edge spacings. VERTICES: corners first, then by vertex number,
/// each that keeps the spacing. The same mesh and options give the same points. A mesh smaller than
/// the spacing gets one point.
/// Throws InputError for options out of range, NaN vertices, indices out of range, meshes without a
/// triangle of positive area, more than maxPoints points (with a spacing that would do) or
/// kMostTriangles triangles, and for EDGES on a mesh without features.
SurfaceSamples sampleSurface(const TriangleMesh& mesh, const SamplerOptions& options);

/// \a count sets of nearly equal size on the same surface, each as sampleSurface promises, each in
/// the gaps of those before it: fields for them, played in turn, smooth the surface. The first is
/// sampleSurface's; the others step along the features with a shift and leave the corners to the
/// first. \a count is 1 .. 1024. VERTICES has one set only. Throws as sampleSurface does.
std::vector<SurfaceSamples>
sampleSurfaceSets(const TriangleMesh& mesh, const SamplerOptions& options, int count);

/// Moves the samples with their mesh: positions, normals and intensities anew, nothing allocated.
/// \a deformed has the triangles of the mesh that was sampled. A normal that the deformed mesh
/// doesn't define (no area left) stays as it was. Throws InputError where a sample's triangle or
/// vertices are not there.
void updateSamples(const TriangleMesh& deformed, SurfaceSamples& samples);

} // namespace midair::haptics
