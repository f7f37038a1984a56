#include "haptics/surface/SurfacePasses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

/// Returns a uniform number in 0 .. 1 that is the same with every standard library, unlike that of
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

/// Piece of a triangle that is not known to be covered yet.
struct Fragment
{
    std::array<Eigen::Vector3d, 3> barycentrics;
    std::array<Eigen::Vector3d, 3> corners;
};

/// Returns true if the ball around \a point contains the piece. A ball is convex, so testing the
/// corners is enough.
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

} // namespace

void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift)
{
    for (const FeatureChain& chain : chains)
        placeChain(builder, chain, shift);
}

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

/// A piece is done if the ball of 1.05 spacings around one point contains it. Otherwise a point is
/// placed at its middle if the spacing allows it, and the piece is halved. A piece of a twentieth
/// of a spacing is always done, since by then a point is nearer to its middle than the spacing. So
/// in the end the set is maximal and covers the whole surface.
void fillFaces(SampleBuilder& builder)
{
    const MeshTopology& topology = builder.topology();
    const TriangleMesh& mesh = builder.mesh();
    const double reach = kFaceReach * builder.spacing();
    const double reach2 = reach * reach;
    int last = -1; // the last point that covered a piece; neighbours mostly share it
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

} // namespace midair::haptics
