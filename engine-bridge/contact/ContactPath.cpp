#include "engine-bridge/contact/ContactPath.h"

#include "haptics/base/InputError.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// Share of the largest step for turning; the rest is for the hand's own motion (0.2 m/s at 1000
/// fields a second: 0.2 mm).
constexpr double kTurningShare = 0.6;
/// Hysteresis of rounding, so that a size on the border doesn't switch.
constexpr double kCountSlack = 0.25;
/// Share of the turning speed at which foci redistribute when their number changes.
constexpr double kSpreading = 0.5;

/// Longer moves cross a step of the skin, lead from finger to finger, or follow a hand that is too
/// fast: there a focus fades out and in instead of passing through flesh or air.
constexpr double kJump_m = 5e-3;
/// The same while the patch is unchanged, in largest steps: turning alone is never longer than one,
/// because the used skin is at most 53 degrees steep (skinUnder()).
constexpr double kSkinStep = 1.05;

/// Ramanujan's first formula; within 0.5 % up to axes of 1 to 20.
double circumference(double a, double b)
{
    return base::kPi * (3.0 * (a + b) - std::sqrt((3.0 * a + b) * (a + 3.0 * b)));
}

/// The shorter turn from one angle to another, -pi .. pi.
double turnBetween(double from, double to)
{
    return std::remainder(to - from, base::kTwoPi);
}

} // namespace

bool ContactPathOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactPathOptions: ")
        .within("rate_Hz", rate_Hz, 0.0, 100.0)
        .within("mostRate_Hz", mostRate_Hz, 0.0, 100.0)
        .within("mostRadius_m", mostRadius_m, 1e-3, 0.1)
        .within("focusSize_m", focusSize_m, 0.0, 0.02)
        .within("leastRadius_m", leastRadius_m, 1e-4, 0.02)
        .within("focusEach_m", focusEach_m, 1e-3, 1.0)
        .within("mostFoci", mostFoci, 1, 10)
        .within("largestStep_m", largestStep_m, 5e-5, 5e-3)
        .within("settle_s", settle_s, 0.0, 10.0)
        .within("fade_s", fade_s, 0.0, 1.0)
        .passed(error);
}

ContactPath::ContactPath(const ContactPathOptions& options,
                         const ContactPatch& patch,
                         double angle_rad) :
    _options(options),
    _patch(patch),
    _angle_rad(angle_rad)
{
    _ellipse.u = patch.normal.unitOrthogonal();
    _ellipse.v = patch.normal.cross(_ellipse.u);
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    shape();
    _steadyLength_m = circumference(_ellipse.semiMajor_m, _ellipse.semiMinor_m);
    setCount(wantedFoci());
    for (std::size_t j = 0; j < _foci.size(); ++j)
    {
        _turning[j].offset_rad =
            base::kTwoPi * static_cast<double>(j) / static_cast<double>(_foci.size());
        _foci[j].weight = 1.0;
    }
    place();
}

void ContactPath::fit(const ContactPatch& patch)
{
    // The shortest rotation from the old normal to the new one has no twist about either.
    const Eigen::Quaterniond turn = base::turnBetween(_patch.normal, patch.normal);
    _patch = patch;
    _isFitted = true;
    _ellipse.u = turn * _ellipse.u;
    _ellipse.u =
        (_ellipse.u - _ellipse.u.dot(patch.normal) * patch.normal).normalized(); // rounding
    _ellipse.v = patch.normal.cross(_ellipse.u);
    shape();
}

void ContactPath::soften(double radius_m, double more_Hz)
{
    const double radius = radius_m > 0.0 && std::isfinite(radius_m)
                              ? std::clamp(radius_m, _options.leastRadius_m, _options.mostRadius_m)
                              : 0.0;
    _softness.more_Hz = more_Hz > 0.0 && std::isfinite(more_Hz) ? more_Hz : 0.0;
    if (radius == _softness.radius_m) return;
    _softness.radius_m = radius;
    shape();
}

double ContactPath::wantedRate_Hz() const
{
    return std::max(_options.rate_Hz,
                    std::min(_options.rate_Hz + _softness.more_Hz, _options.mostRate_Hz));
}

void ContactPath::shape()
{
    if (_softness.radius_m > 0.0)
    {
        _ellipse.semiMajor_m = _ellipse.semiMinor_m = _softness.radius_m;
        _ellipse.fromCircle = _softness.radius_m * Eigen::Matrix2d::Identity();
        return;
    }
    Eigen::Matrix<double, 3, 2> plane;
    plane << _ellipse.u, _ellipse.v;
    const base::SymmetricAxes<2> across =
        base::symmetricAxes(Eigen::Matrix2d(plane.transpose() * _patch.covariance * plane));
    const Eigen::Vector2d axes =
        (2.0 * across.values.cwiseMax(0.0).cwiseSqrt().array() - _options.focusSize_m)
            .max(_options.leastRadius_m)
            .matrix();
    _ellipse.semiMinor_m = axes[0];
    _ellipse.semiMajor_m = axes[1];
    _ellipse.fromCircle = across.vectors * axes.asDiagonal() * across.vectors.transpose();
}

