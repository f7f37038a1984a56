#pragma once

#include "engine-bridge/display/DisplayFit.h"
#include "tests/engine-bridge/display/LightTracer.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>
#include <vector>

/// \a truth as its file may have it before: moved by some centimetres, turned by some degrees.
inline midair::bridge::Display guessedDisplay(const midair::bridge::Display& truth)
{
    midair::bridge::Display display = truth;
    const Eigen::AngleAxisd turn(0.06, Eigen::Vector3d(1.0, -2.0, 0.5).normalized());
    for (Eigen::Vector3d* corner : {&display.lowerLeft, &display.lowerRight, &display.upperLeft})
        *corner = turn * *corner + Eigen::Vector3d(0.02, -0.01, 0.03);
    return display;
}

/// Sights as people make them: the fingertip is so far from the eye; noise of fingertips and heads.
constexpr double kSightReach_m = 0.45;
constexpr double kSightNoise_m = 2e-3;

/// People who touch the crosses of a display whose screen is somewhere else than its file says.
/// Where a cross is seen follows from light that is traced from two eyes: no formula is shared with
/// what is tested.
class CrossSimulation
{
public:
    using V = Eigen::Vector3d;

    CrossSimulation(midair::bridge::Display truth, std::uint64_t seed) :
        _truth(std::move(truth)),
        _tracer(_truth),
        _random(seed)
    {
        for (const Eigen::Vector2d& share : midair::bridge::displayCrosses())
            _crosses.push_back(seenPlace({share.x() * _truth.width, share.y() * _truth.height}));
        _middle = seenPlace({0.5 * _truth.width, 0.5 * _truth.height});
    }

    /// Where \a pixel is seen: the place from whose direction both of two eyes see it.
    V seenPlace(const Eigen::Vector2d& pixel) const
    {
        const V eyes[] = {{-0.1, -0.8, 0.25}, {0.1, -0.85, 0.35}};
        V place(0.0, 0.05, 0.15);
        const auto miss = [&](const V& at)
        {
            Eigen::Vector4d both = Eigen::Vector4d::Zero();
            for (int i = 0; i < 2; ++i)
                if (const auto seen = _tracer.pixel(eyes[i], at))
                    both.segment<2>(2 * i) = *seen - pixel;
            return both;
        };
        for (int round = 0; round < 40; ++round)
        {
            Eigen::Matrix<double, 4, 3> slope;
            for (int i = 0; i < 3; ++i)
                slope.col(i) = (miss(place + 1e-6 * V::Unit(i)) - miss(place)) / 1e-6;
            V step = (slope.transpose() * slope).inverse() * (slope.transpose() * miss(place));
            place -= step * std::min(1.0, 0.05 / std::max(1e-12, step.norm()));
        }
        return place;
    }

    const V& middle() const { return _middle; }

    V noise(double sigma_m)
    {
        std::normal_distribution<double> normal(0.0, sigma_m);
        const double x = normal(_random), y = normal(_random), z = normal(_random);
        return {x, y, z};
    }
    double within(double most)
    {
        return std::uniform_real_distribution<double>(-most, most)(_random);
    }

    std::vector<midair::bridge::CrossTouch> touches(double sigma_m)
    {
        std::vector<midair::bridge::CrossTouch> all;
        for (std::size_t k = 0; k < _crosses.size(); ++k)
            all.push_back({static_cast<int>(k), _crosses[k] + noise(sigma_m), {}});
        return all;
    }

    /// Each of \a heads sees all crosses with the right eye, over a fingertip that is \a reach_m
    /// before it. Noise of the fingertip and of the head; the eye is \a off from where the head
    /// says, in its frame.
    std::vector<midair::bridge::CrossTouch> sights(const std::vector<Eigen::Isometry3d>& heads,
                                                   double reach_m,
                                                   double sigma_m,
                                                   const V& off = V::Zero())
    {
        std::vector<midair::bridge::CrossTouch> all;
        for (const Eigen::Isometry3d& head : heads)
            for (std::size_t k = 0; k < _crosses.size(); ++k)
            {
                const V eye = head * V(off + V(0.5 * _truth.ipd_m, 0.0, 0.0));
                const V tip = eye + reach_m * (_crosses[k] - eye).normalized();
                Eigen::Isometry3d seen = head;
                seen.translation() += noise(sigma_m);
                all.push_back({static_cast<int>(k), tip + noise(sigma_m), seen});
            }
        return all;
    }

    /// A head about 0.8 m before the picture, aside by up to \a aside_m and turned by up to 20
    /// degrees about each axis.
    Eigen::Isometry3d head(double aside_m)
    {
        Eigen::Isometry3d pose = displays::head(0.0, {0.0, -0.55, 0.28});
        const double x = within(aside_m), y = within(aside_m), z = within(aside_m);
        pose.pretranslate(V(x, y, z));
        for (int axis = 0; axis < 3; ++axis)
            pose.rotate(Eigen::AngleAxisd(within(0.35), V(V::Unit(axis))));
        return pose;
    }

    /// So many heads, 0.25 m aside at most, \a apart_m at least from each other.
    std::vector<Eigen::Isometry3d> heads(std::size_t count, double apart_m)
    {
        std::vector<Eigen::Isometry3d> all;
        while (all.size() < count)
        {
            const Eigen::Isometry3d next = head(0.25);
            const bool isApart =
                std::all_of(all.begin(),
                            all.end(),
                            [&](const Eigen::Isometry3d& known) {
                                return (known.translation() - next.translation()).norm() > apart_m;
                            });
            if (isApart) all.push_back(next);
        }
        return all;
    }

    /// How far (m) the picture's middle is off in \a trials of \a fit, ascending.
    std::vector<double>
    errors(int trials, const std::function<midair::bridge::DisplayFit(CrossSimulation&)>& fit)
    {
        std::vector<double> all;
        for (int i = 0; i < trials; ++i)
            all.push_back((fit(*this).middle() - _middle).norm());
        std::sort(all.begin(), all.end());
        return all;
    }

private:
    midair::bridge::Display _truth;
    LightTracer _tracer;
    std::mt19937_64 _random;
    std::vector<V> _crosses;
    V _middle;
};
