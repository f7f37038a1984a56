#pragma once

#include "engine-bridge/tags/TagFit.h"
#include "tests/engine-bridge/display/LightTracer.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

/// Photos of printed tags, and of those that a screen shows through its optics, ray by ray from the
/// tags' bitmaps. Shares no formula with what is tested: where the screen is seen follows from
/// light that is traced.
class TagSimulation
{
public:
    using V = Eigen::Vector3d;

    /// \a shown: what the screen of \a truth shows.
    TagSimulation(midair::bridge::Display truth,
                  midair::bridge::TagRig rig,
                  std::vector<midair::bridge::ShownTag> shown,
                  std::uint64_t seed) :
        _truth(std::move(truth)),
        _tracer(_truth),
        _rig(std::move(rig)),
        _random(seed)
    {
        const midair::bridge::TagDetector detector;
        for (const midair::bridge::PlacedTag& tag : _rig.tags)
            _printed.push_back(detector.bitmap(tag.id));
        for (midair::bridge::ShownTag& tag : shown)
            _shown.emplace_back(tag, detector.bitmap(tag.id));
    }

    /// Five tags below a picture that stands upright at y = 0, seen from about (0, -0.75, 0.15) by
    /// an ideal camera.
    static midair::bridge::TagRig rig()
    {
        midair::bridge::TagRig rig;
        rig.camera.width = 1280;
        rig.camera.height = 960;
        rig.camera.fx = rig.camera.fy = 1000.0;
        rig.camera.cx = 640.0;
        rig.camera.cy = 480.0;
        for (int k = 0; k < 5; ++k)
            rig.tags.push_back({k,
                                0.06,
                                {-0.2 + 0.1 * k, 0.01 * (k % 2), -0.08 + 0.015 * (k % 3)},
                                V::UnitX(),
                                V(0.0, 0.5, 0.866).normalized()});
        return rig;
    }

    /// A camera there, aside by up to \a aside_m, turned by up to 6 degrees; world to camera.
    Eigen::Isometry3d camera(double aside_m)
    {
        const auto within = [&](double most)
        { return std::uniform_real_distribution<double>(-most, most)(_random); };
        const double x = within(aside_m), y = within(aside_m), z = within(aside_m);
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear().col(0) = V::UnitX();
        pose.linear().col(1) = -V::UnitZ();
        pose.linear().col(2) = V::UnitY();
        pose.translation() = V(x, -0.75 + y, 0.1 + z);
        for (int axis = 0; axis < 3; ++axis)
            pose.rotate(Eigen::AngleAxisd(within(0.1), V(V::Unit(axis))));
        return pose.inverse();
    }

    midair::bridge::GrayImage photo(const Eigen::Isometry3d& worldToCamera)
    {
        const Eigen::Isometry3d pose = worldToCamera.inverse();
        const V eye = pose.translation();
        midair::bridge::GrayImage image{_rig.camera.width, _rig.camera.height, {}};
        image.pixels.resize(static_cast<std::size_t>(image.width * image.height));
        std::normal_distribution<double> noise(0.0, 2.0);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
            {
                const auto light = [&](double px, double py)
                {
                    const V way = pose.linear() * V((px - _rig.camera.cx) / _rig.camera.fx,
                                                    (py - _rig.camera.cy) / _rig.camera.fy,
                                                    1.0);
                    return brightness(eye, way);
                };
                // Two rays tell whether an edge goes through the pixel, and then two more.
                const double first = light(x + 0.25, y + 0.25);
                const double last = light(x + 0.75, y + 0.75);
                double value = 0.5 * (first + last);
                if (first != last)
                    value = 0.5 * value +
                            0.25 * (light(x + 0.75, y + 0.25) + light(x + 0.25, y + 0.75));
                value += noise(_random);
                image.at(x, y) =
                    static_cast<std::uint8_t>(std::lround(std::fmin(255.0, std::fmax(0.0, value))));
            }
        return image;
    }

private:
    /// Of a bitmap at \a right and \a up, -0.5 .. 0.5 across the black square; none: beside it.
    static std::optional<double>
    square(const midair::bridge::GrayImage& bitmap, double right, double up)
    {
        const double i = 5.0 + 8.0 * right;
        const double j = 5.0 - 8.0 * up;
        if (!(i >= 0.0 && j >= 0.0 && i < 10.0 && j < 10.0)) return {};
        return bitmap.pixels[static_cast<std::size_t>(static_cast<int>(j) * 10 +
                                                      static_cast<int>(i))] > 128
                   ? 230.0
                   : 20.0;
    }

    double brightness(const V& eye, const V& way) const
    {
        for (std::size_t k = 0; k < _printed.size(); ++k)
        {
            const midair::bridge::PlacedTag& tag = _rig.tags[k];
            const V normal = tag.right.cross(tag.up);
            const double s = normal.dot(tag.middle - eye) / normal.dot(way);
            if (!(s > 0.0)) continue;
            const V at = (eye + s * way - tag.middle) / tag.size_m;
            if (const auto value = square(_printed[k], tag.right.dot(at), tag.up.dot(at)))
                return *value;
        }
        const auto pixel = _tracer.pixel(eye, eye + way);
        if (!pixel) return 60.0;
        const Eigen::Vector2d share(pixel->x() / _truth.width, pixel->y() / _truth.height);
        for (const auto& [tag, bitmap] : _shown)
        {
            // A shown tag's edges are along the screen's: both directions by their ends.
            const Eigen::Vector2d across = tag.corners[1] - tag.corners[0];
            const Eigen::Vector2d up = tag.corners[3] - tag.corners[0];
            const Eigen::Vector2d from =
                share - 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
            if (const auto value = square(bitmap, from.x() / across.x(), from.y() / up.y()))
                return *value;
        }
        return 20.0;
    }

    midair::bridge::Display _truth;
    LightTracer _tracer;
    midair::bridge::TagRig _rig;
    std::mt19937_64 _random;
    std::vector<midair::bridge::GrayImage> _printed;
    std::vector<std::pair<midair::bridge::ShownTag, midair::bridge::GrayImage>> _shown;
};
