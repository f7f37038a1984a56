// The table of settings. To add one, add its member to HapticSettings or HapticProperty and its row
// here. Rows are stored in this order, version by version; .osgb is positional, so a stored row
// must keep its place and its version.
#include "haptics/base/Limits.h"
#include "haptics/base/text/Number.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/solvers/HologramSolver.h"
#include "plugin/settings/SettingTable.h"

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using namespace midair::base;

using S = HapticSettings;
using P = HapticProperty;

/// Builds a row: the constructor takes what every row has, the named functions set the rest.
template<typename T>
class Row
{
public:
    Row(const char* name, Member<T> member, const std::string& help, int since = 1)
    {
        _setting.name = name;
        _setting.member = member;
        _setting.help = help;
        _setting.since = since;
    }
    Row& range(double low, double high, const char* unit = "")
    {
        _setting.range.low = low;
        _setting.range.high = high;
        _setting.unit = unit;
        return *this;
    }
    Row& orZero()
    {
        _setting.range.orZero = true;
        return *this;
    }
    Row& words(const std::vector<Word>& words)
    {
        _setting.words = words;
        return *this;
    }
    Row& stored(const char* name)
    {
        _setting.stored = name;
        return *this;
    }
    Row& variable(const char* name)
    {
        _setting.variable = name;
        return *this;
    }
    Row& safety()
    {
        _setting.isSafety = true;
        return *this;
    }
    Row& wish(std::optional<std::string> HapticWishes::*wish)
    {
        _setting.wish = wish;
        return *this;
    }
    Row& parsedBy(bool (*parse)(T&, const std::string&))
    {
        _setting.parse = parse;
        return *this;
    }
    operator Setting<T>() const { return _setting; } // NOLINT(google-explicit-constructor)

private:
    Setting<T> _setting;
};

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

std::string solverList()
{
    return fmt::format("{}", fmt::join(midair::haptics::solverNames(), ", "));
}

std::vector<Setting<S>> placeAndAir()
{
    return {
        Row<S>("enabled", &S::enabled, "false: the array is silent").variable("ENABLED").safety(),
        Row<S>(
            "array", &S::array, "octagon, board, the name of another shipped array, or a JSON file")
            .variable("ARRAY")
            .wish(&HapticWishes::array),
        Row<S>("device",
               &S::device,
               "what plays: the URI of a device (sim:, record:FILE, null:, ..) or a name from the "
               "user's grants")
            .variable("DEVICE")
            .wish(&HapticWishes::device),
        Row<S>("calibration",
               &S::calibration,
               "rigid transform from the world in m to the array; row by row, translation last")
            .safety(),
        Row<S>("metresPerUnit", &S::metresPerUnit, "length of a scene unit").range(1e-9, 1e9, "m"),
        Row<S>("temperature", &S::temperature, "temperature of the air")
            .range(kLeastTemperature_C, kMostTemperature_C, "C"),
        Row<S>("humidity", &S::humidity, "relative humidity of the air").range(0.0, 1.0),
        Row<S>("airPressure", &S::airPressure, "pressure of the air")
            .range(kLeastAirPressure_Pa, kMostAirPressure_Pa, "Pa")};
}

std::vector<Setting<S>> solving()
{
    const int most = midair::haptics::SelectorOptions().maxPoints;
    return {
        Row<S>("solver", &S::solver, solverList() + "; empty: the first").variable("SOLVER"),
        Row<S>("maxIterations",
               &S::maxIterations,
               "limit of the solver's iterations; 0: the solver's default")
            .range(0, 1000000),
        Row<S>("rmsTolerance", &S::rmsTolerance, "relative rms error at which the solver stops")
            .range(0.0, 1.0),
        Row<S>("deadline", &S::deadline_ms, "time limit of a solve; 0: none").range(0.0, 1e6, "ms"),
        Row<S>("lambda", &S::lambda, "Tikhonov regularisation, relative to trace(K)/n")
            .range(0.0, kNoEnd),
        Row<S>(
            "loudness",
            &S::loudness,
            "1: as loud as the field stays accurate; below: quieter; above: louder, less accurate")
            .range(1e-6, kMostLoudness),
        Row<S>("phaseOnly", &S::phaseOnly, "play all transducers at one amplitude"),
        Row<S>("threads", &S::threads, "threads of the solver").range(1, kMostThreads),
        Row<S>("motionTolerance", &S::motionTolerance, "objects that move by less keep their field")
            .range(0.0, 1e3, "wavelengths"),
        Row<S>("maxPoints",
               &S::maxPoints,
               fmt::format("limit of control points, shared by all objects; 0: {}", most))
            .range(0, kMostControlPoints)};
}

