#include "engine-bridge/contact/ContactVibration.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kFullSpeed_m_s = 0.01; ///< the texture is whole from here on
constexpr double kFading_Hz = 400.0;    ///< where it begins to fade
constexpr double kFaded_Hz = 500.0;     ///< where nothing is left of it

double onBy(double phase_rad, double turns)
{
    return std::fmod(phase_rad + base::kTwoPi * turns, base::kTwoPi);
}

double dip(double depth, double phase_rad)
{
    return depth * 0.5 * (1.0 - std::cos(phase_rad));
}

} // namespace

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
