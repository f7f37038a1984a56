#include "engine-bridge/PointAssembler.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

/// Largest distance that any of \a corners travels from pose \a a to pose \a b.
double travel(const Eigen::Matrix<double, 3, 8>& corners,
              const Eigen::Isometry3d& a,
              const Eigen::Isometry3d& b)
{
    const Eigen::Matrix3d turned = b.linear() - a.linear();
    const Eigen::Vector3d moved = b.translation() - a.translation();
    return ((turned * corners).colwise() + moved).colwise().norm().maxCoeff();
}

} // namespace

bool operator==(const HapticProperties& a, const HapticProperties& b)
{
    return a.pressure == b.pressure && a.pressureInPa == b.pressureInPa &&
           a.spacing_m == b.spacing_m && a.sampling == b.sampling && a.priority == b.priority;
}

bool PointAssembler::usable(const HapticObject& object)
{
    auto refuse = [this, &object](const std::string& why)
    {
        _messages.say(object.path + ": " + why + "; it can't be felt");
        return false;
    };
    const HapticProperties& p = object.properties;
    if (!object.mesh || object.mesh->triangles.cols() == 0) return refuse("has no triangles");
    if (!object.pose.matrix().allFinite()) return refuse("its pose is not finite");
    if (!(p.pressure > 0.0) || !std::isfinite(p.pressure))
        return refuse("pressure is " + std::to_string(p.pressure) + ", should be over 0");
    if (!(p.spacing_m >= 0.0) || !std::isfinite(p.spacing_m))
        return refuse("spacing is " + std::to_string(p.spacing_m) + " m, should be at least 0");
    return true;
}

bool PointAssembler::unmoved(const SceneSnapshot& snapshot)
{
    if (!_assembled || snapshot.objects.size() != _placed.size()) return false;
    for (std::size_t i = 0; i < _placed.size(); ++i)
    {
        const HapticObject& now = snapshot.objects[i];
        const Placed& then = _placed[i];
        // Written so that a pose that is not finite counts as moved.
        const bool still = now.id == then.id && now.meshId == then.meshId &&
                           now.properties == then.properties &&
                           travel(then.corners, now.pose, then.pose) <= _options.motionTolerance_m;
        if (!still) return false;
    }
    return true;
}

AssembledPoints PointAssembler::assemble(const SceneSnapshot& snapshot,
                                         const haptics::TransducerArray& array)
{
    AssembledPoints out;
    double strongest_Pa = 0.0;
    for (const HapticObject& object : snapshot.objects)
        if (object.properties.pressureInPa)
            strongest_Pa = std::max(strongest_Pa, object.properties.pressure);
    out.absolute = strongest_Pa > 0.0;

    _placed.clear();
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        const HapticProperties& p = object.properties;
        Placed& placed = _placed.emplace_back();
        placed.id = object.id;
        placed.meshId = object.meshId;
        placed.properties = p;
        placed.pose = object.pose;
        // Where some objects are in Pa, the others are relative to the strongest of those.
        const double unit_Pa = out.absolute && !p.pressureInPa ? strongest_Pa : 1.0;
        if (usable(object)) add(object, static_cast<int>(i), unit_Pa, out);
    }
    _samples.endSnapshot();
    _assembled = true;
    select(out, array);
    return out;
}

void PointAssembler::add(const HapticObject& object,
                         int index,
                         double unit_Pa,
                         AssembledPoints& out)
{
    const HapticProperties& p = object.properties;
    const CachedSamples& cached =
        _samples.get(object, p.spacing_m > 0.0 ? p.spacing_m : _options.wavelength_m);
    _placed.back().corners = cached.corners;
    if (!cached.error.empty())
    {
        _messages.say(object.path + ": " + cached.error + "; it can't be felt");
        return;
    }
    const haptics::SurfaceSamples& samples = cached.samples;
    haptics::ControlPoints& points = out.points;
    const int before = points.size();
    const int total = before + samples.size();
    points.positions.conservativeResize(3, total);
    points.normals.conservativeResize(3, total);
    points.targets.conservativeResize(total);
    points.object.resize(static_cast<std::size_t>(total), index);
    int n = before;
    for (int i = 0; i < samples.size(); ++i)
    {
        // Painted black: not felt at all.
        const double target = p.pressure * unit_Pa * static_cast<double>(samples.intensity[i]);
        if (!(target > 0.0)) continue;
        points.positions.col(n) = object.pose * samples.positions.col(i);
        points.normals.col(n) = object.pose.linear() * samples.normals.col(i);
        points.targets[n] = target;
        ++n;
    }
    points.positions.conservativeResize(3, n);
    points.normals.conservativeResize(3, n);
    points.targets.conservativeResize(n);
    points.object.resize(static_cast<std::size_t>(n));
}

void PointAssembler::select(AssembledPoints& out, const haptics::TransducerArray& array)
{
    (void)array;
    out.skipped.resize(3, 0);
}

} // namespace midair::bridge
