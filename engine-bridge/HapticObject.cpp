#include "engine-bridge/HapticObject.h"

#include "haptics/base/text/Range.h"

#include <algorithm>
#include <iterator>
#include <tuple>

namespace midair::bridge
{

bool HapticMaterial::isValid(std::string* error) const
{
    return base::RangeCheck("material: ")
        .within("stiffness", stiffness_N_m, 0.0, 1e4, " N/m")
        .within("force", mostForce_N, 0.0, 1.0, " N")
        .check(radius_m == 0.0 || (radius_m >= 1e-3 && radius_m <= 0.02),
               "radius",
               radius_m,
               "0 or within 0.001 .. 0.02 m")
        .within("radiusGrowth", radiusGrowth, 0.0, 10.0)
        .within("rateGrowth", rateGrowth_Hz_m, 0.0, 1e4, " Hz/m")
        .within("roughness", roughness, 0.0, 1.0)
        .within("texturePeriod", texturePeriod_m, 1e-5, 1.0, " m")
        .within("lowVibration", lowVibration, 0.0, 1.0)
        .within("lowFrequency", low_Hz, 1.0, 500.0, " Hz")
        .within("highVibration", highVibration, 0.0, 1.0)
        .within("highFrequency", high_Hz, 1.0, 500.0, " Hz")
        .require(roughness + lowVibration + highVibration <= 1.0 + 1e-9,
                 "roughness, lowVibration and highVibration together must be at most 1")
        .passed(error);
}

bool operator==(const HapticMaterial& a, const HapticMaterial& b)
{
    const auto all = [](const HapticMaterial& m)
    {
        return std::tie(m.stiffness_N_m,
                        m.mostForce_N,
                        m.radius_m,
                        m.radiusGrowth,
                        m.rateGrowth_Hz_m,
                        m.roughness,
                        m.texturePeriod_m,
                        m.lowVibration,
                        m.low_Hz,
                        m.highVibration,
                        m.high_Hz);
    };
    return all(a) == all(b);
}

bool SensationProperties::needsHands() const
{
    return isMeant && (attach == Attach::HAND || trigger == Trigger::TOUCH_BEGIN ||
                       trigger == Trigger::TOUCH_STAY || trigger == Trigger::TOUCH_END);
}

bool SensationProperties::usesHands() const
{
    if (!isMeant || !pattern) return false;
    const auto isKnown = [this](const char* name)
    { return pattern->parameterIndex(name) < pattern->parameters.size(); };
    return needsHands() || attach == Attach::SURFACE ||
           std::any_of(std::begin(kHandParameters), std::end(kHandParameters), isKnown);
}

bool operator==(const SensationProperties& a, const SensationProperties& b)
{
    const auto all = [](const SensationProperties& s)
    {
        return std::tie(s.isMeant,
                        s.pattern,
                        s.attach,
                        s.joint,
                        s.trigger,
                        s.speed,
                        s.seed,
                        s.parameters,
                        s.plays);
    };
    return all(a) == all(b);
}

bool operator==(const HapticProperties& a, const HapticProperties& b)
{
    return a.pressure == b.pressure && a.pressureInPa == b.pressureInPa &&
           a.spacing_m == b.spacing_m && a.sampling == b.sampling && a.side == b.side &&
           a.priority == b.priority && a.modulationFrequency_Hz == b.modulationFrequency_Hz &&
           a.modulationDepth == b.modulationDepth && a.render == b.render &&
           a.material == b.material && a.sensation == b.sensation;
}

bool followsHands(const HapticProperties& properties, Render ofScene)
{
    if (properties.sensation.isMeant) return properties.sensation.usesHands();
    const Render own = properties.render;
    return (own == Render::INHERIT ? ofScene : own) != Render::OBJECT;
}

bool isClipped(const std::vector<Eigen::Vector4d>& clips, const Eigen::Vector3d& place)
{
    return std::any_of(clips.begin(),
                       clips.end(),
                       [&place](const Eigen::Vector4d& plane)
                       { return plane.head<3>().dot(place) + plane[3] < 0.0; });
}

} // namespace midair::bridge
