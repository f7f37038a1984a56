#include "haptics/surface/SurfaceSampler.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/SampleBuilder.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Largest distance of a place on an edge from its nearest point, in spacings; less than the
/// guaranteed 1.1.
constexpr double kReach = 1.05;

struct ChainSpot
{
    const FeatureEdge* edge;
    double fraction;
};

ChainSpot spotAt(const SampleBuilder& builder, const FeatureChain& chain, double arc)
{
    auto after = std::upper_bound(chain.arc.begin(), chain.arc.end(), arc);
    after = std::clamp(after, chain.arc.begin() + 1, chain.arc.end() - 1);
    const auto step = static_cast<std::size_t>(after - chain.arc.begin() - 1);
    const double length = chain.arc[step + 1] - chain.arc[step];
    const double along =
        length > 0.0 ? std::clamp((arc - chain.arc[step]) / length, 0.0, 1.0) : 0.0;
    const auto& walked = chain.steps[step];
    return {&builder.topology().features[static_cast<std::size_t>(walked.edge)],
            walked.reversed ? 1.0 - along : along};
}

/// Returns true if neighbours along the chain, divided into \a count equal steps, are at least the
/// spacing apart in a straight line.
bool stepsKeepApart(SampleBuilder& builder, const FeatureChain& chain, int count, double shift)
{
    const double step = chain.length() / count;
    const double spacing2 = std::pow(builder.edgeSpacing() * (1.0 + 2e-9), 2);
    const auto point = [&](int i)
    {
        const double arc = std::fmod((i + shift) * step, chain.length());
        const ChainSpot spot =
            spotAt(builder, chain, i == count && !chain.closed ? chain.length() : arc);
        return builder.edgePoint(*spot.edge, spot.fraction);
    };
    // With a shift an open chain has \a count points, none at its ends; in a loop the last point's
    // neighbour is the first.
    const int last = shift > 0.0 && !chain.closed ? count - 1 : count;
    Eigen::Vector3d before = point(0);
    for (int i = 1; i <= last; ++i)
    {
        builder.look();
        const Eigen::Vector3d here = point(i);
        if ((here - before).squaredNorm() < spacing2) return false;
        before = here;
    }
    return true;
}

void placeChain(SampleBuilder& builder, const FeatureChain& chain, double shift)
{
    constexpr int kTries = 24;
    const double fitting = chain.length() / (builder.edgeSpacing() * (1.0 + 3e-9));
    if (fitting > 1e3 * builder.options().maxPoints)
    {
        throwTooManyPoints(builder.topology(), builder.options());
    }
    int count = static_cast<int>(fitting);
    for (int i = 0; i < kTries && count > 1 && !stepsKeepApart(builder, chain, count, shift); ++i)
    {
        --count; // where the curve bends, the straight distance is less than a step along it
    }
    if (count < 1) return;
    // The corners at the ends have been tried already.
    const int first = shift > 0.0 || chain.closed ? 0 : 1;
    for (int i = first; i < count; ++i)
    {
        const ChainSpot spot = spotAt(builder, chain, (i + shift) * chain.length() / count);
        builder.tryEdge(*spot.edge, spot.fraction, builder.edgeSpacing());
    }
}

constexpr double kFaceReach = 1.05; ///< in spacings; 1.1 is guaranteed
constexpr double kDartsPerCell = 40.0;

/// Returns a uniform number in 0 .. 1 that is the same with every standard library, unlike
/// std::uniform_real_distribution.
double uniform(std::mt19937_64& random)
{
    return static_cast<double>(random() >> 11U) * 0x1p-53;
}

struct Dart
{
    int triangle;
    Eigen::Vector3d barycentric;
    double distance2; ///< squared distance to the earlier sets, at most the square of the spacing
};

