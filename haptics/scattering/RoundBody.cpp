#include "haptics/scattering/RoundBody.h"

#include "haptics/base/InputError.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kMostLatticePoints = 1e7;
// Shares of an edge within which its crossing moves an end onto the surface: Labelle and Shewchuk's
// for dihedral angles of at least 10.7 degrees.
constexpr double kSnapLong = 0.24999, kSnapShort = 0.41189;

// The distance from the convex hull of two balls.
double coneDistance(const RoundCone& cone, const Eigen::Vector3d& place)
{
    const Eigen::Vector3d along = cone.b - cone.a, from = place - cone.a;
    const double length2 = along.squaredNorm(), slope = cone.aRadius_m - cone.bRadius_m;
    const double side2 = length2 - slope * slope;
    // One of the balls has the other inside.
    if (!(side2 > 0.0))
        return slope > 0.0 ? from.norm() - cone.aRadius_m
                           : (place - cone.b).norm() - cone.bRadius_m;
    const double y = from.dot(along) / std::sqrt(length2);
    const double x = std::sqrt(std::max(0.0, from.squaredNorm() - y * y));
    // Where the sides' normal through the place meets the axis: before a, beyond b, or between.
    const double foot = y - x * slope / std::sqrt(side2);
    if (foot <= 0.0) return from.norm() - cone.aRadius_m;
    if (foot * foot >= length2) return (place - cone.b).norm() - cone.bRadius_m;
    return (x * std::sqrt(side2) + y * slope) / std::sqrt(length2) - cone.aRadius_m;
}

/// Points of the lattice have coordinates in halves of a cell that are all even or all odd.
class RoundMesher
{
public:
    RoundMesher(const std::vector<RoundCone>& cones, double cell_m) :
        _cones(cones),
        _half_m(0.5 * cell_m)
    {
        fill();
        snap();
        do
            cut();
        while (untouch());
        leaveOutUnused();
    }
    Eigen::Index triangles() const { return static_cast<Eigen::Index>(_triangles.size()); }
    void evenOut();
    TriangleMesh mesh() const
    {
        TriangleMesh mesh;
        mesh.vertices.resize(3, static_cast<Eigen::Index>(_vertices.size()));
        for (std::size_t v = 0; v < _vertices.size(); ++v)
            mesh.vertices.col(static_cast<Eigen::Index>(v)) = _vertices[v];
        mesh.triangles.resize(3, static_cast<Eigen::Index>(_triangles.size()));
        for (std::size_t t = 0; t < _triangles.size(); ++t)
            mesh.triangles.col(static_cast<Eigen::Index>(t)) = _triangles[t];
        return mesh;
    }

private:
    std::size_t indexOf(const Eigen::Vector3i& at) const
    {
        return (static_cast<std::size_t>(at[0]) * static_cast<std::size_t>(_size[1]) +
                static_cast<std::size_t>(at[1])) *
                   static_cast<std::size_t>(_size[2]) +
               static_cast<std::size_t>(at[2]);
    }
    bool isLattice(const Eigen::Vector3i& at) const
    {
        return (at.array() >= 0).all() && (at.array() < _size.array()).all() &&
               ((at[0] ^ at[1]) & 1) == 0 && ((at[0] ^ at[2]) & 1) == 0;
    }
    Eigen::Vector3d startOf(const Eigen::Vector3i& at) const
    {
        return _origin + _half_m * at.cast<double>();
    }
    template<typename Does>
    void eachPoint(const Does& does)
    {
        for (int i = 0; i < _size[0]; ++i)
            for (int j = 0; j < _size[1]; ++j)
                for (int k = 0; k < _size[2]; ++k)
                    if (const Eigen::Vector3i at(i, j, k); isLattice(at)) does(at);
    }
    void fill();
    double crossingOf(const Eigen::Vector3i& from, const Eigen::Vector3i& to) const;
    void snap();
    int vertexAt(std::size_t key, std::size_t other, const Eigen::Vector3d& place);
    int cutOf(const Eigen::Vector3i& inside, const Eigen::Vector3i& outside);
    void addTetrahedra(const Eigen::Vector3i& at);
    void addTetrahedron(const std::array<Eigen::Vector3i, 4>& corners);
    void addTriangle(int a, int b, int c, const Eigen::Vector3d& inside);
    void cut();
    void dropPairs();
    bool untouch();
    void leaveOutUnused();
    Eigen::Vector3d slopeAt(const Eigen::Vector3d& place) const;

