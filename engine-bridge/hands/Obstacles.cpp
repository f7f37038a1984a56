#include "engine-bridge/hands/Obstacles.h"

#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::bridge
{

namespace
{

constexpr double kFade = 0.6;

using Eigen::Vector3d;

/// sqrt(2 (d1 + d2)/(lambda d1 d2)), 1/m.
double fresnelScale(double d1, double d2, double wavelength_m)
{
    const double least = wavelength_m / 8.0;
    const double a = std::max(d1, least);
    const double b = std::max(d2, least);
    return std::sqrt(2.0 * (a + b) / (wavelength_m * a * b));
}

/// The nearer edge, in units of v, of an obstacle behind or below the point in the sound's
/// direction; only an obstacle whose skin is at or near the point attenuates. It is the mirror
/// image of the edge at the horizon, so that weights pass smoothly through 1/2 there. \a sine is
/// that of the angle over the horizon, 0 .. 1.
double edgeBehind(double sine, double gap, double radius_m, double wavelength_m)
{
    const double cosine = std::sqrt(std::max(0.0, 1.0 - sine * sine));
    const double distance = std::max(radius_m * sine, wavelength_m / 8.0);
    return radius_m * (1.0 - cosine) * std::sqrt(2.0 / (wavelength_m * distance)) +
           4.0 * gap / wavelength_m;
}

/// Returns the point, or if it is inside obstacles, the nearest place on the skin of the deepest
/// one.
Vector3d onSkin(const Vector3d& point, const std::vector<Capsule>& obstacles)
{
    Vector3d moved = point;
    double deepest = 0.0;
    for (const Capsule& obstacle : obstacles)
    {
        const ClosestPair pair = closestSegments(point, point, obstacle.a, obstacle.b);
        const double depth = obstacle.radius_m - pair.distance;
        if (depth <= deepest || !(pair.distance > 0.0)) continue;
        deepest = depth;
        moved = pair.onOther + (point - pair.onOther) * (obstacle.radius_m / pair.distance);
    }
    return moved;
}

/// shadowWeight() for a point already moved by onSkin().
double weightOutside(const Vector3d& source,
                     const Vector3d& point,
                     const Capsule& obstacle,
                     double wavelength_m)
{
    const double length = (point - source).norm();
    if (!(length > 0.0)) return 1.0;
    const Vector3d w = (point - source) / length;
    const ClosestPair pair = closestSegments(source, point, obstacle.a, obstacle.b);
    const double d1 = (pair.onSegment - source).dot(w);
    const double d2 = length - d1;
    if (d1 <= 1e-9 * length) return 1.0; // behind the transducer
    const double r = obstacle.radius_m;
    const double scale = fresnelScale(d1, d2, wavelength_m);
    // The axis seen along the path: from a to b, at the distance x from the path.
    const Vector3d a = (obstacle.a - source) - w.dot(obstacle.a - source) * w;
    const Vector3d b = (obstacle.b - source) - w.dot(obstacle.b - source) * w;
    const double seen = (b - a).norm();
    const Vector3d along = seen > 1e-9 ? Vector3d((b - a) / seen) : w.unitOrthogonal();
    const double ya = a.dot(along);
    const double yb = b.dot(along);
    const double x = (a - ya * along).norm();
    double x1 = (x - r) * scale;
    if (d2 <= 1e-9 * length)
    {
        if (!(pair.distance > 0.0)) return 0.0;
        const double sine = -w.dot(point - pair.onOther) / pair.distance;
        x1 = edgeBehind(
            std::clamp(sine, 0.0, 1.0), std::max(0.0, pair.distance - r), r, wavelength_m);
    }
    return pastRectangle(x1, (x + r) * scale, (ya - r) * scale, (yb + r) * scale);
}

bool usable(const Capsule& capsule)
{
    return capsule.a.allFinite() && capsule.b.allFinite() && capsule.radius_m > 0.0;
}

/// Computes the weights from all transducers to one point past all obstacles.
class SpotShadow
{
public:
    SpotShadow(const haptics::TransducerArray& array,
               const std::vector<Capsule>& obstacles,
               double wavelength_m) :
        _array(array),
        _obstacles(obstacles),
        _wavelength_m(wavelength_m)
    {
    }

    /// Sets \a weights (m); returns the number of paths tested one by one.
    long weigh(const Vector3d& point, Eigen::VectorXd& weights)
    {
        const Vector3d spot = onSkin(point, _obstacles);
        _directions = (_array.positions.colwise() - spot).colwise().normalized();
        weights.setOnes(_array.size());
        long tested = 0;
        for (const Capsule& obstacle : _obstacles)
        {
            const double limit = cosineLimit(spot, obstacle);
            const Vector3d axis = (0.5 * (obstacle.a + obstacle.b) - spot).normalized();
            _cosines.noalias() = axis.transpose() * _directions;
            for (Eigen::Index i = 0; i < _cosines.size(); ++i)
            {
                if (_cosines[i] < limit || weights[i] == 0.0) continue;
                ++tested;
                weights[i] *= weightOutside(_array.positions.col(i), spot, obstacle, _wavelength_m);
            }
        }
        return tested;
    }

private:
    /// Cosine of the angle to the direction of the obstacle's middle beyond which a path from \a
    /// spot is lit. The angle includes the sphere around the obstacle and the penumbra around that
    /// at its far side. -2 if the spot is inside both.
    double cosineLimit(const Vector3d& spot, const Capsule& obstacle) const
    {
        const double away = (0.5 * (obstacle.a + obstacle.b) - spot).norm();
        const double half = 0.5 * (obstacle.b - obstacle.a).norm() + obstacle.radius_m;
        // v = kLit at a height of kLit sqrt(lambda d1 d2/(2 (d1 + d2))), which is less than with d1
        // or d2 alone.
        const double ball = half + kLit * std::sqrt(0.5 * _wavelength_m *
                                                    std::max(away + half, _wavelength_m / 8.0));
        if (ball >= away) return -2.0;
        const double sine = ball / away;
        return std::sqrt(1.0 - sine * sine);
    }

    const haptics::TransducerArray& _array;
    const std::vector<Capsule>& _obstacles;
    double _wavelength_m;
    Eigen::Matrix3Xd _directions;
    Eigen::RowVectorXd _cosines;
};

std::vector<Capsule> usableOnes(const std::vector<Capsule>& obstacles)
{
    std::vector<Capsule> result;
    std::copy_if(obstacles.begin(), obstacles.end(), std::back_inserter(result), usable);
    return result;
}

/// Returns the obstacles that may block a path. All paths are in the sphere around transducers and
/// points, and the penumbra, v = kLit, is widest in the middle of the longest path.
std::vector<Capsule> nearOnes(const std::vector<Capsule>& obstacles,
                              const haptics::TransducerArray& array,
                              const Eigen::Matrix3Xd& points,
                              double wavelength_m)
{
    std::vector<Capsule> result = usableOnes(obstacles);
    if (result.empty() || array.size() == 0 || points.cols() == 0) return result;
    const Vector3d middle =
        0.5 * (array.positions.rowwise().minCoeff() + array.positions.rowwise().maxCoeff());
    const double radius =
        std::sqrt(std::max((array.positions.colwise() - middle).colwise().squaredNorm().maxCoeff(),
                           (points.colwise() - middle).colwise().squaredNorm().maxCoeff()));
    const double limit = radius + kLit * std::sqrt(0.25 * wavelength_m * radius);
    // NaN stays.
    const auto isFar = [&](const Capsule& obstacle)
    {
        const double half = 0.5 * (obstacle.b - obstacle.a).norm() + obstacle.radius_m;
        return (0.5 * (obstacle.a + obstacle.b) - middle).norm() - half > limit;
    };
    result.erase(std::remove_if(result.begin(), result.end(), isFar), result.end());
    return result;
}

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Half the least extent of an obstacle, m: far below any wavelength, and over 0.
constexpr double kThinnest_m = 1e-4;

/// The principal axes of the surface as columns, the largest spread first.
Matrix3d principalAxes(const haptics::TriangleMesh& mesh, Vector3d& middle)
{
    // Moments of the surface, because vertices may crowd: the second moments of a triangle about
    // the origin are A/12 (sum v_i v_i^T + 9 m m^T), with m the mean of its corners v_i.
    Matrix3d moments = Matrix3d::Zero();
    Vector3d first = Vector3d::Zero();
    double area = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Vector3d a = mesh.vertices.col(t[0]);
        const Vector3d b = mesh.vertices.col(t[1]);
        const Vector3d c = mesh.vertices.col(t[2]);
        const double size = 0.5 * (b - a).cross(c - a).norm();
        const Vector3d mean = (a + b + c) / 3.0;
        if (!std::isfinite(size)) continue;
        moments += size / 12.0 *
                   (a * a.transpose() + b * b.transpose() + c * c.transpose() +
                    9.0 * mean * mean.transpose());
        first += size * mean;
        area += size;
    }
    if (!(area > 0.0)) return Matrix3d::Identity();
    middle = first / area;
    const Matrix3d spread = moments / area - middle * middle.transpose();
    return base::symmetricAxes(spread).vectors.rowwise().reverse();
}

/// An interval, empty at first.
struct Range
{
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void add(double value)
    {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

Range within(const Eigen::Matrix3Xd& vertices,
             const Eigen::Matrix3Xi& triangles,
             double low,
             double high)
{
    Range range;
    for (const auto& t : triangles.colwise())
        for (int k = 0; k < 3; ++k)
        {
            const Vector3d a = vertices.col(t[k]);
            const Vector3d b = vertices.col(t[(k + 1) % 3]);
            if (a.y() >= low && a.y() <= high) range.add(a.x());
            // The points where the edge crosses the strip's borders.
            for (const double border : {low, high})
                if ((a.y() - border) * (b.y() - border) < 0.0)
                    range.add(a.x() + (b.x() - a.x()) * (border - a.y()) / (b.y() - a.y()));
        }
    return range;
}

/// NaN counts as moved.
bool near(const Capsule& a, const Capsule& b)
{
    return (a.a - b.a).norm() <= kHandTolerance_m && (a.b - b.b).norm() <= kHandTolerance_m &&
           std::abs(a.radius_m - b.radius_m) <= kHandTolerance_m;
}

bool nearHands(const std::vector<HandCapsule>& a, const std::vector<HandCapsule>& b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].hand != b[i].hand || a[i].bone != b[i].bone || !near(a[i].shape, b[i].shape))
            return false;
    return true;
}

bool nearProps(const std::vector<Capsule>& a, const std::vector<Capsule>& b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!near(a[i], b[i])) return false;
    return true;
}

} // namespace