Dart throwDart(const std::vector<double>& cumulative, std::mt19937_64& random)
{
    const double pick = uniform(random) * cumulative.back();
    auto at = std::upper_bound(cumulative.begin(), cumulative.end(), pick);
    if (at == cumulative.end()) --at;
    // Uniform over the triangle (Osada et al., "Shape distributions", 2002, equation 1).
    const double root = std::sqrt(uniform(random));
    const double v = uniform(random);
    return {
        static_cast<int>(at - cumulative.begin()), {1.0 - root, root * (1.0 - v), root * v}, 0.0};
}

/// Piece of a triangle that may not be covered yet.
struct Fragment
{
    std::array<Eigen::Vector3d, 3> barycentrics;
    std::array<Eigen::Vector3d, 3> corners;
};

/// Returns true if the ball around \a point contains the piece. A ball is convex, so testing the
/// corners suffices.
bool covers(const Eigen::Vector3d& point, const Fragment& piece, double reach2)
{
    return (piece.corners[0] - point).squaredNorm() <= reach2 &&
           (piece.corners[1] - point).squaredNorm() <= reach2 &&
           (piece.corners[2] - point).squaredNorm() <= reach2;
}

/// Splits a piece in two across its longest edge, so that slivers become compact.
std::array<Fragment, 2> split(const Fragment& piece, const TriangleMesh& mesh, int meshTriangle)
{
    std::size_t longest = 0;
    double longest2 = -1.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const double length2 = (piece.corners[(k + 1) % 3] - piece.corners[k]).squaredNorm();
        if (length2 > longest2)
        {
            longest2 = length2;
            longest = k;
        }
    }
    const std::size_t next = (longest + 1) % 3;
    const Eigen::Vector3d middle = 0.5 * (piece.barycentrics[longest] + piece.barycentrics[next]);
    const Eigen::Vector3d point = pointOnTriangle(mesh, meshTriangle, middle);
    std::array<Fragment, 2> halves = {piece, piece};
    halves[0].barycentrics[next] = middle;
    halves[0].corners[next] = point;
    halves[1].barycentrics[longest] = middle;
    halves[1].corners[longest] = point;
    return halves;
}

/// Places points along the chains in equal steps of at least the edge spacing. \a shift (0 .. 1):
/// offset of the first point from the chain's start, in steps; 0: from corner to corner.
void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift)
{
    for (const FeatureChain& chain : chains)
        placeChain(builder, chain, shift);
}

/// Fills the gaps left by placeChains(): afterwards every place on a feature edge is within 1.05
/// edge spacings of a point.
void fillEdges(SampleBuilder& builder)
{
    const double reach = kReach * builder.edgeSpacing();
    struct Piece
    {
        double begin, end;
    };
    std::vector<Piece> pieces;
    for (const FeatureEdge& edge : builder.topology().features)
    {
        pieces.assign(1, {0.0, 1.0});
        while (!pieces.empty())
        {
            const Piece piece = pieces.back();
            pieces.pop_back();
            const double middle = 0.5 * (piece.begin + piece.end);
            builder.tryEdge(edge, middle, builder.edgeSpacing());
            const int near = builder.points().nearest(builder.edgePoint(edge, middle), reach);
            const auto covers = [&](double fraction)
            {
                return near >= 0 &&
                       (builder.edgePoint(edge, fraction) - builder.points()[near]).squaredNorm() <=
                           reach * reach;
            };
            if (covers(piece.begin) && covers(piece.end)) continue;
            pieces.push_back({middle, piece.end});
            pieces.push_back({piece.begin, middle});
        }
    }
}

