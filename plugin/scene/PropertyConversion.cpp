#include "plugin/scene/PropertyConversion.h"

#include "engine-bridge/player/SceneOptions.h"

namespace osgMidair
{

using midair::bridge::PaintOptions;

namespace
{

constexpr const char* kUntouched = "; it isn't felt where it is touched";

} // namespace

std::string problemOfMaterial(const HapticProperty& property)
{
    std::string problem = midair::bridge::materialOf(property).problem;
    if (!problem.empty()) problem += kUntouched;
    if (property.material.empty()) return problem;
    for (const std::string& file : midair::bridge::materials().problems())
        problem += (problem.empty() ? "" : "; ") + file;
    return problem;
}

midair::bridge::HapticProperties forBridge(const HapticProperty& property)
{
    const midair::bridge::ObjectMaterial made = midair::bridge::materialOf(property);
    if (made.problem.empty()) return propertiesOf(property, made.material);
    midair::bridge::HapticMaterial silent;
    silent.mostForce_N = 0.0;
    return propertiesOf(property, silent);
}

PaintOptions paintOf(const HapticProperty& property)
{
    PaintOptions paint;
    paint.source = property.intensity == HapticProperty::VERTEX_COLOR ? PaintOptions::VERTEX_COLORS
                   : property.intensity == HapticProperty::TEXTURE    ? PaintOptions::TEXTURE
                                                                      : PaintOptions::NONE;
    switch (property.intensityChannel)
    {
    case HapticProperty::RED:
        paint.channel = PaintOptions::RED;
        break;
    case HapticProperty::GREEN:
        paint.channel = PaintOptions::GREEN;
        break;
    case HapticProperty::BLUE:
        paint.channel = PaintOptions::BLUE;
        break;
    case HapticProperty::ALPHA:
        paint.channel = PaintOptions::ALPHA;
        break;
    default:
        break;
    }
    paint.low = property.intensityLow;
    paint.high = property.intensityHigh;
    return paint;
}

} // namespace osgMidair
