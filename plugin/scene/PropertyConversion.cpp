#include "plugin/scene/PropertyConversion.h"

namespace osgMidair
{

using midair::bridge::PaintOptions;

midair::bridge::Render renderOf(HapticSettings::Render render)
{
    return render == HapticSettings::CONTACT ? midair::bridge::Render::CONTACT
           : render == HapticSettings::AUTO  ? midair::bridge::Render::AUTO
                                             : midair::bridge::Render::OBJECT;
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
                   : renderOf(static_cast<HapticSettings::Render>(property.render));
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
