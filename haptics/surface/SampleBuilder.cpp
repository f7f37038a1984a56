#include "haptics/surface/SampleBuilder.h"

#include "haptics/base/InputError.h"

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Margin for the rounding of coordinates, so that distances measured later are never below the
/// spacing.
constexpr double kSafety = 1.0 + 1e-9;

} // namespace

SampleBuilder::SampleBuilder(const TriangleMesh& mesh,
                             const MeshTopology& topology,
                             const SamplerOptions& options) :
    _mesh(mesh),
    _topology(topology),
    _options(options),
    _look(options.stop),
    _points(options.spacing_m * 1.05)
{
    _samples.normalStart.push_back(0);
}

bool SampleBuilder::place(int meshTriangle, const Eigen::Vector3d& barycentric, double radius)
{
    look();
    const Eigen::Vector3d point = pointOnTriangle(_mesh, meshTriangle, barycentric);
    if (_points.anyNear(point, radius * kSafety)) return false;
    if (_points.size() >= _options.maxPoints) throwTooManyPoints(_topology, _options);
    _points.insert(point);
    _samples.triangle.push_back(meshTriangle);
    _barycentrics.push_back(barycentric);
    return true;
}

void SampleBuilder::addNormal(int meshTriangle, double weight)
{
    _samples.normalTriangle.push_back(meshTriangle);
    _samples.normalWeight.push_back(weight);
}

bool SampleBuilder::tryFace(int triangle, const Eigen::Vector3d& barycentric, double radius)
{
    const int meshTriangle = _topology.triangles[static_cast<std::size_t>(triangle)];
    if (!place(meshTriangle, barycentric, radius)) return false;
    addNormal(meshTriangle, 1.0);
    _samples.normalStart.push_back(static_cast<int>(_samples.normalTriangle.size()));
    return true;
}

Eigen::Vector3d SampleBuilder::edgeBarycentric(const FeatureEdge& edge, double fraction) const
{
    const EdgeFace& face = _topology.edgeFaces[static_cast<std::size_t>(edge.firstFace)];
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
    const double atCorner = face.reversed ? fraction : 1.0 - fraction;
    barycentric[face.corner] = atCorner;
    barycentric[(face.corner + 1) % 3] = 1.0 - atCorner;
    return barycentric;
}

Eigen::Vector3d SampleBuilder::edgePoint(const FeatureEdge& edge, double fraction) const
{
    const EdgeFace& face = _topology.edgeFaces[static_cast<std::size_t>(edge.firstFace)];
    return pointOnTriangle(_mesh,
                           _topology.triangles[static_cast<std::size_t>(face.triangle)],
                           edgeBarycentric(edge, fraction));
}

bool SampleBuilder::tryEdge(const FeatureEdge& edge, double fraction, double radius)
{
    const EdgeFace* faces = &_topology.edgeFaces[static_cast<std::size_t>(edge.firstFace)];
    const int meshTriangle = _topology.triangles[static_cast<std::size_t>(faces[0].triangle)];
    if (!place(meshTriangle, edgeBarycentric(edge, fraction), radius)) return false;
    for (int i = 0; i < edge.faceCount; ++i)
    {
        addNormal(_topology.triangles[static_cast<std::size_t>(faces[i].triangle)], faces[i].sign);
    }
    _samples.normalStart.push_back(static_cast<int>(_samples.normalTriangle.size()));
    return true;
}

Eigen::Vector3d SampleBuilder::vertexPoint(int vertex) const
{
    const int fan =
        _topology
            .fan[static_cast<std::size_t>(_topology.fanStart[static_cast<std::size_t>(vertex)])];
    const int t = _topology.triangles[static_cast<std::size_t>(fan / 3)];
    return _mesh.vertices.col(_mesh.triangles(fan % 3, t));
}

bool SampleBuilder::tryVertex(int vertex, double radius)
{
    const auto v = static_cast<std::size_t>(vertex);
    const int begin = _topology.fanStart[v];
    const int end = _topology.fanStart[v + 1];
    if (begin == end) return false; // the vertex is used only by triangles without area
    const int first = _topology.fan[static_cast<std::size_t>(begin)];
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
    barycentric[first % 3] = 1.0;
    const int meshTriangle = _topology.triangles[static_cast<std::size_t>(first / 3)];
    if (!place(meshTriangle, barycentric, radius)) return false;
    for (int i = begin; i < end; ++i)
    {
        const int fan = _topology.fan[static_cast<std::size_t>(i)];
        const int t = _topology.triangles[static_cast<std::size_t>(fan / 3)];
        const Eigen::Vector3i corners = _mesh.triangles.col(t);
        addNormal(t,
                  cornerAngle(_mesh.vertices.col(corners[fan % 3]),
                              _mesh.vertices.col(corners[(fan + 1) % 3]),
                              _mesh.vertices.col(corners[(fan + 2) % 3])));
    }
    _samples.normalStart.push_back(static_cast<int>(_samples.normalTriangle.size()));
    return true;
}

SurfaceSamples SampleBuilder::finish()
{
    const auto n = static_cast<Eigen::Index>(_barycentrics.size());
    _samples.positions.resize(3, n);
    _samples.normals.setZero(3, n);
    _samples.barycentric.resize(3, n);
    _samples.intensity.setOnes(n);
    for (Eigen::Index i = 0; i < n; ++i)
    {
        const auto index = static_cast<std::size_t>(i);
        _samples.barycentric.col(i) = _barycentrics[index];
    }
    updateSamples(_mesh, _samples);
    return std::move(_samples);
}

double estimatePoints(const MeshTopology& topology, const SamplerOptions& options, double scale)
{
    const double r = options.spacing_m * scale;
    const double edge = (options.edgeSpacing_m > 0.0 ? options.edgeSpacing_m : options.spacing_m);
    const double alongEdges = topology.featureLength / (edge * scale);
    switch (options.sampling)
    {
    case Sampling::EDGES:
        return alongEdges;
    case Sampling::VERTICES:
        return std::min<double>(topology.vertexCount, 0.72 * topology.area / r / r);
    default:
        break;
    }
    return 0.72 * topology.area / r / r + 0.5 * alongEdges;
}

void throwTooManyPoints(const MeshTopology& topology, const SamplerOptions& options)
{
    // The estimate may be below the number of points already placed; the message must not be.
    const double estimate = std::max(estimatePoints(topology, options, 1.0),
                                     1.1 * static_cast<double>(options.maxPoints));
    double scale = 1.0;
    while (estimatePoints(topology, options, scale) > 0.7 * options.maxPoints && scale < 1e30)
    {
        scale *= 1.05;
    }
    scale = std::max(scale, 1.25);
    const auto spacings = [&options](double factor)
    {
        std::string text = fmt::format("{:.3g} m", factor * options.spacing_m);
        if (options.edgeSpacing_m > 0.0)
            text += fmt::format(" ({:.3g} m along edges)", factor * options.edgeSpacing_m);
        return text;
    };
    throw base::InputError(fmt::format("A spacing of {} needs about {:.3g} points on this mesh; at "
                                       "most {} are allowed; a spacing of {} or more would do",
                                       spacings(1.0),
                                       estimate,
                                       options.maxPoints,
                                       spacings(scale)));
}

} // namespace midair::haptics
