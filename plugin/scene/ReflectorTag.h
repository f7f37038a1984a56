#pragma once

#include <string>
#include <vector>

namespace osgMidair
{

/// The tag "reflector" of a node: how its flat faces reflect sound.
struct ReflectorTag
{
    bool enabled = true;
    double reflection = 1.0;      ///< 0 .. 1; amplitude of the reflected wave over the incident
    double reflectionPhase = 0.0; ///< -1000 .. 1000 rad; added to the phase of the reflected wave
    /// 1e-6 .. 1000 mm; rms error of its place along its normal. By default so large that fields
    /// are not corrected: a correction for a wrong place is worse than none.
    double accuracy = 10.0;

    /// Reads "true; reflection=0.8; accuracy=0.2 mm". What isn't understood, or is out of range, is
    /// described in \a errors; the reflector then has the defaults, the strongest that isn't
    /// corrected for.
    static ReflectorTag parse(const std::string& text, std::vector<std::string>& errors);

    /// Names of the properties.
    static std::vector<std::string> names();
};

} // namespace osgMidair
