#pragma once

#include "engine-bridge/hands/MeshDistance.h"
#include "haptics/array/Medium.h"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace midair::bridge
{

/// Options for a contact's pressure; isValid() names the first setting that is out of its range.
///
/// The defaults describe a finger pad on an object that feels soft: 20 mN at 2 mm depth, which
/// slowly turning foci make feel like 0.24 N (Morisaki et al., arXiv 2301.11572).
struct ContactForceOptions
{
    double stiffness_N_m = 10.0; ///< 0 .. 1e4; applied force over depth
    double mostForce_N = 0.02;   ///< 0 .. 1; where the force stops growing
    /// 1e-6 .. 1e-3; area that a focus presses on: 4.3 x 9.2 mm at half pressure, of the octagon
    double focusArea_m2 = 22e-6;
    double alpha = 2.0;   ///< 1 .. 2; reflection by skin; 2: total
    double ramp_s = 0.02; ///< 0 .. 1; a contact's pressure grows over this time, to avoid a click

    bool isValid(std::string* error = nullptr) const;
};

/// Converts depth to pressure: F = stiffness depth, clamped and shared among the foci; the peak
/// pressure of each is sqrt(2 rho c^2 F / (alpha A)), because radiation pressure is alpha p^2 / (2
/// rho c^2) (Inoue, Makino, Shinoda 2015, equation 1).
class ContactForce
{
public:
    /// Throws InputError for options or a medium that are not valid.
    explicit ContactForce(const ContactForceOptions& options = {},
                          const haptics::Medium& medium = {});

    /// N; 0 for depths that aren't above 0 or not finite.
    double force_N(double depth_m) const;
    /// Pa, peak; of each of \a foci (>= 1) foci \a age_s after the contact began. For fading foci
    /// pass the sum of their squared weights, which keeps the force. 0 for numbers that aren't
    /// finite.
    double pressure_Pa(double depth_m, double foci, double age_s) const;

    const ContactForceOptions& options() const { return _options; }

private:
    ContactForceOptions _options;
    double _rhoCC_Pa = 0.0; ///< rho c^2
};

/// Painted intensity at a contact: a factor on the pressure, as for control points. A finger that
/// moves over an image of heights feels it at its own speed.
///
/// Between two frames of hands the place moves in a straight line to the newest one, so that it has
/// no steps at the frame rate; it lags by one frame.
class ContactPaint
{
public:
    /// The contact is at \a place (m, mesh frame) of \a mesh, which may be null, at \a time_s. The
    /// first time, or on other triangles, it moves there at once.
    void
    follow(std::shared_ptr<const MeshDistance> mesh, const Eigen::Vector3d& place, double time_s);
    void advance(double dt_s); ///< finite, >= 0

    double intensity() const { return _intensity; } ///< 0 .. 1; 1 where nothing is painted

private:
    void look();

    std::shared_ptr<const MeshDistance> _mesh; ///< null: no paint
    Eigen::Vector3d _place = Eigen::Vector3d::Zero();
    Eigen::Vector3d _target = Eigen::Vector3d::Zero();
    double _left_s = 0.0; ///< until it is there
    double _time_s = 0.0; ///< of the last follow()
    double _intensity = 1.0;
};

/// Vibrations of a contact's steady pressure; isValid() names the first setting that is out of its
/// range. Depths are shares of the radiation pressure; their sum is at most 1. Pressure alone feels
/// smooth; with vibrations at 30 and 150 Hz at least six textures can be distinguished (Morisaki,
/// Matsubayashi, Makino, Shinoda, arXiv 2601.16767).
struct ContactVibrationOptions
{
    double lowDepth = 0.0;         ///< 0 .. 1
    double low_Hz = 30.0;          ///< 1 .. 500
    double highDepth = 0.0;        ///< 0 .. 1
    double high_Hz = 150.0;        ///< 1 .. 500
    double textureDepth = 0.0;     ///< 0 .. 1; how rough the texture is
    double texturePeriod_m = 1e-3; ///< 1e-5 .. 1; its wavelength, lambda_s

    bool isValid(std::string* error = nullptr) const;
};

/// Pressure over time of one contact, P(t) = P_c [1 - sum m (1 - cos theta)/2].
///
/// Phases integrate, d theta/dt = 2 pi f, for the texture with f = v_t/lambda_s, so that changes of
/// speed cause no jumps. The texture's depth is proportional to the speed below 10 mm/s, so that
/// nothing vibrates at rest, and falls to 0 from 400 to 500 Hz, above which skin feels nothing.
class ContactVibration
{
public:
    /// Throws InputError for options that are not valid.
    explicit ContactVibration(const ContactVibrationOptions& options = {});

    /// Changes the options; phases continue. Throws like the constructor.
    void setOptions(const ContactVibrationOptions& options);

    /// Advances by \a dt_s at the tangential speed \a speed_m_s (its sign doesn't matter). Returns
    /// false and changes nothing if one isn't finite or dt_s is below 0.
    bool advance(double dt_s, double speed_m_s);

    double share() const;  ///< 0 .. 1; factor on the radiation pressure
    double factor() const; ///< 0 .. 1; factor on the sound pressure: sqrt(share())
    double texture_Hz() const { return _texture_Hz; }
    double texturePhase_rad() const { return _texture_rad; } ///< 0 .. 2 pi

private:
    ContactVibrationOptions _options;
    double _low_rad = 0.0;
    double _high_rad = 0.0;
    double _texture_rad = 0.0;
    double _texture_Hz = 0.0;
    double _textureDepth = 0.0; ///< at the last speed
};

} // namespace midair::bridge
