#pragma once

#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/PointGrid.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// The point of a triangle with these barycentric coordinates. All samples are placed through it,
/// so that a mesh that was not deformed gives back the same bits.
inline Eigen::Vector3d
pointOnTriangle(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& barycentric)
{
    const Eigen::Vector3i v = mesh.triangles.col(triangle);
    return barycentric[0] * mesh.vertices.col(v[0]) + barycentric[1] * mesh.vertices.col(v[1]) +
           barycentric[2] * mesh.vertices.col(v[2]);
}

/// Collects samples and keeps them apart: each try places a point only where none is nearer than
/// asked.
class SampleBuilder
{
public:
    SampleBuilder(const TriangleMesh& mesh,
                  const MeshTopology& topology,
                  const SamplerOptions& options);

    /// \a triangle is an index into MeshTopology::triangles. The tries return true where the point
    /// was placed and throw InputError beyond SamplerOptions::maxPoints.
    bool tryFace(int triangle, const Eigen::Vector3d& barycentric, double radius);
    /// At \a fraction of the way from FeatureEdge::from to FeatureEdge::to.
    bool tryEdge(const FeatureEdge& edge, double fraction, double radius);
    /// At a welded vertex.
    bool tryVertex(int vertex, double radius);

    Eigen::Vector3d edgePoint(const FeatureEdge& edge, double fraction) const;
    Eigen::Vector3d vertexPoint(int vertex) const;

    /// For loops that may turn long without a try: throws Stopped where the options' token asks for
    /// it.
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
    SurfaceSamples _samples; ///< all but the matrices
    std::vector<Eigen::Vector3d> _barycentrics;
};

/// Throws the InputError that tells how many points there would be and which spacing would do.
[[noreturn]] void throwTooManyPoints(const MeshTopology& topology, const SamplerOptions& options);

/// About how many points a mesh takes: a maximal set of spacing r has about 0.72 area/r^2.
double estimatePoints(const MeshTopology& topology, const SamplerOptions& options, double scale);

} // namespace midair::haptics