std::complex<double> knifeEdge(double v)
{
    // Auxiliary functions of v >= 0: C(v) = 1/2 + f sin - g cos, S(v) = 1/2 - f cos - g sin of pi
    // v^2/2 (A&S 7.3.9, 7.3.10), so that integral from v of e^{-j pi t^2/2} = (1/2 - C) - j (1/2 -
    // S) = (g - j f) e^{-j pi v^2/2}.
    const double x = std::abs(v);
    const double f = (1.0 + 0.926 * x) / (2.0 + 1.792 * x + 3.104 * x * x);
    const double g = 1.0 / (2.0 + 4.142 * x + 3.492 * x * x + 6.670 * x * x * x);
    const std::complex<double> beyond = std::complex<double>(0.5, 0.5) *
                                        std::complex<double>(g, -f) *
                                        std::polar(1.0, -0.5 * base::kPi * x * x);
    return v >= 0.0 ? beyond : 1.0 - beyond;
}

double pastRectangle(double x1, double x2, double y1, double y2)
{
    if (x1 >= kLit || y1 >= kLit || y2 <= -kLit) return 1.0;
    const std::complex<double> blocked =
        (knifeEdge(x1) - knifeEdge(x2)) * (knifeEdge(y1) - knifeEdge(y2));
    const double passed = std::min(1.0, std::abs(1.0 - blocked));
    // Blends to 1 from kFade to kLit; the ripples of the far edges would cause a small step at
    // kLit.
    const double lit = std::clamp((x1 - kFade) / (kLit - kFade), 0.0, 1.0);
    return passed + lit * (1.0 - passed);
}