int ContactPath::wantedFoci() const
{
    const double exact = _steadyLength_m / _options.focusEach_m;
    int now = 0;
    for (const Turning& turning : _turning)
        now += turning.isLeaving ? 0 : 1;
    if (now > 0 && std::abs(exact - now) <= 0.5 + kCountSlack) return now;
    return static_cast<int>(
        std::clamp(std::round(exact), 1.0, static_cast<double>(_options.mostFoci)));
}

void ContactPath::setCount(int count)
{
    int now = 0;
    for (Turning& turning : _turning)
        if (!turning.isLeaving && ++now > count) turning.isLeaving = true;
    for (int j = now; j < count; ++j)
    {
        _turning.emplace_back();
        _turning.back().offset_rad = base::kTwoPi * j / count;
        _foci.push_back({Vector3d::Zero(), 0.0});
    }
}

// Distributes the foci evenly on the circle, and fades those that come or go.
void ContactPath::spread(double most_rad, double dt_s)
{
    const double fade = _options.fade_s > 0.0 ? std::min(dt_s / _options.fade_s, 1.0) : 1.0;
    const auto isStaying = [](const Turning& turning) { return !turning.isLeaving; };
    const auto count = std::count_if(_turning.begin(), _turning.end(), isStaying);
    double share = 0.0;
    for (std::size_t j = 0; j < _foci.size();)
    {
        Turning& turning = _turning[j];
        PathFocus& focus = _foci[j];
        const bool isFading = turning.isLeaving || turning.isJumping;
        focus.weight = std::clamp(focus.weight + (isFading ? -fade : fade), 0.0, 1.0);
        if (turning.isLeaving && !(focus.weight > 0.0))
        {
            _turning.erase(_turning.begin() + static_cast<std::ptrdiff_t>(j));
            _foci.erase(_foci.begin() + static_cast<std::ptrdiff_t>(j));
            continue;
        }
        if (!turning.isLeaving)
        {
            const double way =
                turnBetween(turning.offset_rad, base::kTwoPi * share / double(count));
            turning.offset_rad += std::clamp(way, -most_rad, most_rad);
            share += 1.0;
        }
        ++j;
    }
}

bool ContactPath::advance(double dt_s)
{
    if (!(dt_s >= 0.0) || !std::isfinite(dt_s)) return false;
    const double most = kTurningShare * _options.largestStep_m / _ellipse.semiMajor_m;
    const double turn = std::min(base::kTwoPi * wantedRate_Hz() * dt_s, most);
    if (dt_s > 0.0) _rate_Hz = turn / (base::kTwoPi * dt_s);
    _angle_rad = std::fmod(_angle_rad + turn, base::kTwoPi);
    const double length = circumference(_ellipse.semiMajor_m, _ellipse.semiMinor_m);
    const double follow = _options.settle_s > 0.0 ? -std::expm1(-dt_s / _options.settle_s) : 1.0;
    _steadyLength_m += follow * (length - _steadyLength_m);
    setCount(wantedFoci());
    spread(kSpreading * turn, dt_s);
    place();
    return true;
}

Vector3d ContactPath::placeAt(double angle_rad) const
{
    const Eigen::Vector2d x =
        _ellipse.fromCircle * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    return skinUnder(_patch, _patch.centre + x[0] * _ellipse.u + x[1] * _ellipse.v);
}

// Moves in a straight line; between places on the skin half a millimetre apart that is within 10 um
// of it.
void ContactPath::place()
{
    _lag_m = 0.0;
    for (std::size_t j = 0; j < _foci.size(); ++j)
    {
        const Vector3d wanted = placeAt(_angle_rad + _turning[j].offset_rad);
        const Vector3d way = wanted - _foci[j].position;
        const double length = way.norm();
        Turning& turning = _turning[j];
        const bool isStep =
            !_isFitted && (wanted - turning.wanted).norm() > kSkinStep * _options.largestStep_m;
        if (turning.isPlaced && (length > kJump_m || isStep)) turning.isJumping = true;
        turning.wanted = wanted;
        if (turning.isJumping && _foci[j].weight > 0.0) continue;
        if (!turning.isPlaced || turning.isJumping || length <= _options.largestStep_m)
            _foci[j].position = wanted;
        else
        {
            _foci[j].position += _options.largestStep_m / length * way;
            _lag_m = std::max(_lag_m, length - _options.largestStep_m);
        }
        turning.isPlaced = true;
        turning.isJumping = false;
    }
    _isFitted = false;
}

} // namespace midair::bridge
