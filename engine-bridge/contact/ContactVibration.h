#pragma once

#include <string>

namespace midair::bridge
{

/// What is mixed into a contact's steady pressure; isValid() names the first setting that is out of
/// its range. Depths are shares of the radiation pressure; together they are at most 1. Pressure
/// alone feels smooth; with vibrations at 30 and 150 Hz at least six textures can be told apart
/// (Morisaki, Matsubayashi, Makino, Shinoda, arXiv 2601.16767).
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

/// The course of the pressure of one contact, P(t) = P_c [1 - sum m (1 - cos theta)/2].
///
/// Phases integrate, d theta/dt = 2 pi f, for the texture with f = v_t/lambda_s, so that changes of
/// speed make no jumps. The texture's depth is proportional to the speed below 10 mm/s, so that
/// nothing vibrates at rest, and falls to 0 from 400 to 500 Hz, above which skin feels nothing.
class ContactVibration
{
public:
    /// Throws InputError for options that are not valid.
    explicit ContactVibration(const ContactVibrationOptions& options = {});

    /// Takes other options; phases go on. Throws as the constructor does.
    void setOptions(const ContactVibrationOptions& options);

    /// Goes on by \a dt_s at a tangential speed of \a speed_m_s (its sign doesn't matter). Returns
    /// false, and changes nothing, if one isn't finite or dt_s is under 0.
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
