// The tables of settings. To add one, add its member to HapticSettings or HapticProperty and its
// row here, or its member and its row where FieldSettings are. Rows are stored in this order,
// version by version; .osgb is positional, so a stored row must keep its place and its version.
#include "plugin/settings/AllSettings.h"

#include "haptics/base/Limits.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/sequence/FieldSettings.h"
#include "plugin/settings/Assignments.h"

namespace midair::base
{

template<>
struct ValueText<osg::Matrixd>
{
    static constexpr const char* kExpected = "16 numbers";
    static constexpr const char* kValues = "16 numbers";
    static bool read(const std::string& text, osg::Matrixd& value)
    {
        return osgMidair::parseMatrix(text, value);
    }
    static bool same(const osg::Matrixd& a, const osg::Matrixd& b)
    {
        return std::equal(a.ptr(), a.ptr() + 16, b.ptr(), ValueText<double>::same);
    }
    static std::string write(const osg::Matrixd&) { return "identity"; } // its default
};

template struct OSGMIDAIR_EXPORT Setting<osgMidair::HapticSettings>;
template struct OSGMIDAIR_EXPORT Setting<osgMidair::HapticProperty>;
template OSGMIDAIR_EXPORT bool isSame(const Member<osgMidair::HapticSettings>&,
                                      const osgMidair::HapticSettings&,
                                      const osgMidair::HapticSettings&);
template OSGMIDAIR_EXPORT bool isSame(const Member<osgMidair::HapticProperty>&,
                                      const osgMidair::HapticProperty&,
                                      const osgMidair::HapticProperty&);

} // namespace midair::base

