#pragma once

#include "haptics/sensation/Sensation.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// A parameter of a classic.
struct ClassicParameter
{
    const char* name;
    const char* unit; ///< "mm", "ms", "Hz", "deg", "" (a ratio) or "yes/no"
    double standard;
    double low;
    double high;
};

/// Makes the pattern of a classic from keyframes whose numbers are its parameters.
class ClassicMaker
{
public:
    ClassicMaker(const std::string& name, const std::vector<ClassicParameter>& parameters);

    /// Sets the default of a parameter, which must be one.
    void setStandard(const std::string& name, double value);

    /// The value of a parameter, which must be one.
    SensationNumber operator[](const std::string& name) const;

    static SensationBrush circle(const SensationNumber& radius_mm, const SensationNumber& draw_Hz);
    static SensationBrush line(const SensationNumber& length_mm,
                               const SensationNumber& rotation_deg,
                               const SensationNumber& draw_Hz);

    /// Adds a keyframe at a place, or a pause. Returns it, to be changed until the next is added.
    SensationKeyframe& place(double time_ms,
                             const SensationBrush& brush,
                             const Eigen::Vector3d& position_mm = Eigen::Vector3d::Zero());
    SensationKeyframe& pause(double time_ms, const SensationBrush& brush);
    static void setIntensity(SensationKeyframe& frame,
                             double value,
                             SensationTransition transition = SensationTransition::LINEAR);
    /// Lets the last keyframe go back to time 0, always.
    void loop();
    /// Lets the last keyframe go back if the parameter "repeat" is 1, and stop otherwise.
    void stop();

    Sensation sensation; ///< with the parameters, without keyframes at first

private:
    void jumpIf(const std::string& parameter, double least);
};

} // namespace midair::haptics
