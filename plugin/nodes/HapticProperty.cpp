#include "plugin/settings/Assignments.h"
#include "plugin/settings/OptionTable.h"

#include <osgMidair/HapticProperty>

namespace osgMidair
{

namespace
{

/// "2", "2 relative", "500 Pa", "1.2kPa".
bool setPressure(HapticProperty& property, const std::string& text)
{
    const std::size_t end = text.find_first_not_of("+-.0123456789eE");
    double value = 0.0;
    if (!midair::base::parseNumber(text.substr(0, end), value)) return false;
    std::string unit = end == std::string::npos ? std::string() : text.substr(end);
    unit.erase(0, unit.find_first_not_of(" \t"));
    unit.erase(unit.find_last_not_of(" \t") + 1);
    if (unit != "" && unit != "relative" && unit != "Pa" && unit != "kPa") return false;
    property.pressure = unit == "kPa" ? value * 1e3 : value;
    property.pressureUnit =
        unit == "Pa" || unit == "kPa" ? HapticProperty::PASCAL : HapticProperty::RELATIVE;
    return true;
}

OptionTable<HapticProperty> makeTable()
{
    using P = HapticProperty;
    OptionTable<P> table;
    table.flag("enabled", &P::enabled, "true or false; can it be felt (default true)");
    table.number("pressure",
                 &P::pressure,
                 1e-6,
                 1e5,
                 "how strong: relative to the scene's other objects (default 1), or \"500 Pa\"");
    table.choice("unit",
                 &P::pressureUnit,
                 {{"relative", P::RELATIVE}, {"Pa", P::PASCAL}},
                 "of the pressure: relative (default) or Pa");
    table.numberOrZero("spacing",
                       &P::spacing,
                       0.001,
                       1.0,
                       "m between control points, 0.001 .. 1; 0: one wavelength (default)");
    table.choice("sampling",
                 &P::sampling,
                 {{"surface", P::SURFACE}, {"edges", P::EDGES}, {"vertices", P::VERTICES}},
                 "where points go: surface (default), edges or vertices");
    table.choice("side",
                 &P::side,
                 {{"both", P::BOTH}, {"front", P::FRONT}, {"back", P::BACK}},
                 "which side of its faces: both (default), front or back");
    table.number("priority",
                 &P::priority,
                 -1000000,
                 1000000,
                 "larger wins where points are too near or too many (default 0)");
    table.number("modulationFrequency",
                 &P::modulationFrequency,
                 0.0,
                 500.0,
                 "Hz, 0 .. 500; 0: steady (default)");
    table.number("modulationDepth",
                 &P::modulationDepth,
                 0.0,
                 1.0,
                 "0 .. 1; by how much of itself the pressure on the skin goes down (default 1)");
    table.choice(
        "intensity",
        &P::intensity,
        {{"uniform", P::UNIFORM}, {"vertex-color", P::VERTEX_COLOR}, {"texture", P::TEXTURE}},
        "painted haptics, times the pressure: uniform (default), vertex-color or texture");
    table.choice("intensityChannel",
                 &P::intensityChannel,
                 {{"brightness", P::BRIGHTNESS},
                  {"red", P::RED},
                  {"green", P::GREEN},
                  {"blue", P::BLUE},
                  {"alpha", P::ALPHA}},
                 "of the paint: brightness (default), red, green, blue or alpha");
    table.number("intensityLow",
                 &P::intensityLow,
                 0.0,
                 1.0,
                 "0 .. 1; intensity where the channel is 0 (default 0: not felt)");
    table.number("intensityHigh",
                 &P::intensityHigh,
                 0.0,
                 1.0,
                 "0 .. 1; intensity where the channel is full (default 1)");
    table.flag("touchEvents", &P::touchEvents, "true or false; report hands (default false)");
    return table;
}

const OptionTable<HapticProperty>& properties()
{
    static const OptionTable<HapticProperty> table = makeTable();
    return table;
}

} // namespace

bool HapticProperty::set(const std::string& name, const std::string& value, std::string& error)
{
    if (name == "pressure" && setPressure(*this, value)) return true;
    return properties().set(*this, name, value, error);
}

void HapticProperty::parse(const std::string& text, std::vector<std::string>& errors)
{
    // "a=1; b=2" or "a=1 b=2"; a value with a unit ("500 Pa") needs the semicolon, a comma or the end after it.
    forEachAssignment(text,
                      [this, &errors](const std::string& name, const std::string& value)
                      {
                          std::string error;
                          if (!set(name.empty() ? "enabled" : name, value, error))
                              errors.push_back(error);
                      });
}

std::vector<std::string> HapticProperty::repair()
{
    return properties().repair(*this);
}

std::vector<std::pair<std::string, std::string>> HapticProperty::describe()
{
    return properties().describe();
}

bool operator==(const HapticProperty& a, const HapticProperty& b)
{
    return a.enabled == b.enabled && same(a.pressure, b.pressure) &&
           a.pressureUnit == b.pressureUnit && same(a.spacing, b.spacing) &&
           a.sampling == b.sampling && a.side == b.side && a.priority == b.priority &&
           same(a.modulationFrequency, b.modulationFrequency) &&
           same(a.modulationDepth, b.modulationDepth) && a.intensity == b.intensity &&
           a.intensityChannel == b.intensityChannel && same(a.intensityLow, b.intensityLow) &&
           same(a.intensityHigh, b.intensityHigh) && a.touchEvents == b.touchEvents;
}

} // namespace osgMidair
