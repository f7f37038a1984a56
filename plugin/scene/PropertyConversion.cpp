#include "plugin/scene/PropertyConversion.h"

#include "engine-bridge/materials/MaterialLibrary.h"
#include "engine-bridge/player/SceneOptions.h"
#include "haptics/base/text/NearestWord.h"

namespace osgMidair
{

using midair::bridge::PaintOptions;

namespace
{

using midair::bridge::HapticMaterial;
using midair::bridge::MaterialLibrary;

/// Read once, when the first object names one.
const MaterialLibrary& materials()
{
    static const MaterialLibrary library = MaterialLibrary::ofUser();
    return library;
}

/// Returns false for an unknown name.
bool readMaterial(const HapticProperty& property, HapticMaterial& material)
{
    if (!property.material.empty())
    {
        const HapticMaterial* named = materials().find(property.material);
        if (!named) return false;
        material = *named;
    }
    midair::bridge::replaceNumbers(material, property);
    return true;
}

constexpr const char* kUntouched = "; it isn't felt where it is touched";

} // namespace

std::string problemOfMaterial(const HapticProperty& property)
{
    HapticMaterial material;
    std::string problem;
    if (!readMaterial(property, material))
        problem = "material \"" + property.material + "\" is unknown" +
                  midair::base::didYouMean(property.material, materials().names()) + kUntouched;
    else if (!material.isValid(&problem))
        problem += kUntouched;
    if (property.material.empty()) return problem;
    for (const std::string& file : materials().problems())
        problem += (problem.empty() ? "" : "; ") + file;
    return problem;
}

midair::bridge::HapticProperties forBridge(const HapticProperty& property)
{
    midair::bridge::HapticProperties p;
    p.pressure = property.pressure;
    p.pressureInPa = property.pressureUnit == HapticProperty::PASCAL;
    p.spacing_m = property.spacing;
    p.sampling = property.sampling == HapticProperty::EDGES ? midair::haptics::Sampling::EDGES
                 : property.sampling == HapticProperty::VERTICES
                     ? midair::haptics::Sampling::VERTICES
                     : midair::haptics::Sampling::SURFACE;
    p.side = property.side == HapticProperty::FRONT  ? midair::bridge::Side::FRONT
             : property.side == HapticProperty::BACK ? midair::bridge::Side::BACK
                                                     : midair::bridge::Side::BOTH;
    p.priority = property.priority;
    p.modulationFrequency_Hz = property.modulationFrequency;
    p.modulationDepth = property.modulationDepth;
    p.render = property.render == HapticProperty::INHERIT
                   ? midair::bridge::Render::INHERIT
                   : midair::bridge::renderOf(static_cast<HapticSettings::Render>(property.render));
    if (!readMaterial(property, p.material) || !p.material.isValid())
    {
        p.material = {};
        p.material.mostForce_N = 0.0;
    }
    return p;
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
