#include "engine-bridge/c/inside/ObjectProperties.h"

#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/materials/MaterialLibrary.h"
#include "haptics/base/Limits.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/NearestWord.h"
#include "haptics/base/text/Quantity.h"

#include <vector>

namespace midair::base
{

template struct Setting<capi::ObjectProperties>;
template bool isSame(const Member<capi::ObjectProperties>&,
                     const capi::ObjectProperties&,
                     const capi::ObjectProperties&);

} // namespace midair::base

namespace midair::capi
{

namespace
{

using namespace base;

using P = ObjectProperties;

/// Parses "2", "50 %", "2 relative", "500 Pa", "1.2kPa". Without a unit it stays the one that was
/// set.
bool setPressure(P& property, const std::string& text)
{
    double value = 0.0;
    std::string unit;
    if (!splitQuantity(text, value, unit)) return false;
    const bool isPascal = isUnitFor(unit, "Pa");
    if (isPascal)
        parseQuantity(text, "Pa", value);
    else if (unit == "%")
        parseQuantity(text, "", value);
    else if (!unit.empty() && unit != "relative")
        return false;
    property.pressure = value;
    if (!unit.empty()) property.unit = isPascal ? P::PASCAL : P::RELATIVE;
    return true;
}

template<typename E>
int number(E value)
{
    return static_cast<int>(value);
}

std::vector<Setting<P>> strength()
{
    using bridge::Side;
    using haptics::Sampling;
    return {
        Row<P>("enabled", &P::enabled, "false: the object is not felt").safety(),
        Row<P>("pressure",
               &P::pressure,
               "relative to the scene's other objects (the array plays as loud as the field stays "
               "accurate), or peak pressure with its unit: 500 Pa")
            .range(1e-6, 1e5)
            .parsedBy(setPressure)
            .safety(),
        Row<P>("unit", EnumMember<&P::unit>::choice(), "unit of the pressure")
            .words({{"relative", "RELATIVE", P::RELATIVE}, {"Pa", "PASCAL", P::PASCAL}})
            .stored("PressureUnit")
            .safety(),
        Row<P>("spacing", &P::spacing, "distance between control points; 0: one wavelength")
            .range(0.001, 1.0, "m")
            .orZero(),
        Row<P>(
            "sampling",
            EnumMember<&P::sampling>::choice(),
            "where control points are placed: on the faces, along edges, or at the mesh's vertices")
            .words({{"surface", "SURFACE", number(Sampling::SURFACE)},
                    {"edges", "EDGES", number(Sampling::EDGES)},
                    {"vertices", "VERTICES", number(Sampling::VERTICES)}}),
        Row<P>("side",
               EnumMember<&P::side>::choice(),
               "side of the faces that is felt; front: towards where most of the array's sound "
               "comes from")
            .words({{"both", "BOTH", number(Side::BOTH)},
                    {"front", "FRONT", number(Side::FRONT)},
                    {"back", "BACK", number(Side::BACK)}}),
        Row<P>("priority",
               &P::priority,
               "objects with a larger one keep their points where points are too near or too many")
            .range(-1000000, 1000000),
        Row<P>("modulationFrequency",
               &P::modulationFrequency,
               "modulation of the pressure on the skin; 0: steady; all objects of a scene share "
               "the frequency of the highest priority")
            .range(0.0, kMostModulation_Hz, "Hz"),
        Row<P>(
            "modulationDepth", &P::modulationDepth, "share of the pressure that modulation removes")
            .range(0.0, 1.0),
        Row<P>(
            "touchEvents", &P::touchEvents, "report hands that begin and end to touch the object")};
}

/// A factor that replaces the material's where it isn't 0.
Setting<P> inPlace(const char* name,
                   double P::*member,
                   const char* help,
                   double low,
                   double high,
                   const char* unit = "")
{
    return Row<P>(name, member, std::string(help) + "; 0: the material's", 7)
        .range(low, high, unit)
        .orZero();
}

std::vector<Setting<P>> contact()
{
    using bridge::Render;
    std::vector<Setting<P>> rows = {
        Row<P>("render",
               EnumMember<&P::render>::choice(),
               "what is played of the object: as the scene says, the whole, foci on the skin "
               "where hands touch it, or auto",
               7)
            .words({{"inherit", "INHERIT", number(Render::INHERIT)},
                    {"object", "OBJECT", number(Render::OBJECT)},
                    {"contact", "CONTACT", number(Render::CONTACT)},
                    {"auto", "AUTO", number(Render::AUTO)}}),
        Row<P>("material",
               &P::material,
               "how it feels where it is touched: skin, rubber, glass, sandpaper, cloth, or a "
               "name from the file that OSG_MIDAIR_MATERIALS names",
               7),
        inPlace("stiffness", &P::stiffness, "applied force over depth", 0.1, 1e4, "N/m"),
        inPlace("contactForce", &P::contactForce, "where the force stops growing", 1e-4, 1.0, "N"),
        inPlace(
            "softness", &P::softness, "growth of the circle's radius over the depth", 0.001, 10.0),
        inPlace("roughness",
                &P::roughness,
                "share of the pressure that the texture takes away",
                0.001,
                1.0),
        inPlace("texturePeriod", &P::texturePeriod, "wavelength of the texture", 1e-5, 1.0, "m"),
        inPlace("lowVibration",
                &P::lowVibration,
                "share that a vibration of 30 Hz takes away",
                0.001,
                1.0),
        inPlace("highVibration",
                &P::highVibration,
                "share that a vibration of 150 Hz takes away",
                0.001,
                1.0)};
    rows[3].isSafety = true; // contactForce
    return rows;
}

/// Read once, when the first object names one.
const bridge::MaterialLibrary& materials()
{
    static const bridge::MaterialLibrary library = bridge::MaterialLibrary::ofUser();
    return library;
}

bridge::HapticMaterial materialOf(const P& property)
{
    bridge::HapticMaterial material;
    if (!property.material.empty())
    {
        const bridge::HapticMaterial* named = materials().find(property.material);
        if (!named)
            fail(MIDAIR_UNKNOWN,
                 "material \"" + property.material + "\" is unknown" +
                     didYouMean(property.material, materials().names()));
        material = *named;
    }
    const auto replace = [](double own, double& value)
    {
        if (own != 0.0) value = own;
    };
    replace(property.stiffness, material.stiffness_N_m);
    replace(property.contactForce, material.mostForce_N);
    replace(property.softness, material.radiusGrowth);
    replace(property.roughness, material.roughness);
    replace(property.texturePeriod, material.texturePeriod_m);
    replace(property.lowVibration, material.lowVibration);
    replace(property.highVibration, material.highVibration);
    constexpr double kLeastRadius_m = 1e-3; // that grows
    if (property.softness > 0.0 && !(material.radius_m > 0.0)) material.radius_m = kLeastRadius_m;
    std::string problem;
    if (!material.isValid(&problem)) fail(MIDAIR_INVALID, problem);
    return material;
}

} // namespace

const SettingTable<ObjectProperties>& objectTable()
{
    static const SettingTable<P> table(joined<P>({strength(), contact()}));
    return table;
}

bridge::HapticProperties forPipeline(const ObjectProperties& property)
{
    bridge::HapticProperties p;
    p.pressure = property.pressure;
    p.pressureInPa = property.unit == P::PASCAL;
    p.spacing_m = property.spacing;
    p.sampling = property.sampling;
    p.side = property.side;
    p.priority = property.priority;
    p.modulationFrequency_Hz = property.modulationFrequency;
    p.modulationDepth = property.modulationDepth;
    p.render = property.render;
    p.material = materialOf(property);
    return p;
}

} // namespace midair::capi
