#include "engine-bridge/hands/Obstacles.h"

#include "engine-bridge/hands/Fresnel.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// sqrt(2 (d1 + d2)/(lambda d1 d2)), 1/m.
double fresnelScale(double d1, double d2, double wavelength_m)
{
    const double least = wavelength_m / 8.0;
    const double a = std::max(d1, least);
    const double b = std::max(d2, least);
    return std::sqrt(2.0 * (a + b) / (wavelength_m * a * b));
}

/// The nearer edge, in units of v, of an obstacle that lies behind the point in the sound's
/// direction, or below it; only an obstacle whose skin is at or near the point takes anything away.
/// It is the mirror image of the edge at the horizon, so that weights pass smoothly through 1/2
/// there. \a sine is that of the angle over the horizon, 0 .. 1.
double edgeBehind(double sine, double gap, double radius_m, double wavelength_m)
{
    const double cosine = std::sqrt(std::max(0.0, 1.0 - sine * sine));
    const double distance = std::max(radius_m * sine, wavelength_m / 8.0);
    return radius_m * (1.0 - cosine) * std::sqrt(2.0 / (wavelength_m * distance)) +
           4.0 * gap / wavelength_m;
}

/// The point itself; if it is inside obstacles, the nearest place on the skin of the one that it is
/// deepest in.
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

/// shadowWeight() for a point that was moved by onSkin().
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
    // The axis as seen along the path: from a to b, at the distance x from the path.
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
    /// Cosine of the angle to the direction of the obstacle's middle beyond which a path from
    /// \a spot is lit. The angle includes the sphere round the obstacle and the penumbra round that
    /// at its far side. -2 if the spot is inside of both.
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

/// The obstacles that may be in a path's way. All paths are in the ball round transducers and
/// points, and the penumbra, v = kLit, is widest in the middle of its longest path.
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
    // Written so that what is no number stays.
    const auto isFar = [&](const Capsule& obstacle)
    {
        const double half = 0.5 * (obstacle.b - obstacle.a).norm() + obstacle.radius_m;
        return (0.5 * (obstacle.a + obstacle.b) - middle).norm() - half > limit;
    };
    result.erase(std::remove_if(result.begin(), result.end(), isFar), result.end());
    return result;
}

} // namespace

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
        // Uses as many points as the budget allows if each costs as much as this one.
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

} // namespace midair::bridge
