#pragma once

#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

/// Points whose targets differ by up to a thousand, and errors of the fields for them, recomputed
/// in double from the levels of the device with nothing of the solver: midair-targets-bench prints
/// them, and tests hold them to bars.
namespace midair::haptics
{

/// Errors of one field at the level s = (y.a)/(a.a), 1 for targets in Pa.
struct TargetErrors
{
    double loud = 0.0;      ///< largest |y/(s a) - 1| of targets from 0.3 of the largest
    double middle = 0.0;    ///< the same from 0.01 to 0.3
    double rms = 0.0;       ///< of (y - s a)/s over the largest target
    double ofLargest = 0.0; ///< its largest
    double own = 0.0;       ///< largest |y/(s a) - 1| of all
    double level_Pa = 0.0;  ///< s times the largest target
    Eigen::VectorXd y_Pa;   ///< pressures at the points
};

/// Returns the activations of the device's levels nearest to \a q: amplitude level times
/// exp(j 2 pi L / phaseLevels).
inline Eigen::VectorXcd onLevels(const Eigen::VectorXcf& q, const DriveResolution& drive)
{
    Eigen::VectorXcd played(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i)
    {
        double amplitude = std::abs(std::complex<double>(q[i])),
               phase = std::arg(std::complex<double>(q[i]));
        const std::vector<float>& levels = drive.amplitudeLevels;
        if (!levels.empty())
            amplitude =
                *std::min_element(levels.begin(),
                                  levels.end(),
                                  [&](double a, double b)
                                  { return std::fabs(a - amplitude) < std::fabs(b - amplitude); });
        if (drive.phaseLevels > 0)
        {
            const double step = 2.0 * M_PI / drive.phaseLevels;
            phase = step * std::round(phase / step);
        }
        played[i] = std::polar(amplitude, phase);
    }
    return played;
}

/// Returns the errors of \a q for \a points, whose matrix is \a G.
inline TargetErrors errorsAt(const ControlPoints& points,
                             const Eigen::MatrixXcd& G,
                             const TransducerArray& array,
                             const Eigen::VectorXcf& q)
{
    TargetErrors errors;
    errors.y_Pa = (G * onLevels(q, array.drive)).cwiseAbs();
    const double largest = points.targets.maxCoeff();
    // Lower targets count as a thousandth of the largest; where there is none, nothing is asked
    // for.
    const Eigen::VectorXd a =
        (points.targets.array() > 0.0).select(points.targets.cwiseMax(1e-3 * largest), 0.0);
    const double s = points.absolute ? 1.0 : errors.y_Pa.dot(a) / a.dot(a);
    errors.level_Pa = s * largest;
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        if (a[l] == 0.0) continue; // nothing is asked for there
        const double off = std::fabs(errors.y_Pa[l] - s * a[l]) / s;
        errors.rms += std::pow(off / largest, 2) / static_cast<double>(a.size());
        errors.ofLargest = std::max(errors.ofLargest, off / largest);
        errors.own = std::max(errors.own, off / a[l]);
        double& band = a[l] >= 0.3 * largest ? errors.loud : errors.middle;
        if (a[l] >= 0.01 * largest) band = std::max(band, off / a[l]);
    }
    errors.rms = std::sqrt(errors.rms);
    return errors;
}

/// \a n targets from 1 down to 1/\a ratio, evenly spread in the logarithm, in no order.
inline Eigen::VectorXd spreadTargets(int n, double ratio, int stride = 7919)
{
    Eigen::VectorXd targets(n);
    for (int l = 0; l < n; ++l)
        targets[l] = std::pow(ratio, -static_cast<double>((l * stride) % n) / (n - 1));
    return targets;
}

/// Two spheres of 20 mm with \a each points, their middles 80 mm apart; the second one's targets
/// are \a second.
inline ControlPoints twoSpheres(int each, double second)
{
    const ControlPoints one = spherePoints(each, 0.02, {-0.04, 0.0, 0.0});
    const ControlPoints two = spherePoints(each, 0.02, {0.04, 0.0, 0.0});
    ControlPoints points = one;
    points.positions.resize(3, 2 * each);
    points.normals.resize(3, 2 * each);
    points.positions << one.positions, two.positions;
    points.normals << one.normals, two.normals;
    points.targets.resize(2 * each);
    points.targets << one.targets, second * two.targets;
    return points;
}

/// Ten points \a spacing_m apart, 120 mm before a flat board, with targets of 0.3 to 1.
inline ControlPoints tenUnequal(double spacing_m)
{
    ControlPoints points = gridPoints(5, 2, 1, spacing_m);
    points.positions.row(2).array() += 0.12;
    for (int l = 0; l < points.size(); ++l)
        points.targets[l] = 0.3 + 0.7 * (l * 7 % 10) / 9.0;
    return points;
}

/// A sphere of 30 mm whose paint is \a paint of the height, 0 .. 1.
inline ControlPoints paintedSphere(int n, const std::function<double(double)>& paint)
{
    ControlPoints points = spherePoints(n, 0.03);
    for (int l = 0; l < n; ++l)
        points.targets[l] = paint(0.5 + 0.5 * points.normals(1, l));
    return points;
}

/// One field after the other: what is asked for in each.
struct TargetsCase
{
    std::string name;
    int fields = 0;
    std::function<ControlPoints(int)> points; ///< of field 0 .. fields - 1
};