    const std::vector<RoundCone>& _cones;
    double _half_m;
    Eigen::Vector3d _origin = Eigen::Vector3d::Zero();
    Eigen::Vector3i _size = Eigen::Vector3i::Zero();
    std::vector<float> _distance_m; // of lattice points; 0: moved onto the surface
    std::map<std::size_t, std::pair<Eigen::Vector3i, Eigen::Vector3d>> _moved; // from, to
    std::map<std::pair<std::size_t, std::size_t>, int> _numbers; // of cut edges, of moved points
    std::vector<Eigen::Vector3d> _vertices;
    std::vector<Eigen::Vector3i> _triangles;
};

void RoundMesher::fill()
{
    Eigen::Vector3d least = _cones.front().a, most = least;
    for (const RoundCone& cone : _cones)
        for (const auto& [place, radius_m] :
             {std::pair{cone.a, cone.aRadius_m}, std::pair{cone.b, cone.bRadius_m}})
        {
            least = least.cwiseMin((place.array() - radius_m).matrix());
            most = most.cwiseMax((place.array() + radius_m).matrix());
        }
    constexpr double kMargin = 6.0; // in halves of a cell, on each side
    _origin = (least.array() - kMargin * _half_m).matrix();
    const Eigen::Array3d size = (most - least).array() / _half_m + 2.0 * kMargin + 1.0;
    if (!(size.prod() <= kMostLatticePoints))
        throw base::InputError(fmt::format("a body of {:.3g} m is too large for cells of {:.3g} m",
                                           (most - least).maxCoeff(),
                                           2.0 * _half_m));
    _size = size.ceil().cast<int>().matrix();
    _distance_m.assign(static_cast<std::size_t>(_size.prod()), std::numeric_limits<float>::max());
    eachPoint([&](const Eigen::Vector3i& at)
              { _distance_m[indexOf(at)] = static_cast<float>(distanceTo(_cones, startOf(at))); });
}

// The share of an edge, from an end that isn't moved, at which the distance is 0: secants, of which
// one that stays on the same side is halved (Dowell, Jarratt 1971, 10.1007/BF01934364).
double RoundMesher::crossingOf(const Eigen::Vector3i& from, const Eigen::Vector3i& to) const
{
    const Eigen::Vector3d start = startOf(from), along = startOf(to) - start;
    double low = 0.0, high = 1.0, atLow = distanceTo(_cones, start),
           atHigh = distanceTo(_cones, start + along), share = 0.5;
    for (int step = 0; step < 12 && atLow != atHigh; ++step)
    {
        share = std::clamp((low * atHigh - high * atLow) / (atHigh - atLow), low, high);
        const double here = distanceTo(_cones, start + share * along);
        if (std::abs(here) < 1e-6 * _half_m) break;
        if ((here > 0.0) == (atHigh > 0.0))
        {
            high = share;
            atHigh = here;
            atLow *= 0.5;
        }
        else
        {
            low = share;
            atLow = here;
            atHigh *= 0.5;
        }
    }
    return share;
}

