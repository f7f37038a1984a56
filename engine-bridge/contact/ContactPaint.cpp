#include "engine-bridge/contact/ContactPaint.h"

#include <Eigen/Dense>

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr double kRange_m = 0.02;       ///< between a place and the surface under it
constexpr double kLongestFrame_s = 0.1; ///< a finger that was away for longer is there at once

bool isPainted(const MeshDistance& mesh)
{
    return mesh.mesh().paint || mesh.mesh().intensity.size() > 0;
}

/// Barycentric coordinates of \a x in the triangle \a t, clipped to it; its first corner where it
/// has no area.
Eigen::Vector3d barycentricOf(const Eigen::Vector3d& x, const Eigen::Matrix3d& t)
{
    const Eigen::Vector3d u = t.col(1) - t.col(0), v = t.col(2) - t.col(0), w = x - t.col(0);
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), area = uu * vv - uv * uv;
    if (!(area > 0.0)) return Eigen::Vector3d::UnitX();
    const double b = (vv * w.dot(u) - uv * w.dot(v)) / area;
    const double c = (uu * w.dot(v) - uv * w.dot(u)) / area;
    const Eigen::Vector3d inside = Eigen::Vector3d(1.0 - b - c, b, c).cwiseMax(0.0);
    return inside / inside.sum();
}

} // namespace

void ContactPaint::follow(std::shared_ptr<const MeshDistance> mesh,
                          const Eigen::Vector3d& place,
                          double time_s)
{
    if (!mesh || !isPainted(*mesh))
    {
        _mesh = nullptr;
        _intensity = 1.0;
        return;
    }
    const bool isNew = !_mesh || time_s - _time_s > kLongestFrame_s;
    _mesh = std::move(mesh);
    _target = place;
    _left_s = isNew ? 0.0 : std::max(time_s - _time_s, 0.0);
    _time_s = time_s;
    if (_left_s > 0.0) return;
    _place = place;
    look();
}

void ContactPaint::advance(double dt_s)
{
    if (!_mesh || !(_left_s > 0.0)) return;
    const double share = std::min(dt_s / _left_s, 1.0);
    _place += share * (_target - _place);
    _left_s -= std::min(dt_s, _left_s);
    look();
}

void ContactPaint::look()
{
    const NearestSpot spot = _mesh->nearest({_place, _place, 0.0}, kRange_m);
    if (spot.triangle < 0) return; // it keeps what it had
    const haptics::TriangleMesh& mesh = _mesh->mesh();
    const Eigen::Vector3i corners = mesh.triangles.col(spot.triangle);
    Eigen::Matrix3d triangle;
    triangle << mesh.vertices.col(corners[0]), mesh.vertices.col(corners[1]),
        mesh.vertices.col(corners[2]);
    const double intensity =
        haptics::intensityAt(mesh, spot.triangle, barycentricOf(spot.onSurface, triangle));
    _intensity = intensity >= 0.0 ? std::min(intensity, 1.0) : 0.0; // what isn't a number is silent
}

} // namespace midair::bridge
