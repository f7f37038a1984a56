#include "tests/star-hand/StarHand.h"

#include "haptics/base/Units.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace midair::tests
{

namespace
{

// x and y of star.obj: tips and notches in turn, all at z = 0; the raised centre is at 15 mm.
constexpr std::array<std::array<double, 2>, 10> kOutline = {{{0.0, 0.063088},
                                                             {-0.014164, 0.019495},
                                                             {-0.06, 0.019495},
                                                             {-0.022918, -0.007446},
                                                             {-0.037082, -0.051039},
                                                             {0.0, -0.024097},
                                                             {0.037082, -0.051039},
                                                             {0.022918, -0.007446},
                                                             {0.06, 0.019495},
                                                             {0.014164, 0.019495}}};
constexpr double kRaised_m = 0.015;
// The model's y is up in the scene, its z towards the viewer, and the middle of its box in the
// origin.
constexpr double kMiddleUp_m = 0.5 * (0.063088 - 0.051039);
constexpr double kMiddleDeep_m = 0.5 * kRaised_m;

// Two strokes over the centre: along the upper arms, and from a lower one to the top.
const Eigen::Vector2d kLeft(-0.028, 0.0092 - kMiddleUp_m);
const Eigen::Vector2d kCentre(0.0, -kMiddleUp_m);
const Eigen::Vector2d kRight(0.028, 0.0092 - kMiddleUp_m);
const Eigen::Vector2d kLower(-0.018, -0.025 - kMiddleUp_m);
const Eigen::Vector2d kTop(0.0, 0.030 - kMiddleUp_m);

// Ends of the phases, s: approach, stroke, hop, stroke, return.
constexpr double kTouches_s = 0.8;
constexpr double kHops_s = 1.8;
constexpr double kLands_s = 2.8;
constexpr double kLeaves_s = 3.8;

constexpr double kAway_m = 0.03;
constexpr double kHop_m = 0.012;

/// Goes from 0 to 1 while \a t goes from \a from to \a to, at rest at both ends.
double eased(double t, double from, double to)
{
    const double s = std::clamp((t - from) / (to - from), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

/// Returns the place on the way from \a a over the centre to \a b, \a share of its length from a.
Eigen::Vector2d along(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double share)
{
    const double first = (kCentre - a).norm();
    const double second = (b - kCentre).norm();
    const double way = share * (first + second);
    if (way < first) return a + way / first * (kCentre - a);
    return kCentre + (way - first) / second * (b - kCentre);
}

/// How deep the finger presses at \a t: 1 to 3 mm while it slides, 2 mm when it begins and ends.
double depth_m(double t, double from)
{
    return 2e-3 - 1e-3 * std::sin(base::kTwoPi * (t - from) / 0.5);
}

double distanceTo(const Eigen::Matrix3Xd& front, const Eigen::Vector3d& p)
{
    double best = 1e9;
    for (Eigen::Index t = 0; t < front.cols(); t += 3)
    {
        const Eigen::Vector3d a = front.col(t);
        const Eigen::Vector3d u = front.col(t + 1) - a;
        const Eigen::Vector3d v = front.col(t + 2) - a;
        Eigen::Matrix<double, 3, 2> sides;
        sides << u, v;
        const Eigen::Vector2d s =
            (sides.transpose() * sides).inverse() * sides.transpose() * (p - a);
        if (s.minCoeff() >= 0.0 && s.sum() <= 1.0)
            best = std::min(best, (p - a - sides * s).norm());
        for (const auto& [from, way] :
             {std::pair<Eigen::Vector3d, Eigen::Vector3d>{a, u}, {a, v}, {a + u, v - u}})
        {
            const double share = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
            best = std::min(best, (p - from - share * way).norm());
        }
    }
    return best;
}

/// Returns where the middle of a ball of \a radius_m is that has the gap of \a place to the front.
/// It comes from the viewer's side.
Eigen::Vector3d ballAt(const Eigen::Matrix3Xd& front, const FingerPlace& place, double radius_m)
{
    double near = 0.0; // y of a place that is too deep in the star
    double far = -0.2; // and of one that is too far away
    for (int i = 0; i < 50; ++i)
    {
        const double y = 0.5 * (near + far);
        const bool isFar = y < -kMiddleDeep_m &&
                           distanceTo(front, {place.x_m, y, place.z_m}) > radius_m + place.gap_m;
        (isFar ? far : near) = y;
    }
    return {place.x_m, 0.5 * (near + far), place.z_m};
}

/// Folds a finger of \a hand, whose joints begin with \a proximal, by an angle at each joint.
void fold(bridge::Hand& hand, int proximal, const Eigen::Vector3d& hinge)
{
    constexpr std::array<double, 3> kFold_deg = {75.0, 95.0, 45.0};
    for (std::size_t k = 0; k < kFold_deg.size(); ++k)
    {
        const auto pivot = static_cast<std::size_t>(proximal) + k;
        const Eigen::Vector3d at = hand.joints[pivot].position;
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(-kFold_deg[k] * base::kPi / 180.0, hinge));
        for (std::size_t j = pivot; j <= static_cast<std::size_t>(proximal) + 3; ++j)
        {
            bridge::HandJoint& joint = hand.joints[j];
            joint.position = at + turn * (joint.position - at);
            joint.orientation = turn * joint.orientation;
        }
    }
}

double rounded(double value, double step)
{
    return std::round(value / step) * step;
}

void roundOff(bridge::Hand& hand)
{
    for (bridge::HandJoint& joint : hand.joints)
    {
        for (double& each : joint.position)
            each = rounded(each, 1e-5);
        for (double& each : joint.orientation.coeffs())
            each = rounded(each, 1e-4);
    }
}

} // namespace

Eigen::Matrix3Xd starFront()
{
    const auto place = [](const std::array<double, 2>& corner, double raised_m)
    { return Eigen::Vector3d(corner[0], kMiddleDeep_m - raised_m, corner[1] - kMiddleUp_m); };
    Eigen::Matrix3Xd corners(3, 3 * kOutline.size());
    for (std::size_t i = 0; i < kOutline.size(); ++i)
    {
        const auto column = static_cast<Eigen::Index>(3 * i);
        corners.col(column) = place(kOutline[i], 0.0);
        corners.col(column + 1) = place(kOutline[(i + 1) % kOutline.size()], 0.0);
        corners.col(column + 2) = place({0.0, 0.0}, kRaised_m);
    }
    return corners;
}

FingerPlace fingerAt(double time_s)
{
    const double t = time_s - kStarPeriod_s * std::floor(time_s / kStarPeriod_s);
    Eigen::Vector2d at = kLeft;
    FingerPlace place;
    if (t < kTouches_s)
        place.gap_m = kAway_m - (kAway_m + depth_m(0.0, 0.0)) * eased(t, 0.0, kTouches_s);
    else if (t < kHops_s)
    {
        at = along(kLeft, kRight, eased(t, kTouches_s, kHops_s));
        place.gap_m = -depth_m(t, kTouches_s);
    }
    else if (t < kLands_s)
    {
        const double s = (t - kHops_s) / (kLands_s - kHops_s);
        at = kRight + eased(s, 0.3, 0.7) * (kLower - kRight);
        place.gap_m = -2e-3 + (kHop_m + 2e-3) * std::pow(std::sin(base::kPi * s), 2);
    }
    else if (t < kLeaves_s)
    {
        at = along(kLower, kTop, eased(t, kLands_s, kLeaves_s));
        place.gap_m = -depth_m(t, kLands_s);
    }
    else
    {
        at = kTop + eased(t, kLeaves_s + 0.3, kStarPeriod_s) * (kLeft - kTop);
        place.gap_m = -2e-3 + (kAway_m + 2e-3) * eased(t, kLeaves_s, kStarPeriod_s);
    }
    place.x_m = at.x();
    place.z_m = at.y();
    place.slides = (t >= kTouches_s && t < kHops_s) || (t >= kLands_s && t < kLeaves_s);
    return place;
}

std::vector<bridge::HandFrame> starHand()
{
    // The finger points into the star, from below and the right; the back of the hand is up.
    const Eigen::Vector3d ahead = Eigen::Vector3d(-0.25, 0.80, 0.54).normalized();
    const Eigen::Vector3d across = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d axes;
    axes << across, across.cross(ahead), -ahead;
    const Eigen::Quaterniond turned(axes);
    const Eigen::Matrix3Xd front = starFront();
    std::vector<bridge::HandFrame> frames;
    const int count = static_cast<int>(std::lround(kStarPeriod_s * kStarRate_Hz));
    for (int i = 0; i <= count; ++i)
    {
        bridge::Hand hand = bridge::openHandWithIndexTipAt(1, Eigen::Vector3d::Zero(), turned);
        const double radius_m = 0.5 * (hand.joints[bridge::INDEX_DISTAL].radius_m +
                                       hand.joints[bridge::INDEX_TIP].radius_m);
        const Eigen::Vector3d tip = ballAt(front, fingerAt(i / kStarRate_Hz), radius_m);
        for (const int proximal :
             {bridge::MIDDLE_PROXIMAL, bridge::RING_PROXIMAL, bridge::LITTLE_PROXIMAL})
            fold(hand, proximal, across);
        for (bridge::HandJoint& joint : hand.joints)
            joint.position += tip;
        roundOff(hand);
        frames.push_back({rounded(i / kStarRate_Hz, 1e-5), {hand}, {}});
    }
    return frames;
}

} // namespace midair::tests