void RoundMesher::snap()
{
    std::vector<std::pair<Eigen::Vector3i, double>> neighbours;
    for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-2, 2})
            neighbours.emplace_back(step * Eigen::Vector3i::Unit(axis), kSnapLong);
    for (int corner = 0; corner < 8; ++corner)
        neighbours.emplace_back(
            Eigen::Vector3i(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1),
            kSnapShort);
    eachPoint(
        [&](const Eigen::Vector3i& at)
        {
            const float here = _distance_m[indexOf(at)];
            double nearest_m = std::numeric_limits<double>::max();
            Eigen::Vector3d place = startOf(at);
            for (const auto& [step, most] : neighbours)
            {
                const Eigen::Vector3i to = at + step;
                if (!isLattice(to) || !(here * _distance_m[indexOf(to)] < 0.0f)) continue;
                const double share = crossingOf(at, to),
                             away_m = share * (startOf(to) - startOf(at)).norm();
                if (share > most || away_m >= nearest_m) continue;
                nearest_m = away_m;
                place = startOf(at) + share * (startOf(to) - startOf(at));
            }
            if (nearest_m == std::numeric_limits<double>::max() && here != 0.0f) return;
            _distance_m[indexOf(at)] = 0.0f;
            _moved[indexOf(at)] = {at, place};
        });
}

int RoundMesher::vertexAt(std::size_t key, std::size_t other, const Eigen::Vector3d& place)
{
    const auto [found, isNew] =
        _numbers.emplace(std::minmax(key, other), static_cast<int>(_vertices.size()));
    if (isNew) _vertices.push_back(place);
    return found->second;
}

// The vertex on the edge from a point inside to one that is not.
int RoundMesher::cutOf(const Eigen::Vector3i& inside, const Eigen::Vector3i& outside)
{
    const std::size_t to = indexOf(outside);
    if (_distance_m[to] == 0.0f) return vertexAt(to, to, _moved.at(to).second);
    const Eigen::Vector3d start = startOf(inside);
    return vertexAt(
        indexOf(inside), to, start + crossingOf(inside, outside) * (startOf(outside) - start));
}

// Each tetrahedron has two edges along axes, one between even points and one between odd ones.
void RoundMesher::addTetrahedra(const Eigen::Vector3i& at)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        const Eigen::Vector3i e = Eigen::Vector3i::Unit(axis),
                              f = Eigen::Vector3i::Unit((axis + 1) % 3),
                              g = Eigen::Vector3i::Unit((axis + 2) % 3);
        const std::array<Eigen::Vector3i, 4> around{
            at + e + f + g, at + e - f + g, at + e - f - g, at + e + f - g};
        for (std::size_t side = 0; side < 4; ++side)
            addTetrahedron({at, at + 2 * e, around[side], around[(side + 1) % 4]});
    }
}

void RoundMesher::addTetrahedron(const std::array<Eigen::Vector3i, 4>& corners)
{
    std::vector<Eigen::Vector3i> in, out;
    for (const Eigen::Vector3i& corner : corners)
        (_distance_m[indexOf(corner)] < 0.0f ? in : out).push_back(corner);
    if (in.empty() || out.empty()) return;
    const Eigen::Vector3d inside = startOf(in.front());
    if (in.size() == 1)
        addTriangle(cutOf(in[0], out[0]), cutOf(in[0], out[1]), cutOf(in[0], out[2]), inside);
    else if (out.size() == 1)
        addTriangle(cutOf(in[0], out[0]), cutOf(in[1], out[0]), cutOf(in[2], out[0]), inside);
    else
    {
        // The diagonal is inside the tetrahedron, where no other has to agree: the shorter one.
        const int a = cutOf(in[0], out[0]), b = cutOf(in[0], out[1]), c = cutOf(in[1], out[1]),
                  d = cutOf(in[1], out[0]);
        const auto length = [&](int from, int to)
        {
            return (_vertices[static_cast<std::size_t>(from)] -
                    _vertices[static_cast<std::size_t>(to)])
                .norm();
        };
        const bool isFirst = length(a, c) <= length(b, d);
        addTriangle(a, b, isFirst ? c : d, inside);
        addTriangle(isFirst ? a : b, c, d, inside);
    }
}