/// The points of \a base, moved by \a k steps of 1 mm and 1 degree in turning directions.
inline ControlPoints stepped(ControlPoints base, int steps)
{
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int k = 0; k < steps; ++k)
    {
        const double t = 0.05 * k;
        place += 1e-3 * Eigen::Vector3d(std::cos(t) * std::cos(2 * t),
                                        std::sin(t) * std::cos(2 * t),
                                        -std::sin(2 * t));
        const Eigen::Vector3d axis =
            Eigen::Vector3d(std::cos(3 * t), std::sin(t), 1.0).normalized();
        rotation = Eigen::AngleAxisd(M_PI / 180.0, axis) * rotation;
    }
    base.positions = (rotation * base.positions).colwise() + place;
    return base;
}

/// At rest from nothing, and for \a fields more.
inline TargetsCase restCase(std::string name, const ControlPoints& points, int fields = 4)
{
    return {std::move(name), fields, [points](int) { return points; }};
}

/// At rest with equal targets, then with those of \a points from field 2 on.
inline TargetsCase jumpCase(std::string name,
                            const ControlPoints& points,
                            const Eigen::VectorXd& before,
                            int fields = 8)
{
    return {std::move(name),
            fields,
            [points, before](int k)
            {
                ControlPoints now = points;
                if (k < 2) now.targets = before;
                return now;
            }};
}

/// Fields from which on bars of rest are held: a jump is at field 2.
constexpr int kSettled = 3;

inline ControlPoints withTargets(ControlPoints points, const Eigen::VectorXd& targets)
{
    points.targets = targets;
    return points;
}

/// Everything that is held to the bars of rest.
inline std::vector<TargetsCase> restCases(int n = 100)
{
    std::vector<TargetsCase> all;
    const ControlPoints sphere = spherePoints(n, 0.03);
    const Eigen::VectorXd equal = sphere.targets;
    for (const double ratio : {3.0, 10.0, 30.0, 100.0, 1000.0})
    {
        const std::string to = "1:" + std::to_string(static_cast<int>(ratio));
        const Eigen::VectorXd spread = spreadTargets(n, ratio);
        all.push_back(restCase("spread " + to, withTargets(sphere, spread)));
        all.push_back(jumpCase("jump to spread " + to, withTargets(sphere, spread), equal));
        all.push_back(
            jumpCase("jump of spread " + to, withTargets(sphere, spread.reverse()), spread));
        all.push_back(restCase("two spheres " + to, twoSpheres(n / 2, 1.0 / ratio)));
        all.push_back(jumpCase("two spheres, jump to " + to,
                               twoSpheres(n / 2, 1.0 / ratio),
                               twoSpheres(n / 2, 1.0).targets));
        all.push_back(jumpCase("two spheres, jump from " + to,
                               twoSpheres(n / 2, 1.0),
                               twoSpheres(n / 2, 1.0 / ratio).targets));
    }
    all.push_back(restCase("lower half 0.01",
                           paintedSphere(n, [](double h) { return h < 0.5 ? 0.01 : 1.0; })));
    all.push_back(restCase(
        "soft spot 0.1",
        paintedSphere(n,
                      [](double h) { return 1.0 - 0.9 * std::exp(-std::pow((1 - h) / 0.2, 2)); })));
    all.push_back(restCase("ramp, squared",
                           paintedSphere(n, [](double h) { return std::max(h * h, 1e-3); })));
    all.push_back(restCase("one point 1, others 0.01",
                           paintedSphere(n, [](double h) { return h > 0.99 ? 1.0 : 0.01; })));
    all.push_back(restCase("one point 0.001",
                           paintedSphere(n, [](double h) { return h > 0.99 ? 1e-3 : 1.0; })));
    return all;
}

/// 1 mm and 1 degree an update; targets 0.03 to 1.
inline TargetsCase movingCase(int n, double ratio, int fields)
{
    const ControlPoints base = withTargets(spherePoints(n, 0.03), spreadTargets(n, ratio));
    return {"moving 1:" + std::to_string(std::lround(ratio)) + ", n " + std::to_string(n),
            fields,
            [base](int k) { return stepped(base, k); }};
}

/// Two spheres, the second of which fades within 30 fields, evenly or by a factor a field.
inline TargetsCase fadingCase(bool byFactor, bool rising)
{
    return {std::string(rising ? "rising" : "fading") + (byFactor ? " by a factor" : " evenly"),
            36,
            [=](int k)
            {
                const int step = std::clamp(k - 2, 0, 30);
                const int left = rising ? step : 30 - step;
                return twoSpheres(50, byFactor ? std::pow(1e-4, 1.0 - left / 30.0) : left / 30.0);
            }};
}

/// Solves a case, field by field.
inline void
solveCase(HologramSolver& solver,
          const TransducerArray& array,
          const TargetsCase& of,
          const std::function<
              void(int, const ControlPoints&, const SolveReport&, const Eigen::VectorXcf&)>& each)
{
    Eigen::VectorXcf q;
    for (int k = 0; k < of.fields; ++k)
    {
        const ControlPoints points = of.points(k);
        const SolveReport report = solver.solve(points, array, Medium(), q);
        each(k, points, report, q);
    }
}

} // namespace midair::haptics