/// Tries about 40 area/spacing^2 random points on the faces, weighted by area. If points of \a
/// earlier sets are given, tries those farthest from them first.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier)
{
    const MeshTopology& topology = builder.topology();
    std::vector<double> cumulative(topology.areas.size());
    std::partial_sum(topology.areas.begin(), topology.areas.end(), cumulative.begin());
    const double spacing = builder.spacing();
    const auto count =
        static_cast<int>(std::ceil(kDartsPerCell * topology.area / (spacing * spacing)));
    if (earlier == nullptr)
    {
        for (int i = 0; i < count; ++i)
        {
            const Dart dart = throwDart(cumulative, random);
            builder.tryFace(dart.triangle, dart.barycentric, spacing);
        }
        return;
    }
    std::vector<Dart> darts(static_cast<std::size_t>(count));
    for (Dart& dart : darts)
    {
        builder.look();
        dart = throwDart(cumulative, random);
        const int meshTriangle = topology.triangles[static_cast<std::size_t>(dart.triangle)];
        earlier->nearest(pointOnTriangle(builder.mesh(), meshTriangle, dart.barycentric),
                         spacing,
                         &dart.distance2);
    }
    std::stable_sort(darts.begin(),
                     darts.end(),
                     [](const Dart& a, const Dart& b) { return a.distance2 > b.distance2; });
    for (const Dart& dart : darts)
        builder.tryFace(dart.triangle, dart.barycentric, spacing);
}

/// Fills the gaps left by throwDarts(): afterwards every place on the surface is within 1.05
/// spacings of a point.
///
/// A piece is done if the ball of 1.05 spacings around one point contains it. Otherwise a point is
/// placed at its middle if the spacing allows it, and the piece is halved. A piece of a twentieth
/// of a spacing is always done, because a point is then closer to its middle than the spacing. So
/// the final set is maximal and covers the whole surface.
void fillFaces(SampleBuilder& builder)
{
    const MeshTopology& topology = builder.topology();
    const TriangleMesh& mesh = builder.mesh();
    const double reach = kFaceReach * builder.spacing();
    const double reach2 = reach * reach;
    int last = -1; // last point that covered a piece; neighbours mostly share it
    std::vector<Fragment> pieces;
    for (int t = 0; t < topology.surface; ++t)
    {
        const int meshTriangle = topology.triangles[static_cast<std::size_t>(t)];
        const Eigen::Vector3i v = mesh.triangles.col(meshTriangle);
        pieces.push_back(
            {{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()},
             {mesh.vertices.col(v[0]), mesh.vertices.col(v[1]), mesh.vertices.col(v[2])}});
        while (!pieces.empty())
        {
            builder.look();
            const Fragment piece = pieces.back();
            pieces.pop_back();
            if (last >= 0 && covers(builder.points()[last], piece, reach2)) continue;
            const Eigen::Vector3d middle =
                (piece.barycentrics[0] + piece.barycentrics[1] + piece.barycentrics[2]) / 3.0;
            if (builder.tryFace(t, middle, builder.spacing()))
            {
                last = builder.points().size() - 1;
            }
            else
            {
                last = builder.points().nearest(pointOnTriangle(mesh, meshTriangle, middle), reach);
            }
            if (last >= 0 && covers(builder.points()[last], piece, reach2)) continue;
            const auto halves = split(piece, mesh, meshTriangle);
            pieces.push_back(halves[1]);
            pieces.push_back(halves[0]);
        }
    }
}

/// Data that all sample sets of one mesh share.
struct SampledMesh
{
    const TriangleMesh& mesh;
    const SamplerOptions& options;
    MeshTopology topology;
    std::vector<int> corners;
    std::vector<FeatureChain> chains;
};

/// Refuses meshes at once that would otherwise be refused after minutes of placing points.
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

/// Makes set number \a set (from 0); \a earlier: the points of the previous sets.
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

SurfaceSamples sampleBetween(const TriangleMesh& mesh, const SamplerOptions& options)
{
    const bool oneSet =
        options.sampling == Sampling::VERTICES || options.sampling == Sampling::POINTS;
    return std::move(sampleSurfaceSets(mesh, options, oneSet ? 1 : 2).back());
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
        // Normals of faces folded onto each other cancel; then one of them is used.
        constexpr double kCancelled = 1e-6;
        if (!(sum.norm() > kCancelled)) sum = own;
        if (!sum.isZero(0.0)) samples.normals.col(i) = sum.normalized();
    }
}

} // namespace midair::haptics