// A moved point is the end of several edges, whose triangles then are lines: nothing.
void RoundMesher::addTriangle(int a, int b, int c, const Eigen::Vector3d& inside)
{
    if (a == b || b == c || c == a) return;
    const auto at = [&](int vertex) { return _vertices[static_cast<std::size_t>(vertex)]; };
    const bool isOut = (at(b) - at(a)).cross(at(c) - at(a)).dot(at(a) - inside) > 0.0;
    _triangles.emplace_back(a, isOut ? b : c, isOut ? c : b);
}

// Two tetrahedra on either side of three moved points have the triangle both, once each way: it is
// inside the body.
void RoundMesher::dropPairs()
{
    std::map<std::array<int, 3>, std::size_t> known;
    std::vector<char> isDropped(_triangles.size(), 0);
    for (std::size_t t = 0; t < _triangles.size(); ++t)
    {
        std::array<int, 3> key{_triangles[t][0], _triangles[t][1], _triangles[t][2]};
        std::sort(key.begin(), key.end());
        const auto [found, isNew] = known.emplace(key, t);
        if (isNew) continue;
        isDropped[t] = isDropped[found->second] = 1;
        known.erase(found);
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < _triangles.size(); ++t)
        if (!isDropped[t]) _triangles[kept++] = _triangles[t];
    _triangles.resize(kept);
}

void RoundMesher::cut()
{
    _numbers.clear();
    _vertices.clear();
    _triangles.clear();
    for (int i = 2; i + 2 < _size[0]; i += 2)
        for (int j = 2; j + 2 < _size[1]; j += 2)
            for (int k = 2; k + 2 < _size[2]; k += 2)
                addTetrahedra({i, j, k});
    dropPairs();
}

// Moved points can make parts of the body touch at an edge, which then has four triangles: such
// points move back. Without moved points no edge has more than two. Returns true if any moved.
bool RoundMesher::untouch()
{
    std::map<std::pair<int, int>, int> faces;
    for (const Eigen::Vector3i& t : _triangles)
        for (int side = 0; side < 3; ++side)
            ++faces[std::minmax(t[side], t[(side + 1) % 3])];
    std::vector<char> touches(_vertices.size(), 0);
    for (const auto& [edge, count] : faces)
        if (count > 2)
            touches[static_cast<std::size_t>(edge.first)] =
                touches[static_cast<std::size_t>(edge.second)] = 1;
    bool isAny = false;
    for (const auto& [key, vertex] : _numbers)
    {
        if (key.first != key.second || !touches[static_cast<std::size_t>(vertex)]) continue;
        const auto before =
            static_cast<float>(distanceTo(_cones, startOf(_moved.at(key.first).first)));
        _distance_m[key.first] = before == 0.0f ? std::numeric_limits<float>::min() : before;
        _moved.erase(key.first);
        isAny = true;
    }
    return isAny;
}

void RoundMesher::leaveOutUnused()
{
    std::vector<int> number(_vertices.size(), -1);
    std::vector<Eigen::Vector3d> vertices;
    for (Eigen::Vector3i& t : _triangles)
        for (int& vertex : t)
        {
            int& now = number[static_cast<std::size_t>(vertex)];
            if (now < 0)
            {
                now = static_cast<int>(vertices.size());
                vertices.push_back(_vertices[static_cast<std::size_t>(vertex)]);
            }
            vertex = now;
        }
    _vertices = std::move(vertices);
}

Eigen::Vector3d RoundMesher::slopeAt(const Eigen::Vector3d& place) const
{
    Eigen::Vector3d slope;
    const double step_m = 1e-3 * _half_m;
    for (int axis = 0; axis < 3; ++axis)
    {
        const Eigen::Vector3d step = step_m * Eigen::Vector3d::Unit(axis);
        slope[axis] =
            (distanceTo(_cones, place + step) - distanceTo(_cones, place - step)) / (2.0 * step_m);
    }
    return slope.stableNormalized();
}

