#include "haptics/surface/SurfaceSampler.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/SampleBuilder.h"
#include "haptics/surface/SurfacePasses.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Data that all sample sets of one mesh share.
struct SampledMesh
{
    const TriangleMesh& mesh;
    const SamplerOptions& options;
    MeshTopology topology;
    std::vector<int> corners;
    std::vector<FeatureChain> chains;
};

/// Refuses at once meshes that would otherwise be refused after minutes of placing points.
void checkExtent(const SampledMesh& sampled)
{
    const MeshTopology& topology = sampled.topology;
    const SamplerOptions& options = sampled.options;
    // For coincident sheets the estimate is twice too large, so only a clear excess is refused.
    constexpr double kClear = 4.0;
    if (options.sampling != Sampling::VERTICES &&
        !(estimatePoints(topology, options, 1.0) <= kClear * options.maxPoints))
    {
        throwTooManyPoints(topology, options);
    }
    double largest = 0.0;
    for (const int t : topology.triangles)
    {
        for (const int v : sampled.mesh.triangles.col(t))
        {
            largest = std::max(largest, sampled.mesh.vertices.col(v).cwiseAbs().maxCoeff());
        }
    }
    const double edge = options.edgeSpacing_m > 0.0 ? options.edgeSpacing_m : options.spacing_m;
    constexpr double kResolution = 1e-9;
    if (edge < kResolution * largest)
    {
        throw base::InputError(
            fmt::format("A spacing of {:g} m is too fine for a mesh that reaches {:g} m from its "
                        "origin; it must be {:g} m or more",
                        edge,
                        largest,
                        kResolution * largest));
    }
}

SampledMesh prepare(const TriangleMesh& mesh, const SamplerOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    SampledMesh sampled{
        mesh,
        options,
        buildTopology(mesh, options.creaseAngle_rad, options.spacing_m, options.stop),
        {},
        {}};
    const std::vector<char>& onFeature = sampled.topology.onFeature;
    if (options.sampling == Sampling::EDGES &&
        std::find(onFeature.begin(), onFeature.end(), 1) == onFeature.end())
    {
        throw base::InputError(
            fmt::format("The mesh has no edges to sample: it is closed and no edge turns by more "
                        "than {:g} degrees; sample its surface, or make the crease angle smaller",
                        base::toDegrees(options.creaseAngle_rad)));
    }
    checkExtent(sampled);
    options.stop.throwIfRequested();
    sampled.corners = findCorners(mesh, sampled.topology, options.creaseAngle_rad);
    options.stop.throwIfRequested();
    sampled.chains = chainFeatures(mesh, sampled.topology, sampled.corners);
    return sampled;
}

/// Makes set number \a set (from 0); \a earlier: the points of the sets before it.
SurfaceSamples
sampleOnce(const SampledMesh& sampled, int set, double shift, const PointGrid* earlier)
{
    const SamplerOptions& options = sampled.options;
    SampleBuilder builder(sampled.mesh, sampled.topology, options);
    for (const int v : sampled.corners)
    {
        // A point can't be shifted, so it is in every set.
        if (set > 0 && !sampled.topology.hasPoint(v)) continue;
        // With EDGES, tips without a feature edge are left out.
        if (options.sampling == Sampling::EDGES && !sampled.topology.hasFeature(v)) continue;
        builder.tryVertex(v, builder.edgeSpacing());
    }
    if (options.sampling == Sampling::VERTICES)
    {
        for (int v = 0; v < sampled.topology.vertexCount; ++v)
        {
            builder.tryVertex(v, builder.spacing());
        }
        return builder.finish();
    }
    placeChains(builder, sampled.chains, shift);
    fillEdges(builder);
    if (options.sampling == Sampling::SURFACE)
    {
        std::mt19937_64 random(options.seed + 0x9E3779B97F4A7C15ULL * static_cast<unsigned>(set));
        throwDarts(builder, random, earlier);
        fillFaces(builder);
    }
    return builder.finish();
}

/// 0, 1/2, 1/4, 3/4, 1/8, ...: every prefix is spread evenly (van der Corput, 1935).
double radicalInverse(unsigned index)
{
    double value = 0.0;
    for (double digit = 0.5; index != 0; digit *= 0.5, index >>= 1U)
    {
        if ((index & 1U) != 0) value += digit;
    }
    return value;
}

/// One sample for each triangle, at its first corner.
SurfaceSamples everyPoint(const TriangleMesh& mesh, const SamplerOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    const Eigen::Index n = mesh.triangles.cols();
    if (n > options.maxPoints)
        throw base::InputError(
            fmt::format("There are {} points; at most {} are allowed", n, options.maxPoints));
    SurfaceSamples samples;
    samples.positions.resize(3, n);
    samples.normals.setZero(3, n);
    samples.intensity.setOnes(n);
    samples.barycentric = Eigen::Vector3d::UnitX().replicate(1, n);
    samples.normalWeight.assign(static_cast<std::size_t>(n), 1.0);
    for (int i = 0; i < n; ++i)
    {
        samples.triangle.push_back(i);
        samples.normalTriangle.push_back(i);
        samples.normalStart.push_back(i);
    }
    samples.normalStart.push_back(static_cast<int>(n));
    updateSamples(mesh, samples);
    return samples;
}

} // namespace

