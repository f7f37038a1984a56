#include "haptics/sensation/ClassicMaker.h"

#include <cassert>

namespace midair::haptics
{

ClassicMaker::ClassicMaker(const std::string& name, const std::vector<ClassicParameter>& parameters)
{
    sensation.name = name;
    for (const ClassicParameter& one : parameters)
        sensation.parameters.push_back({one.name, one.standard, one.low, one.high, true});
    sensation.intensityFactor = (*this)["intensity"];
}

void ClassicMaker::setStandard(const std::string& name, double value)
{
    sensation.parameters[sensation.parameterIndex(name)].standard = value;
}

SensationNumber ClassicMaker::operator[](const std::string& name) const
{
    const std::size_t index = sensation.parameterIndex(name);
    assert(index < sensation.parameters.size());
    return SensationNumber::parameter(index);
}

SensationBrush ClassicMaker::circle(const SensationNumber& radius_mm,
                                    const SensationNumber& draw_Hz)
{
    SensationBrush brush;
    brush.x_mm = radius_mm;
    brush.draw_Hz = draw_Hz;
    return brush;
}

SensationBrush ClassicMaker::line(const SensationNumber& length_mm,
                                  const SensationNumber& rotation_deg,
                                  const SensationNumber& draw_Hz)
{
    SensationBrush brush;
    brush.kind = SensationBrush::Kind::LINE;
    brush.x_mm = length_mm * 0.5;
    brush.rotation = rotation_deg;
    brush.draw_Hz = draw_Hz;
    return brush;
}

SensationKeyframe&
ClassicMaker::place(double time_ms, const SensationBrush& brush, const Eigen::Vector3d& position_mm)
{
    SensationKeyframe& frame = pause(time_ms, brush);
    frame.kind = SensationKeyframe::Kind::STANDARD;
    frame.position_mm = position_mm;
    return frame;
}

SensationKeyframe& ClassicMaker::pause(double time_ms, const SensationBrush& brush)
{
    SensationKeyframe frame;
    frame.kind = SensationKeyframe::Kind::PAUSE;
    frame.time_ms = time_ms;
    frame.brush = brush;
    setIntensity(frame, 1.0);
    sensation.keyframes.push_back(frame);
    return sensation.keyframes.back();
}

void ClassicMaker::setIntensity(SensationKeyframe& frame,
                                double value,
                                SensationTransition transition)
{
    SensationIntensity intensity;
    intensity.low = value;
    frame.intensity = intensity;
    frame.intensityTransition = transition;
}

void ClassicMaker::jumpIf(const std::string& parameter, double least)
{
    SensationJump jump;
    jump.parameter = sensation.parameterIndex(parameter);
    jump.comparison = SensationJump::Comparison::GREATER_OR_EQUAL;
    jump.value = least;
    sensation.keyframes.back().jumps.push_back(jump);
}

void ClassicMaker::loop()
{
    jumpIf("intensity", 0.0); // whose range begins at 0
}

void ClassicMaker::stop()
{
    jumpIf("repeat", 0.5);
    SensationKeyframe end;
    end.kind = SensationKeyframe::Kind::STOP;
    end.time_ms = sensation.keyframes.back().time_ms;
    sensation.keyframes.push_back(end);
}

} // namespace midair::haptics