// Moves the vertices to the middle of the triangles at them, weighed by area, and back: not to the
// surface, but so far out of it that the flat triangles at them are on it in the mean. The mean of
// the distance over a flat triangle on a ball is 3/4 of that at its centre.
void RoundMesher::evenOut()
{
    constexpr int kPasses = 10;
    for (int pass = 0; pass < kPasses; ++pass)
    {
        std::vector<Eigen::Vector3d> sums(_vertices.size(), Eigen::Vector3d::Zero());
        std::vector<double> weights(_vertices.size(), 0.0), sunk_m = weights;
        for (const Eigen::Vector3i& t : _triangles)
        {
            const auto at = [&](int corner)
            { return _vertices[static_cast<std::size_t>(t[corner])]; };
            const Eigen::Vector3d centre = (at(0) + at(1) + at(2)) / 3.0;
            const double area = (at(1) - at(0)).cross(at(2) - at(0)).norm();
            const double mean_m = 0.75 * distanceTo(_cones, centre) +
                                  0.25 *
                                      (distanceTo(_cones, at(0)) + distanceTo(_cones, at(1)) +
                                       distanceTo(_cones, at(2))) /
                                      3.0;
            for (const int vertex : t)
            {
                sums[static_cast<std::size_t>(vertex)] += area * centre;
                weights[static_cast<std::size_t>(vertex)] += area;
                sunk_m[static_cast<std::size_t>(vertex)] += area * mean_m;
            }
        }
        for (std::size_t v = 0; v < _vertices.size(); ++v)
        {
            if (!(weights[v] > 0.0)) continue;
            const double out_m = distanceTo(_cones, _vertices[v]) - sunk_m[v] / weights[v];
            Eigen::Vector3d& place = _vertices[v];
            place = sums[v] / weights[v];
            for (int step = 0; step < 2; ++step)
                place -= (distanceTo(_cones, place) - out_m) * slopeAt(place);
        }
    }
}

void requireRound(const std::vector<RoundCone>& cones)
{
    if (cones.empty()) throw base::InputError("a round body needs a part");
    for (const RoundCone& cone : cones)
        if (!cone.a.allFinite() || !cone.b.allFinite() || !std::isfinite(cone.aRadius_m) ||
            !std::isfinite(cone.bRadius_m) || !(std::min(cone.aRadius_m, cone.bRadius_m) > 0.0))
            throw base::InputError("a round body's parts must be finite, with radii over 0");
}

} // namespace

double distanceTo(const std::vector<RoundCone>& cones, const Eigen::Vector3d& place)
{
    double least = std::numeric_limits<double>::infinity();
    for (const RoundCone& cone : cones)
        least = std::min(least, coneDistance(cone, place));
    return least;
}

TriangleMesh roundBody(const std::vector<RoundCone>& cones, double cell_m)
{
    requireRound(cones);
    RoundMesher mesher(cones, cell_m);
    mesher.evenOut();
    return mesher.mesh();
}

TriangleMesh finestRoundBody(const std::vector<RoundCone>& cones, Eigen::Index mostTriangles)
{
    requireRound(cones);
    double size_m = 0.0;
    for (const RoundCone& cone : cones)
        size_m = std::max({size_m,
                           (cone.a - cones.front().a).norm() + cone.aRadius_m,
                           (cone.b - cones.front().a).norm() + cone.bRadius_m});
    double cell_m = 0.25 * size_m, best_m = 0.0;
    Eigen::Index best = 0;
    constexpr int kTries = 12;
    for (int attempt = 0; attempt < kTries; ++attempt)
    {
        const Eigen::Index triangles = RoundMesher(cones, cell_m).triangles();
        if (triangles <= mostTriangles && triangles > best)
        {
            best = triangles;
            best_m = cell_m;
        }
        const double share = static_cast<double>(triangles) / static_cast<double>(mostTriangles);
        if (share >= 0.97 && share <= 1.0) break;
        // The count goes with the inverse square of the cell, once no part is lost.
        cell_m *= std::max(0.4, std::sqrt(share / 0.985));
    }
    if (best == 0)
        throw base::InputError(
            fmt::format("a round body has no mesh of {} triangles", mostTriangles));
    return roundBody(cones, best_m);
}

} // namespace midair::haptics