std::vector<Setting<S>> playing()
{
    return {
        Row<S>("hands",
               &S::hands,
               "source of tracked hands: none, recorded:FILE, recorded:FILE?loop, openxr:, or a "
               "name from the user's grants")
            .variable("HANDS")
            .wish(&HapticWishes::hands),
        Row<S>("reach", &S::reach, "solve only points this near to a hand; 0: all")
            .range(0.0, 10.0, "m")
            .variable("REACH"),
        Row<S>("shadows",
               &S::shadows,
               "hands and obstacles block sound, which the solver takes into account"),
        Row<S>("maxPressure",
               &S::maxPressure,
               "cap on the peak pressure at control points; 0: no cap",
               2)
            .range(0.0, kMostPressure_Pa, "Pa")
            .variable("MAX_PRESSURE")
            .safety(),
        Row<S>("cycle",
               &S::cycle,
               "number of fields with shifted points, played in turn to smooth objects at rest",
               3)
            .range(1, kMostCycle)
            .variable("CYCLE"),
        Row<S>("cycleSteps",
               &S::cycleSteps,
               "intermediate steps from one field of the cycle to the next",
               3)
            .range(0, kMostCycleSteps),
        Row<S>("subsets",
               &S::subsets,
               "number of subsets of the points, played in turn: each stronger, but less often",
               3)
            .range(1, kMostSubsets)
            .variable("SUBSETS"),
        Row<S>(
            "fieldRate", &S::fieldRate, "rate of fields that are played in turn, steps included", 3)
            .range(1.0, kMostFieldRate_Hz, "Hz"),
        Row<S>("denseOutlines", &S::denseOutlines, "play edges at rest as one smooth field", 3),
        Row<S>("monitorInterval",
               &S::monitorInterval,
               "shortest time between two measurements; 0: never",
               3)
            .range(kLeastMonitorInterval_s, kMostMonitorInterval_s, "s")
            .orZero()
            .variable("MONITOR"),
        Row<S>("maxAmplitude",
               &S::maxAmplitude,
               "cap on each transducer's amplitude; 1: full drive",
               4)
            .range(0.0, 1.0)
            .variable("MAX_AMPLITUDE")
            .safety()};
}

/// Parses "2", "2 relative", "500 Pa", "1.2kPa".
bool setPressure(P& property, const std::string& text)
{
    const std::size_t end = text.find_first_not_of("+-.0123456789eE");
    double value = 0.0;
    if (!parseNumber(text.substr(0, end), value)) return false;
    std::string unit = end == std::string::npos ? std::string() : text.substr(end);
    unit.erase(0, unit.find_first_not_of(" \t"));
    unit.erase(unit.find_last_not_of(" \t") + 1);
    if (unit != "" && unit != "relative" && unit != "Pa" && unit != "kPa") return false;
    property.pressure = unit == "kPa" ? value * 1e3 : value;
    property.pressureUnit = unit == "Pa" || unit == "kPa" ? P::PASCAL : P::RELATIVE;
    return true;
}

std::vector<Setting<P>> strength()
{
    return {
        Row<P>("enabled", &P::enabled, "false: the object is not felt"),
        Row<P>("pressure",
               &P::pressure,
               "relative to the scene's other objects (the array plays as loud as the field stays "
               "accurate), or peak pressure with its unit: 500 Pa")
            .range(1e-6, 1e5)
            .parsedBy(setPressure),
        Row<P>("unit", EnumMember<&P::pressureUnit>::choice(), "unit of the pressure")
            .words({{"relative", "RELATIVE", P::RELATIVE}, {"Pa", "PASCAL", P::PASCAL}})
            .stored("PressureUnit"),
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

template<typename T>
SettingTable<T> tableOf(std::initializer_list<std::vector<Setting<T>>> groups)
{
    std::vector<Setting<T>> rows;
    for (const std::vector<Setting<T>>& group : groups)
        rows.insert(rows.end(), group.begin(), group.end());
    return SettingTable<T>(std::move(rows));
}

} // namespace

const SettingTable<HapticSettings>& sceneSettings()
{
    static const SettingTable<S> table = tableOf<S>({placeAndAir(), solving(), playing()});
    return table;
}

const SettingTable<HapticProperty>& surfaceProperties()
{
    static const SettingTable<P> table = tableOf<P>({strength(), paintAndTouch()});
    return table;
}

} // namespace osgMidair
