#pragma once

#include "engine-bridge/display/Display.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

/// Follows sight from an eye through the optics to the lit screen, bounce by bounce. Shares nothing
/// with Picture, which reflects the screen's corners instead.
class LightTracer
{
public:
    using V = Eigen::Vector3d;

    explicit LightTracer(midair::bridge::Display display) : _display(std::move(display)) {}

    /// Returns the pixel, from the lower left corner of the screen, whose light reaches \a eye from
    /// the direction of \a place; none: no light does. \a isThroughOutlines: only within outlines.
    std::optional<Eigen::Vector2d>
    pixel(const V& eye, const V& place, bool isThroughOutlines = false) const
    {
        V at = eye;
        V way = (place - eye).normalized();
        for (std::size_t k = _display.optics.size(); k-- > 0;)
        {
            const midair::bridge::Optic& optic = _display.optics[k];
            const double s = optic.normal.dot(optic.point - at) / optic.normal.dot(way);
            if (!(s > 1e-9)) return {};
            at += s * way;
            if (isThroughOutlines && !isInside(optic, at)) return {};
            const V across = optic.normal.dot(way) * optic.normal;
            const V along = way - across;
            way = optic.kind == midair::bridge::Optic::Kind::HALF_MIRROR ? V(along - across)
                                                                         : V(across - along);
        }
        Eigen::Matrix3d sides;
        sides << _display.lowerRight - _display.lowerLeft, _display.upperLeft - _display.lowerLeft,
            -way;
        const V uvs = sides.inverse() * (at - _display.lowerLeft);
        // Light leaves the front alone.
        const bool isFront = way.dot(sides.col(0).cross(sides.col(1))) < 0.0;
        if (!isFront || !(uvs.z() > 0.0) || uvs.x() < 0.0 || uvs.x() > 1.0 || uvs.y() < 0.0 ||
            uvs.y() > 1.0)
            return {};
        return Eigen::Vector2d(uvs.x() * _display.width, uvs.y() * _display.height);
    }

    /// Returns how far (m) the sight of \a pixel from \a eye passes by \a place: the direction in
    /// which the eye sees that pixel is searched for, beginning with that of the place.
    double missOf(const V& eye, const V& place, const Eigen::Vector2d& pixelSeen) const
    {
        const auto aim = aimAt(eye, place, pixelSeen);
        if (!aim) return INFINITY;
        return (place - eye).cross((*aim - eye).normalized()).norm();
    }

    /// Returns a place in the direction in which \a eye sees that pixel; \a place is one near it.
    std::optional<V> aimAt(const V& eye, const V& place, const Eigen::Vector2d& pixelSeen) const
    {
        V aim = place;
        const V z = (place - eye).normalized();
        const V x = z.unitOrthogonal();
        const V y = z.cross(x);
        for (int round = 0; round < 20; ++round)
        {
            constexpr double kStep_m = 1e-6;
            const auto now = pixel(eye, aim);
            const auto dx = pixel(eye, aim + kStep_m * x);
            const auto dy = pixel(eye, aim + kStep_m * y);
            if (!now || !dx || !dy) return {};
            Eigen::Matrix2d slope;
            slope << (*dx - *now) / kStep_m, (*dy - *now) / kStep_m;
            const Eigen::Vector2d step = slope.inverse() * (pixelSeen - *now);
            aim += step.x() * x + step.y() * y;
        }
        return aim;
    }

private:
    /// By how often the outline goes around \a at.
    static bool isInside(const midair::bridge::Optic& optic, const V& at)
    {
        const std::size_t n = optic.outline.size();
        if (n == 0) return true;
        double turn = 0.0;
        for (std::size_t i = 0; i < n; ++i)
        {
            const V a = optic.outline[i] - at;
            const V b = optic.outline[(i + 1) % n] - at;
            turn += std::atan2(optic.normal.dot(a.cross(b)), a.dot(b));
        }
        return std::abs(turn) > 3.0;
    }

    midair::bridge::Display _display;
};

namespace displays
{

using Eigen::Vector3d;

inline midair::bridge::Display
screen(const Vector3d& left, const Vector3d& right, const Vector3d& up)
{
    midair::bridge::Display display;
    display.lowerLeft = left;
    display.lowerRight = right;
    display.upperLeft = up;
    display.width = 1040;
    display.height = 600;
    display.eye = "fixed 0 -0.8 0.3";
    return display;
}

inline midair::bridge::Optic
optic(midair::bridge::Optic::Kind kind, const Vector3d& point, const Vector3d& normal)
{
    midair::bridge::Optic optic;
    optic.kind = kind;
    optic.point = point;
    optic.normal = normal.normalized();
    return optic;
}

/// Pictures that an eye at about (0, -0.8, 0.3) looks at, y being away from it and z up.
/// A screen behind the object.
inline midair::bridge::Display window()
{
    return screen({-0.26, 0.25, 0.0}, {0.26, 0.25, 0.0}, {-0.26, 0.25, 0.30});
}
/// A screen that looks down, and a half mirror at 45 degrees below it: the picture is at y = 0.
inline midair::bridge::Display halfMirror()
{
    auto display = screen({0.26, -0.40, 0.40}, {-0.26, -0.40, 0.40}, {0.26, -0.10, 0.40});
    display.optics.push_back(
        optic(midair::bridge::Optic::Kind::HALF_MIRROR, {0.0, -0.25, 0.15}, {0.0, -1.0, 1.0}));
    return display;
}
/// A screen that looks up, behind a plate at 45 degrees: the real image is at y = 0.
inline midair::bridge::Display plate()
{
    auto display = screen({-0.26, 0.15, -0.15}, {0.26, 0.15, -0.15}, {-0.26, 0.45, -0.15});
    display.optics.push_back(
        optic(midair::bridge::Optic::Kind::PLATE, {0.0, 0.30, 0.15}, {0.0, -1.0, 1.0}));
    return display;
}
/// A periscope: the picture is at y = 0.4, and nothing is exchanged in it.
inline midair::bridge::Display twoMirrors()
{
    auto display = screen({-0.26, -0.50, 0.70}, {0.26, -0.50, 0.70}, {-0.26, -0.50, 0.40});
    display.optics.push_back(
        optic(midair::bridge::Optic::Kind::HALF_MIRROR, {0.0, -0.25, 0.55}, {0.0, 1.0, 1.0}));
    display.optics.push_back(
        optic(midair::bridge::Optic::Kind::HALF_MIRROR, {0.0, -0.25, 0.15}, {0.0, -1.0, 1.0}));
    return display;
}

inline std::vector<std::pair<const char*, midair::bridge::Display>> all()
{
    return {{"window", window()},
            {"half mirror", halfMirror()},
            {"plate", plate()},
            {"two mirrors", twoMirrors()}};
}

/// An upright head before these, turned by \a tilt_deg about its line of sight.
inline Eigen::Isometry3d head(double tilt_deg, const Vector3d& place = {0.02, -0.8, 0.28})
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = place;
    pose.linear().col(0) = Vector3d::UnitX();
    pose.linear().col(1) = Vector3d::UnitZ();
    pose.linear().col(2) = -Vector3d::UnitY();
    pose.rotate(Eigen::AngleAxisd(tilt_deg * 0.017453292519943295, Vector3d::UnitZ()));
    return pose;
}

} // namespace displays
