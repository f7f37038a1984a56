#include "haptics/points/Workspace.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/SurfaceSampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Spacing of the points at which an outline is checked; control points are denser.
constexpr double kLook_wavelengths = 0.5;

bool areInside(const Eigen::Matrix3Xd& points, const Workspace& workspace)
{
    for (const auto& point : points.colwise())
        if (workspace.judge(point) != Workspace::Verdict::INSIDE) return false;
    return true;
}

} // namespace

Workspace::Workspace(const TransducerArray& array,
                     double wavelength_m,
                     const SelectorOptions& options) :
    _positions(array.positions),
    _normals(array.normals),
    _reflectors(array.reflectors),
    _wavelength(wavelength_m),
    _minDistance(options.minDistanceWavelengths * wavelength_m),
    _reach(options.reach_m)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    if (array.size() == 0) throw base::InputError("The array has no transducers");
    if (!(wavelength_m > 0.0) || !std::isfinite(wavelength_m))
    {
        throw base::InputError(
            fmt::format("The wavelength is {:g} m; it must be positive and finite", wavelength_m));
    }
    if (!(_reach > 0.0))
    {
        constexpr double kLeastReach_m = 0.3;
        const Eigen::Vector3d extent =
            _positions.rowwise().maxCoeff() - _positions.rowwise().minCoeff();
        _reach = std::max(2.0 * extent.maxCoeff(), kLeastReach_m);
    }
    constexpr double kSamePlane = 1e-6; // m, and of a unit vector
    for (int i = 0; i < array.size(); ++i)
    {
        const Eigen::Vector3d normal = _normals.col(i);
        const double offset = normal.dot(_positions.col(i));
        const bool known =
            std::any_of(_planes.begin(),
                        _planes.end(),
                        [&](const Plane& plane)
                        {
                            return std::abs(plane.offset - offset) < kSamePlane &&
                                   (plane.normal - normal).squaredNorm() < kSamePlane * kSamePlane;
                        });
        if (!known) _planes.push_back({normal, offset, _positions.col(i)});
    }
}

Workspace::Verdict Workspace::judge(const Eigen::Vector3d& point) const
{
    for (const Reflector& one : _reflectors)
        if (one.reflection > 0.0 && one.distanceTo(point) < _wavelength)
            return Verdict::AT_REFLECTOR;
    // A point at least the least distance in front of every plane, and within reach of one
    // transducer, is inside. This is true of all points in a prism and saves a loop over the
    // transducers.
    bool inFront = true;
    bool near = false;
    for (const Plane& plane : _planes)
    {
        if (plane.normal.dot(point) - plane.offset < _minDistance)
        {
            inFront = false;
            break;
        }
        near = near || (plane.sample - point).squaredNorm() <= _reach * _reach;
    }
    if (inFront && near) return Verdict::INSIDE;

    Eigen::Index nearest = 0;
    const double distance =
        std::sqrt((_positions.colwise() - point).colwise().squaredNorm().minCoeff(&nearest));
    if (distance > _reach) return Verdict::OUT_OF_REACH;
    const double height = _normals.col(nearest).dot(point - _positions.col(nearest));
    if (height < 0.0)
    {
        // Directly behind the nearest transducer, its board hides the point from all others. Far to
        // its side others may still reach it.
        const double side = std::sqrt(std::max(0.0, distance * distance - height * height));
        if (side <= std::max(-height, _wavelength)) return Verdict::BEHIND;
        const bool seen =
            ((_normals.array() * (-(_positions.colwise() - point)).array()).colwise().sum() > 0.0)
                .any();
        if (!seen) return Verdict::BEHIND;
    }
    return distance < _minDistance ? Verdict::TOO_CLOSE : Verdict::INSIDE;
}

ReachedOutlines reachedOutlines(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                double target,
                                const Workspace& workspace,
                                const base::StopToken& stop)
{
    const double look_m = kLook_wavelengths * workspace.wavelength_m();
    ReachedOutlines reached;
    for (Outline& outline : featureOutlines(mesh,
                                            SamplerOptions().creaseAngle_rad,
                                            workspace.wavelength_m(),
                                            stop,
                                            &reached.apart))
    {
        outline.vertices = (pose * outline.vertices).eval();
        outline.target = target;
        const double points = pointsAlong({outline}, look_m); // before points() allocates them
        if (points > base::kMostControlPoints || !areInside(outline.points(look_m), workspace))
        {
            ++reached.outside;
            continue;
        }
        reached.points += points;
        reached.inside.push_back(std::move(outline));
    }
    return reached;
}

} // namespace midair::haptics
