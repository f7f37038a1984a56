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
        Row<S>("array", &S::array, "octagon, board, a shipped array's name or a JSON file")
            .variable("ARRAY")
            .wish(&HapticWishes::array),
        Row<S>("device",
               &S::device,
               "what plays: the URI of a device, sim:, record:FILE, null:, .., or a name of the "
               "user's")
            .variable("DEVICE")
            .wish(&HapticWishes::device),
        Row<S>("calibration",
               &S::calibration,
               "world in m -> array, rigid; row by row, translation last")
            .safety(),
        Row<S>("metresPerUnit", &S::metresPerUnit, "what a unit of the scene is")
            .range(1e-9, 1e9, "m"),
        Row<S>("temperature", &S::temperature, "of the air")
            .range(kLeastTemperature_C, kMostTemperature_C, "C"),
        Row<S>("humidity", &S::humidity, "of the air, relative").range(0.0, 1.0),
        Row<S>("airPressure", &S::airPressure, "of the air")
            .range(kLeastAirPressure_Pa, kMostAirPressure_Pa, "Pa")};
}

std::vector<Setting<S>> solving()
{
    const int most = midair::haptics::SelectorOptions().maxPoints;
    return {
        Row<S>("solver", &S::solver, solverList() + "; without one: the best there is")
            .variable("SOLVER"),
        Row<S>("maxIterations", &S::maxIterations, "of the solver; 0: the solver's own")
            .range(0, 1000000),
        Row<S>("rmsTolerance", &S::rmsTolerance, "relative error at which the solver stops")
            .range(0.0, 1.0),
        Row<S>("deadline", &S::deadline_ms, "for a solve; 0: none").range(0.0, 1e6, "ms"),
        Row<S>("lambda", &S::lambda, "regularisation, relative to trace(K)/n").range(0.0, kNoEnd),
        Row<S>("loudness",
               &S::loudness,
               "1: as loud as it accurately can; below: quieter; above: louder, less accurate")
            .range(1e-6, kMostLoudness),
        Row<S>("phaseOnly", &S::phaseOnly, "all transducers at one amplitude"),
        Row<S>("threads", &S::threads, "of the solver").range(1, kMostThreads),
        Row<S>("motionTolerance", &S::motionTolerance, "what moves less is not solved again")
            .range(0.0, 1e3, "wavelengths"),
        Row<S>("maxPoints",
               &S::maxPoints,
               fmt::format("control points shared by all objects; 0: {}", most))
            .range(0, kMostControlPoints)};
}

std::vector<Setting<S>> playing()
{
    return {
        Row<S>("hands",
               &S::hands,
               "where hands come from: none, recorded:FILE, recorded:FILE?loop, openxr:, or a name "
               "of the user's")
            .variable("HANDS")
            .wish(&HapticWishes::hands),
        Row<S>("reach", &S::reach, "only points so near to a hand are solved; 0: all")
            .range(0.0, 10.0, "m")
            .variable("REACH"),
        Row<S>("shadows", &S::shadows, "hands and obstacles are in the sound's way"),
        Row<S>("maxPressure",
               &S::maxPressure,
               "peak that no control point gets more than; 0: no cap",
               2)
            .range(0.0, kMostPressure_Pa, "Pa")
            .variable("MAX_PRESSURE")
            .safety(),
        Row<S>("cycle", &S::cycle, "fields for shifted points in turn, which smooth what rests", 3)
            .range(1, kMostCycle)
            .variable("CYCLE"),
        Row<S>("cycleSteps", &S::cycleSteps, "between one field and the next", 3)
            .range(0, kMostCycleSteps),
        Row<S>("subsets", &S::subsets, "of the points, played in turn: harder, less often", 3)
            .range(1, kMostSubsets)
            .variable("SUBSETS"),
        Row<S>("fieldRate", &S::fieldRate, "at which fields follow each other, steps included", 3)
            .range(1.0, kMostFieldRate_Hz, "Hz"),
        Row<S>("denseOutlines", &S::denseOutlines, "edges that rest are one smooth field", 3),
        Row<S>("monitorInterval",
               &S::monitorInterval,
               "so often a field is certified and measured; 0: never",
               3)
            .range(kLeastMonitorInterval_s, kMostMonitorInterval_s, "s")
            .orZero()
            .variable("MONITOR"),
        Row<S>(
            "maxAmplitude", &S::maxAmplitude, "of full drive, that no transducer gets more than", 4)
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
    return {Row<P>("enabled", &P::enabled, "can it be felt"),
            Row<P>("pressure",
                   &P::pressure,
                   "relative to the scene's other objects (the array plays as loud as it "
                   "accurately can), or with its unit: 500 Pa, peak")
                .range(1e-6, 1e5)
                .parsedBy(setPressure),
            Row<P>("unit", EnumMember<&P::pressureUnit>::choice(), "of the pressure")
                .words({{"relative", "RELATIVE", P::RELATIVE}, {"Pa", "PASCAL", P::PASCAL}})
                .stored("PressureUnit"),
            Row<P>("spacing", &P::spacing, "between control points; 0: one wavelength")
                .range(0.001, 1.0, "m")
                .orZero(),
            Row<P>("sampling",
                   EnumMember<&P::sampling>::choice(),
                   "where points go: over the faces, along edges, to the mesh's own vertices")
                .words({{"surface", "SURFACE", P::SURFACE},
                        {"edges", "EDGES", P::EDGES},
                        {"vertices", "VERTICES", P::VERTICES}}),
            Row<P>("side",
                   EnumMember<&P::side>::choice(),
                   "of its faces: front is turned to where most of the array's sound comes from")
                .words({{"both", "BOTH", P::BOTH},
                        {"front", "FRONT", P::FRONT},
                        {"back", "BACK", P::BACK}}),
            Row<P>("priority", &P::priority, "larger wins where points are too near or too many")
                .range(-1000000, 1000000),
            Row<P>("modulationFrequency",
                   &P::modulationFrequency,
                   "of the pressure on the skin; 0: steady; objects of one scene share one, that "
                   "of the highest priority")
                .range(0.0, kMostModulation_Hz, "Hz"),
            Row<P>("modulationDepth",
                   &P::modulationDepth,
                   "by how much of itself the pressure on the skin goes down")
                .range(0.0, 1.0)};
}

std::vector<Setting<P>> paintAndTouch()
{
    return {Row<P>("intensity",
                   EnumMember<&P::intensity>::choice(),
                   "painted haptics: what the pressure is multiplied by")
                .words({{"uniform", "UNIFORM", P::UNIFORM},
                        {"vertex-color", "VERTEX_COLOR", P::VERTEX_COLOR},
                        {"texture", "TEXTURE", P::TEXTURE}}),
            Row<P>("intensityChannel",
                   EnumMember<&P::intensityChannel>::choice(),
                   "of the paint; brightness: mean of red, green and blue, times alpha",
                   2)
                .words({{"brightness", "BRIGHTNESS", P::BRIGHTNESS},
                        {"red", "RED", P::RED},
                        {"green", "GREEN", P::GREEN},
                        {"blue", "BLUE", P::BLUE},
                        {"alpha", "ALPHA", P::ALPHA}}),
            Row<P>("intensityLow",
                   &P::intensityLow,
                   "intensity where the channel is 0; a point with none is not felt",
                   2)
                .range(0.0, 1.0),
            Row<P>("intensityHigh",
                   &P::intensityHigh,
                   "intensity where the channel is full; below intensityLow: inverted",
                   2)
                .range(0.0, 1.0),
            Row<P>("touchEvents", &P::touchEvents, "report hands that enter and leave")};
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