bool ShadowOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ShadowOptions: ")
        .above("wavelength_m", wavelength_m, 0.0)
        .atLeast("maxTests", maxTests, 1)
        .passed(error);
}

double shadowWeight(const Vector3d& source,
                    const Vector3d& point,
                    const Capsule& obstacle,
                    double wavelength_m)
{
    if (!usable(obstacle)) return 1.0;
    return weightOutside(source, onSkin(point, {obstacle}), obstacle, wavelength_m);
}

Eigen::MatrixXd shadowWeights(const Eigen::Matrix3Xd& points,
                              const haptics::TransducerArray& array,
                              const std::vector<Capsule>& obstacles,
                              double wavelength_m)
{
    const std::vector<Capsule> real = usableOnes(obstacles);
    Eigen::MatrixXd weights = Eigen::MatrixXd::Ones(points.cols(), array.size());
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        const Vector3d spot = onSkin(points.col(l), real);
        for (Eigen::Index i = 0; i < array.positions.cols(); ++i)
            for (const Capsule& obstacle : real)
                weights(l, i) *=
                    weightOutside(array.positions.col(i), spot, obstacle, wavelength_m);
    }
    return weights;
}

Eigen::VectorXd shadowGains(const Eigen::Matrix3Xd& points,
                            const haptics::TransducerArray& array,
                            const std::vector<Capsule>& obstacles,
                            const ShadowOptions& options,
                            ShadowCounters* counters)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    ShadowCounters counted;
    const std::vector<Capsule> real = nearOnes(obstacles, array, points, options.wavelength_m);
    const Eigen::Index n = points.cols();
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(array.size());
    if (n > 0 && !real.empty() && array.size() > 0)
    {
        SpotShadow shadow(array, real, options.wavelength_m);
        Eigen::VectorXd weights;
        counted.tested = shadow.weigh(points.col(n / 2), weights);
        // Uses as many points as the budget allows, at this point's cost.
        const auto affordable =
            static_cast<Eigen::Index>(options.maxTests / std::max(1L, counted.tested));
        const Eigen::Index spots = std::clamp<Eigen::Index>(affordable, 1, n);
        if (spots == 1)
            squares = weights.cwiseAbs2();
        else
            counted.tested = 0;
        for (Eigen::Index k = 0; spots > 1 && k < spots; ++k)
        {
            counted.tested += shadow.weigh(points.col((2 * k + 1) * n / (2 * spots)), weights);
            squares += weights.cwiseAbs2();
        }
        squares /= static_cast<double>(spots);
        counted.spots = static_cast<int>(spots);
        counted.pairs = static_cast<long>(spots) * array.size() * static_cast<long>(real.size());
    }
    else
        squares.setOnes();
    if (counters) *counters = counted;
    return squares.cwiseSqrt();
}