namespace osgMidair
{

namespace
{

using namespace midair::base;

using S = HapticSettings;
using P = HapticProperty;

std::vector<Setting<S>> place()
{
    return {
        Row<S>("enabled", &S::enabled, "false: the array is silent").variable("ENABLED").safety(),
        Row<S>(
            "array", &S::array, "octagon, board, the name of another shipped array, or a JSON file")
            .variable("ARRAY")
            .safety(),
        Row<S>("device",
               &S::device,
               "what plays: the URI of a device (sim:, record:FILE, null:, ..) or a name from the "
               "user's grants")
            .variable("DEVICE")
            .safety(),
        Row<S>("calibration",
               &S::calibration,
               "rigid transform from the world in m to the array; row by row, translation last")
            .safety(),
        Row<S>("metresPerUnit", &S::metresPerUnit, "length of a scene unit")
            .range(1e-9, 1e9, "m")
            .safety()};
}

std::vector<Setting<S>> hands()
{
    return {
        Row<S>("hands",
               &S::hands,
               "source of tracked hands: none, recorded:FILE, recorded:FILE?loop, mouse:, openxr:, "
               "osc:, or a name from the user's grants")
            .variable("HANDS"),
        Row<S>("reach", &S::reach, "solve only points this near to a hand; 0: all")
            .range(0.0, 10.0, "m")
            .variable("REACH")
            .safety(),
        Row<S>("shadows",
               &S::shadows,
               "hands and obstacles block sound, which the solver takes into account")};
}

// HapticSettings::repair() judges the text of earPoints.
std::vector<Setting<S>> ears()
{
    return {Row<S>("earPoints",
                   &S::earPoints,
                   "listening places besides those around the array: x y z; x y z .. in m, array "
                   "frame",
                   6)
                .safety(),
            Row<S>("earCamera",
                   &S::earCamera,
                   "the viewer's camera stands for a head, whose ears are listening places",
                   6)
                .safety()};
}

std::vector<Setting<S>> prediction()
{
    return {
        Row<S>("prediction",
               EnumMember<&S::prediction>::choice(),
               "who predicts hands to when the sound arrives: nobody, the tracker, or the kit by "
               "one of three filters",
               6)
            .words({{"off", "OFF", S::OFF},
                    {"tracker", "TRACKER", S::TRACKER},
                    {"alpha-beta", "ALPHA_BETA", S::ALPHA_BETA},
                    {"kalman", "KALMAN", S::KALMAN},
                    {"one-euro", "ONE_EURO", S::ONE_EURO}})
            .variable("PREDICTION"),
        Row<S>("trackerDelay",
               &S::trackerDelay,
               "the tracker's own delay, which prediction makes up for",
               6)
            .range(0.0, 0.2, "s")
            .variable("TRACKER_DELAY")};
}

std::vector<Setting<S>> contacts()
{
    return {
        Row<S>("render",
               EnumMember<&S::render>::choice(),
               "what is played of objects: the whole, foci on the skin where hands touch, or auto: "
               "these while hands are known well enough",
               7)
            .words({{"object", "OBJECT", S::OBJECT},
                    {"contact", "CONTACT", S::CONTACT},
                    {"auto", "AUTO", S::AUTO}})
            .variable("RENDER"),
        Row<S>("contactRate", &S::contactRate, "turns a second of the foci of a contact", 7)
            .range(0.0, 100.0, "Hz"),
        Row<S>("contactStep", &S::contactStep, "longest step of a focus from field to field", 7)
            .range(5e-5, 5e-3, "m"),
        Row<S>("contactFoci", &S::contactFoci, "most foci of a contact", 7).range(1, 10),
        Row<S>("contactMask",
               &S::contactMask,
               "transducers behind the finger are off, so that its other side isn't pressed",
               7),
        Row<S>("trackerError",
               &S::trackerError,
               "error of the hands' places, by which auto decides",
               7)
            .range(0.0, 0.1, "m")};
}

std::vector<Setting<S>> thermometer()
{
    return {Row<S>("temperatureSource",
                   &S::temperatureSource,
                   "file or pipe of a thermometer, a reading in C a line, that the temperature "
                   "follows, or a name from the user's grants",
                   8)
                .variable("TEMPERATURE_SOURCE")};
}

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
    if (!unit.empty()) property.pressureUnit = isPascal ? P::PASCAL : P::RELATIVE;
    return true;
}

std::vector<Setting<P>> strength()
{
    return {
        Row<P>("enabled", &P::enabled, "false: the object is not felt").safety(),
        Row<P>("pressure",
               &P::pressure,
               "relative to the scene's other objects (the array plays as loud as the field stays "
               "accurate), or peak pressure with its unit: 500 Pa")
            .range(1e-6, 1e5)
            .parsedBy(setPressure)
            .safety(),
        Row<P>("unit", EnumMember<&P::pressureUnit>::choice(), "unit of the pressure")
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
            .words({{"surface", "SURFACE", P::SURFACE},
                    {"edges", "EDGES", P::EDGES},
                    {"vertices", "VERTICES", P::VERTICES}}),
        Row<P>("side",
               EnumMember<&P::side>::choice(),
               "side of the faces that is felt; front: towards where most of the array's sound "
               "comes from")
            .words({{"both", "BOTH", P::BOTH},
                    {"front", "FRONT", P::FRONT},
                    {"back", "BACK", P::BACK}}),
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
            .range(0.0, 1.0)};
}

std::vector<Setting<P>> contact()
{
    return {
        Row<P>("render",
               EnumMember<&P::render>::choice(),
               "what is played of the object: as the scene says, the whole, foci on the skin "
               "where hands touch it, or auto",
               7)
            .words({{"inherit", "INHERIT", P::INHERIT},
                    {"object", "OBJECT", P::OBJECT},
                    {"contact", "CONTACT", P::CONTACT},
                    {"auto", "AUTO", P::AUTO}}),
        Row<P>("material",
               &P::material,
               "how it feels where it is touched: skin, rubber, glass, sandpaper, cloth, or a "
               "name from the file that OSG_MIDAIR_MATERIALS names",
               7),
        Row<P>("stiffness", &P::stiffness, "applied force over depth; 0: the material's", 7)
            .range(0.1, 1e4, "N/m")
            .orZero(),
        Row<P>(
            "contactForce", &P::contactForce, "where the force stops growing; 0: the material's", 7)
            .range(1e-4, 1.0, "N")
            .orZero()
            .safety(),
        Row<P>("softness",
               &P::softness,
               "growth of the circle's radius over the depth; 0: the material's",
               7)
            .range(0.001, 10.0)
            .orZero(),
        Row<P>("roughness",
               &P::roughness,
               "share of the pressure that the texture takes away; 0: the material's",
               7)
            .range(0.001, 1.0)
            .orZero(),
        Row<P>(
            "texturePeriod", &P::texturePeriod, "wavelength of the texture; 0: the material's", 7)
            .range(1e-5, 1.0, "m")
            .orZero(),
        Row<P>("lowVibration",
               &P::lowVibration,
               "share that a vibration of 30 Hz takes away; 0: the material's",
               7)
            .range(0.001, 1.0)
            .orZero(),
        Row<P>("highVibration",
               &P::highVibration,
               "share that a vibration of 150 Hz takes away; 0: the material's",
               7)
            .range(0.001, 1.0)
            .orZero()};
}

std::vector<Setting<P>> paintAndTouch()
{
    return {Row<P>("intensity",
                   EnumMember<&P::intensity>::choice(),
                   "painted haptics: source of the factor on the pressure")
                .words({{"uniform", "UNIFORM", P::UNIFORM},
                        {"vertex-color", "VERTEX_COLOR", P::VERTEX_COLOR},
                        {"texture", "TEXTURE", P::TEXTURE}}),
            Row<P>("intensityChannel",
                   EnumMember<&P::intensityChannel>::choice(),
                   "channel of the paint that gives the factor; brightness: mean of red, green and "
                   "blue, times alpha",
                   2)
                .words({{"brightness", "BRIGHTNESS", P::BRIGHTNESS},
                        {"red", "RED", P::RED},
                        {"green", "GREEN", P::GREEN},
                        {"blue", "BLUE", P::BLUE},
                        {"alpha", "ALPHA", P::ALPHA}}),
            Row<P>("intensityLow",
                   &P::intensityLow,
                   "factor where the channel is 0; points with factor 0 are not felt",
                   2)
                .range(0.0, 1.0),
            Row<P>("intensityHigh",
                   &P::intensityHigh,
                   "factor where the channel is full; below intensityLow: inverted",
                   2)
                .range(0.0, 1.0),
            Row<P>("touchEvents",
                   &P::touchEvents,
                   "report hands that begin and end to touch the object")};
}

} // namespace

const SettingTable<HapticSettings>& sceneSettings()
{
    static const SettingTable<S> table(
        joined<S>({place(),
                   inherited<S>(midair::haptics::fieldSettings().rows()),
                   hands(),
                   ears(),
                   prediction(),
                   contacts(),
                   thermometer()}));
    return table;
}

const SettingTable<HapticProperty>& surfaceProperties()
{
    static const SettingTable<P> table(joined<P>({strength(), paintAndTouch(), contact()}));
    return table;
}

std::optional<std::string> HapticWishes::*wishOf(const std::string& setting)
{
    if (setting == "array") return &HapticWishes::array;
    if (setting == "device") return &HapticWishes::device;
    if (setting == "hands") return &HapticWishes::hands;
    if (setting == "temperatureSource") return &HapticWishes::temperatureSource;
    return nullptr;
}

} // namespace osgMidair
