#include "engine-bridge/contact/ContactForce.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
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

/// Barycentric coordinates of \a x in the triangle \a t, clamped to it; its first corner if it has
/// no area.
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

constexpr double kFullSpeed_m_s = 0.01; ///< full texture from this speed on
constexpr double kFading_Hz = 400.0;    ///< fading starts
constexpr double kFaded_Hz = 500.0;     ///< fading ends

double onBy(double phase_rad, double turns)
{
    return std::fmod(phase_rad + base::kTwoPi * turns, base::kTwoPi);
}

double dip(double depth, double phase_rad)
{
    return depth * 0.5 * (1.0 - std::cos(phase_rad));
}

} // namespace

bool ContactForceOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactForceOptions: ")
        .within("stiffness_N_m", stiffness_N_m, 0.0, 1e4)
        .within("mostForce_N", mostForce_N, 0.0, 1.0)
        .within("focusArea_m2", focusArea_m2, 1e-6, 1e-3)
        .within("alpha", alpha, 1.0, 2.0)
        .within("ramp_s", ramp_s, 0.0, 1.0)
        .passed(error);
}

ContactForce::ContactForce(const ContactForceOptions& options, const haptics::Medium& medium) :
    _options(options)
{
    std::string error;
    if (!options.isValid(&error) || !medium.isValid(&error)) throw base::InputError(error);
    _rhoCC_Pa = medium.density() * medium.soundSpeed() * medium.soundSpeed();
}

double ContactForce::force_N(double depth_m) const
{
    if (!(depth_m > 0.0) || !std::isfinite(depth_m)) return 0.0;
    return std::min(_options.stiffness_N_m * depth_m, _options.mostForce_N);
}

// The ramp applies to the pressure's amplitude, s^2 (3 - 2 s), so that it starts and ends smoothly.
double ContactForce::pressure_Pa(double depth_m, double foci, double age_s) const
{
    if (!(foci >= 1.0) || !std::isfinite(foci) || !(age_s >= 0.0)) return 0.0;
    const double s = _options.ramp_s > 0.0 ? std::min(age_s / _options.ramp_s, 1.0) : 1.0;
    const double whole = std::sqrt(2.0 * _rhoCC_Pa * force_N(depth_m) / foci /
                                   (_options.alpha * _options.focusArea_m2));
    return s * s * (3.0 - 2.0 * s) * whole;
}

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
    if (spot.triangle < 0) return; // it keeps the last value
    const haptics::TriangleMesh& mesh = _mesh->mesh();
    const Eigen::Vector3i corners = mesh.triangles.col(spot.triangle);
    Eigen::Matrix3d triangle;
    triangle << mesh.vertices.col(corners[0]), mesh.vertices.col(corners[1]),
        mesh.vertices.col(corners[2]);
    const double intensity =
        haptics::intensityAt(mesh, spot.triangle, barycentricOf(spot.onSurface, triangle));
    _intensity = intensity >= 0.0 ? std::min(intensity, 1.0) : 0.0; // NaN is silent
}

bool ContactVibrationOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactVibrationOptions: ")
        .within("lowDepth", lowDepth, 0.0, 1.0)
        .within("low_Hz", low_Hz, 1.0, 500.0)
        .within("highDepth", highDepth, 0.0, 1.0)
        .within("high_Hz", high_Hz, 1.0, 500.0)
        .within("textureDepth", textureDepth, 0.0, 1.0)
        .within("texturePeriod_m", texturePeriod_m, 1e-5, 1.0)
        .require(lowDepth + highDepth + textureDepth <= 1.0 + 1e-9,
                 "lowDepth, highDepth and textureDepth together must be at most 1")
        .passed(error);
}

ContactVibration::ContactVibration(const ContactVibrationOptions& options)
{
    setOptions(options);
}

void ContactVibration::setOptions(const ContactVibrationOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    _options = options;
}

bool ContactVibration::advance(double dt_s, double speed_m_s)
{
    if (!(dt_s >= 0.0) || !std::isfinite(dt_s) || !std::isfinite(speed_m_s)) return false;
    const double speed = std::abs(speed_m_s);
    _texture_Hz = speed / _options.texturePeriod_m;
    _textureDepth = _options.textureDepth * std::min(speed / kFullSpeed_m_s, 1.0) *
                    std::clamp((kFaded_Hz - _texture_Hz) / (kFaded_Hz - kFading_Hz), 0.0, 1.0);
    _low_rad = onBy(_low_rad, _options.low_Hz * dt_s);
    _high_rad = onBy(_high_rad, _options.high_Hz * dt_s);
    _texture_rad = onBy(_texture_rad, _texture_Hz * dt_s);
    return true;
}

double ContactVibration::share() const
{
    return std::max(1.0 - dip(_options.lowDepth, _low_rad) - dip(_options.highDepth, _high_rad) -
                        dip(_textureDepth, _texture_rad),
                    0.0);
}

double ContactVibration::factor() const
{
    return std::sqrt(share());
}

} // namespace midair::bridge