std::vector<Capsule> capsulesOf(const haptics::TriangleMesh& mesh, double leastWidth_m, int most)
{
    std::vector<Capsule> capsules;
    if (mesh.triangles.cols() == 0 || !mesh.vertices.allFinite()) return capsules;
    Vector3d middle = Vector3d::Zero();
    Matrix3d axes = principalAxes(mesh, middle);
    Eigen::Matrix3Xd local = axes.transpose() * (mesh.vertices.colwise() - middle);
    Vector3d extent = local.rowwise().maxCoeff() - local.rowwise().minCoeff();
    // Sorts the axes again, because extents may rank differently from spreads.
    Eigen::Vector3i order(0, 1, 2);
    std::stable_sort(
        order.data(), order.data() + 3, [&](int i, int k) { return extent[i] > extent[k]; });
    Matrix3d ranked;
    for (int k = 0; k < 3; ++k)
        ranked.col(k) = axes.col(order[k]);
    axes = ranked;
    local = axes.transpose() * (mesh.vertices.colwise() - middle);
    const Vector3d low = local.rowwise().minCoeff();
    extent = (local.rowwise().maxCoeff() - low).cwiseMax(2.0 * kThinnest_m);

    const double wanted = std::floor(extent.y() / std::max(extent.z(), leastWidth_m) + 0.5);
    const int strips = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(most)));
    const double width = extent.y() / strips;
    // A single capsule has the mesh's average width as seen from its sides.
    const double radius = strips > 1 ? 0.5 * width : 0.25 * (width + extent.z());
    for (int i = 0; i < strips; ++i)
    {
        const double from = low.y() + width * i;
        const Range range = within(local, mesh.triangles, from, from + width);
        if (!(range.high >= range.low)) continue;
        const double y = from + 0.5 * width;
        const double z = low.z() + 0.5 * extent.z();
        const double inset = std::min(radius, 0.5 * (range.high - range.low));
        capsules.push_back({middle + axes * Vector3d(range.low + inset, y, z),
                            middle + axes * Vector3d(range.high - inset, y, z),
                            radius});
    }
    return capsules;
}

