#pragma once

#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/PointGrid.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Returns the point of a triangle with these barycentric coordinates. All samples are computed
/// here, so an undeformed mesh gives bit-identical positions.
inline Eigen::Vector3d
pointOnTriangle(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& barycentric)
{
    const Eigen::Vector3i v = mesh.triangles.col(triangle);
    return barycentric[0] * mesh.vertices.col(v[0]) + barycentric[1] * mesh.vertices.col(v[1]) +
           barycentric[2] * mesh.vertices.col(v[2]);
}

/// Collects samples at a minimum distance: each try places a point only if no other is within its
/// radius.
class SampleBuilder
{
public:
    SampleBuilder(const TriangleMesh& mesh,
                  const MeshTopology& topology,
                  const SamplerOptions& options);

    /// Tries a point on a face. \a triangle: index into MeshTopology::triangles. All tries return
    /// true if the point was placed, and throw InputError beyond SamplerOptions::maxPoints.
    bool tryFace(int triangle, const Eigen::Vector3d& barycentric, double radius);
    /// Tries a point at \a fraction of the length from FeatureEdge::from to FeatureEdge::to.
    bool tryEdge(const FeatureEdge& edge, double fraction, double radius);
    /// Tries a point at a welded vertex.
    bool tryVertex(int vertex, double radius);

    Eigen::Vector3d edgePoint(const FeatureEdge& edge, double fraction) const;
    Eigen::Vector3d vertexPoint(int vertex) const;

    /// For long loops without a try: throws Stopped if the options' token requests it.
    void look() { _look.turn(); }

    const PointGrid& points() const { return _points; }
    const TriangleMesh& mesh() const { return _mesh; }
    const MeshTopology& topology() const { return _topology; }
    const SamplerOptions& options() const { return _options; }
    double spacing() const { return _options.spacing_m; }
    double edgeSpacing() const
    {
        return _options.edgeSpacing_m > 0.0 ? _options.edgeSpacing_m : _options.spacing_m;
    }

    SurfaceSamples finish();

private:
    bool place(int meshTriangle, const Eigen::Vector3d& barycentric, double radius);
    void addNormal(int meshTriangle, double weight);
    Eigen::Vector3d edgeBarycentric(const FeatureEdge& edge, double fraction) const;

    const TriangleMesh& _mesh;
    const MeshTopology& _topology;
    const SamplerOptions& _options;
    base::StopLook _look;
    PointGrid _points;
    SurfaceSamples _samples; ///< without the matrices, which finish() fills
    std::vector<Eigen::Vector3d> _barycentrics;
};

/// Throws the InputError with the number of points and a spacing that would work.
[[noreturn]] void throwTooManyPoints(const MeshTopology& topology, const SamplerOptions& options);

/// Estimates the number of points of a mesh: a maximal set of spacing r has about 0.72 area/r^2.
double estimatePoints(const MeshTopology& topology, const SamplerOptions& options, double scale);

} // namespace midair::haptics