bool SamplerOptions::isValid(std::string* error) const
{
    return base::RangeCheck("SamplerOptions::")
        .above("spacing_m", spacing_m, 0.0)
        .check(creaseAngle_rad >= 0.0 && creaseAngle_rad <= base::kPi,
               "creaseAngle_rad",
               creaseAngle_rad,
               "within 0 .. pi")
        .check(edgeSpacing_m >= 0.0 && edgeSpacing_m <= spacing_m,
               "edgeSpacing_m",
               edgeSpacing_m,
               "within 0 .. spacing_m")
        .atLeast("maxPoints", maxPoints, 1)
        .passed(error);
}

SurfaceSamples sampleSurface(const TriangleMesh& mesh, const SamplerOptions& options)
{
    if (options.sampling == Sampling::POINTS) return everyPoint(mesh, options);
    return sampleOnce(prepare(mesh, options), 0, 0.0, nullptr);
}

std::vector<SurfaceSamples>
sampleSurfaceSets(const TriangleMesh& mesh, const SamplerOptions& options, int count)
{
    constexpr int kMostSets = 1024;
    if (count < 1 || count > kMostSets)
    {
        throw base::InputError(fmt::format(
            "The number of sample sets is {}; it must be in 1 .. {}", count, kMostSets));
    }
    const bool oneSet =
        options.sampling == Sampling::VERTICES || options.sampling == Sampling::POINTS;
    if (count > 1 && oneSet)
    {
        throw base::InputError(fmt::format(
            "A mesh has one set of vertices; {} sample sets need its surface or its edges", count));
    }
    if (options.sampling == Sampling::POINTS) return {everyPoint(mesh, options)};
    const SampledMesh sampled = prepare(mesh, options);
    std::vector<SurfaceSamples> sets;
    sets.reserve(static_cast<std::size_t>(count));
    PointGrid earlier(0.5 * options.spacing_m);
    for (int set = 0; set < count; ++set)
    {
        sets.push_back(sampleOnce(sampled,
                                  set,
                                  radicalInverse(static_cast<unsigned>(set)),
                                  set > 0 ? &earlier : nullptr));
        options.stop.throwIfRequested();
        for (const auto& point : sets.back().positions.colwise())
            earlier.insert(point);
    }
    return sets;
}

void updateSamples(const TriangleMesh& deformed, SurfaceSamples& samples)
{
    for (const int t : samples.normalTriangle)
    {
        if (t >= deformed.triangles.cols())
        {
            throw base::InputError(
                fmt::format("The samples refer to triangle {}; the deformed mesh has {}",
                            t,
                            deformed.triangles.cols()));
        }
        if (deformed.triangles.col(t).maxCoeff() >= deformed.vertices.cols())
        {
            throw base::InputError(
                fmt::format("Triangle {} of the deformed mesh refers to vertex {}; there are {}",
                            t,
                            deformed.triangles.col(t).maxCoeff(),
                            deformed.vertices.cols()));
        }
    }
    for (int i = 0; i < samples.size(); ++i)
    {
        const auto index = static_cast<std::size_t>(i);
        samples.positions.col(i) =
            pointOnTriangle(deformed, samples.triangle[index], samples.barycentric.col(i));
        samples.intensity[i] =
            intensityAt(deformed, samples.triangle[index], samples.barycentric.col(i));
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        Eigen::Vector3d own = Eigen::Vector3d::Zero();
        for (int k = samples.normalStart[index]; k < samples.normalStart[index + 1]; ++k)
        {
            const auto face = static_cast<std::size_t>(k);
            const Eigen::Vector3i v = deformed.triangles.col(samples.normalTriangle[face]);
            const Eigen::Vector3d a = deformed.vertices.col(v[0]);
            const Eigen::Vector3d cross =
                (deformed.vertices.col(v[1]) - a).cross(deformed.vertices.col(v[2]) - a);
            const double length = cross.norm();
            if (!(length > 0.0) || !std::isfinite(length)) continue;
            const Eigen::Vector3d normal = cross / length;
            if (own.isZero(0.0)) own = normal;
            sum += samples.normalWeight[face] * normal;
        }
        // Normals of faces that are folded onto each other cancel; then one of them is used.
        constexpr double kCancelled = 1e-6;
        if (!(sum.norm() > kCancelled)) sum = own;
        if (!sum.isZero(0.0)) samples.normals.col(i) = sum.normalized();
    }
}

} // namespace midair::haptics