bool equivalent(const HandsAndObstacles& a, const HandsAndObstacles& b)
{
    if (a.reach_m != b.reach_m || a.shadows != b.shadows) return false;
    if ((a.reach_m > 0.0 || a.shadows) && !nearHands(a.hands, b.hands)) return false;
    return !a.shadows || nearProps(a.props, b.props);
}

std::uint64_t ReachAndShadow::keepWithinReach(haptics::ControlPoints& points,
                                              Eigen::Matrix3Xd& skipped) const
{
    if (!(_last.reach_m > 0.0)) return 0;
    const std::vector<bool> within = withinReach(points.positions, _last.hands, _last.reach_m);
    std::vector<int> kept;
    const Eigen::Index before = skipped.cols();
    skipped.conservativeResize(3, before + points.size());
    Eigen::Index left = before;
    for (int l = 0; l < points.size(); ++l)
        if (within[static_cast<std::size_t>(l)])
            kept.push_back(l);
        else
            skipped.col(left++) = points.positions.col(l);
    skipped.conservativeResize(3, left);
    points = haptics::pick(points, kept);
    return static_cast<std::uint64_t>(left - before);
}

const haptics::TransducerArray& ReachAndShadow::shadowed(const haptics::ControlPoints& points,
                                                         const haptics::TransducerArray& array,
                                                         double wavelength_m)
{
    if (!_last.shadows || (_last.hands.empty() && _last.props.empty())) return array;
    std::vector<Capsule> obstacles = _last.props;
    for (const HandCapsule& hand : _last.hands)
        obstacles.push_back(hand.shape);
    ShadowOptions options;
    options.wavelength_m = wavelength_m;
    const Eigen::VectorXd gains = shadowGains(points.positions, array, obstacles, options);
    if ((gains.array() == 1.0).all()) return array;
    _shadowed = array;
    if (array.gain.size() == gains.size())
        _shadowed.gain = array.gain.cwiseProduct(gains);
    else
        _shadowed.gain = gains;
    return _shadowed;
}

} // namespace midair::bridge
