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
    SURFACE,  ///< corners, then feature edges, then faces
    EDGES,    ///< feature and boundary edges only
    VERTICES, ///< the welded vertices
    POINTS    ///< the first corner of every triangle, unchanged, at any distance from others
};

/// Options for sampling a surface.
struct SamplerOptions
{
    /// > 0, metres; minimum distance between two points. Callers derive it from the wavelength.
    double spacing_m = 8.5e-3;
    Sampling sampling = Sampling::SURFACE;
    /// 0 .. pi; an edge is a feature if the angle between its faces' normals is larger. Default:
    /// about 35 degrees.
    double creaseAngle_rad = 0.61;
    /// Seed of the random points on faces.
    std::uint64_t seed = 1;
    /// 0 .. spacing_m, metres; minimum distance between points on boundaries and creases. 0:
    /// spacing_m.
    double edgeSpacing_m = 0.0;
    int maxPoints = 20000; ///< >= 1; a mesh that needs more is refused
    base::StopToken stop;  ///< on its request Stopped is thrown

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Points on a mesh, stored by triangle and barycentric coordinates, so that they can follow a
/// deformed mesh.
struct SurfaceSamples
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres, mesh frame
    /// 3 x n, unit length; on the side given by the mesh's winding; zero on lines and at points
    Eigen::Matrix3Xd normals;
    std::vector<int> triangle;    ///< n
    Eigen::Matrix3Xd barycentric; ///< 3 x n, each column sums to 1
    Eigen::VectorXf intensity;    ///< n; 1 if the mesh has none

    /// Normal i is the weighted sum of the normals of the triangles from
    /// normalTriangle[normalStart[i]] to before normalTriangle[normalStart[i + 1]]: one inside a
    /// face, two on an edge, all around a vertex, weighted by their angles.
    std::vector<int> normalStart; ///< n + 1
    std::vector<int> normalTriangle;
    /// of the same length; negative if windings contradict each other
    std::vector<double> normalWeight;

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Samples a surface: first corners, convex tips before notches (of corners closer than the spacing
/// the sharper one is kept), then creases and boundaries in equal steps, then faces. The straight
/// distance of two points is at least spacing_m (edgeSpacing_m if both are on features). SURFACE:
/// every place on the surface is within 1.1 spacings of a point. EDGES: every place on a feature
/// edge is within 1.1 edge spacings. VERTICES: corners first, then by vertex number, those that
/// keep the spacing. POINTS: one per triangle, at any distance; for meshes of points. Equal meshes
/// and options give equal points. A mesh smaller than the spacing gets one point. Degenerate
/// triangles are sampled as lines and points (see TriangleMesh): lines are features and get the
/// points of creases, points are corners; both have zero normals. Throws InputError for options out
/// of range, NaN vertices, indices out of range, meshes without triangles, more than maxPoints
/// points (with a spacing that would work) or kMostTriangles triangles, and for EDGES on a mesh
/// without features.
SurfaceSamples sampleSurface(const TriangleMesh& mesh, const SamplerOptions& options);

/// Makes \a count sets of nearly equal size on the same surface, each as sampleSurface() would, in
/// the gaps of the sets before it: their fields, played in turn, smooth the surface. The first set
/// is that of sampleSurface(); the others are shifted along the features and leave the corners to
/// the first. \a count: 1 .. 1024; with VERTICES and POINTS there is only one set. Throws as
/// sampleSurface() does.
std::vector<SurfaceSamples>
sampleSurfaceSets(const TriangleMesh& mesh, const SamplerOptions& options, int count);

/// Returns samples as sampleSurface() does, in the gaps of its samples (with VERTICES and POINTS
/// the same): a field that was evened out at those is better there than elsewhere, so it is
/// measured here. Takes twice as long.
SurfaceSamples sampleBetween(const TriangleMesh& mesh, const SamplerOptions& options);

/// Moves the samples with their mesh: recomputes positions, normals and intensities without
/// allocation. \a deformed must have the triangles of the sampled mesh. A normal that is undefined
/// on the deformed mesh (no area left) stays unchanged. Throws InputError if a sample's triangle or
/// vertices do not exist.
void updateSamples(const TriangleMesh& deformed, SurfaceSamples& samples);

} // namespace midair::haptics
