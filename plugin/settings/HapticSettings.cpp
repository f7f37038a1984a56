#include "haptics/base/Limits.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/OptionTable.h"

#include <osgMidair/HapticSettings>

#include <algorithm>
#include <limits>

namespace osgMidair
{

namespace
{

constexpr double kNoLimit = std::numeric_limits<double>::max();
constexpr double kMostPressure_Pa = 1e6;

OptionTable<HapticSettings> makeTable()
{
    using S = HapticSettings;
    OptionTable<S> table;
    table.flag("enabled", &S::enabled, "true or false; false: the array is silent (default true)");
    table.text(
        "array", &S::array, "octagon (default), board, a shipped array's name or a JSON file");
    table.text("device", &S::device, "URI of the device (default sim:), e.g. record:FILE");
    table.add(
        {"calibration",
         "world in m -> array, rigid: 16 numbers, row by row, translation last (default identity)",
         [](S& settings, const std::string& text)
         { return parseMatrix(text, settings.calibration); },
         "16 numbers",
         {}});
    table.number(
        "metresPerUnit", &S::metresPerUnit, 1e-9, 1e9, "what a unit of the scene is (default 1)");
    table.number(
        "temperature", &S::temperature, -40.0, 60.0, "degrees Celsius, -40 .. 60 (default 20)");
    table.number("humidity", &S::humidity, 0.0, 1.0, "relative, 0 .. 1 (default 0.5)");
    table.number(
        "airPressure", &S::airPressure, 50e3, 120e3, "Pa, 50000 .. 120000 (default 101325)");
    table.text("solver", &S::solver, "a solver's name (default: the best there is)");
    table.number("maxIterations", &S::maxIterations, 0, 1000000, "0: the solver's own (default)");
    table.number("rmsTolerance",
                 &S::rmsTolerance,
                 0.0,
                 1.0,
                 "relative error to stop at, 0 .. 1 (default 0.001)");
    table.number("deadline", &S::deadline, 0.0, 1e6, "ms for a solve; 0: none (default)");
    table.number("lambda",
                 &S::lambda,
                 0.0,
                 kNoLimit,
                 "regularisation, relative to trace(K)/n (default 0.1)");
    table.number(
        "loudness",
        &S::loudness,
        1e-6,
        2.0,
        "over 0 .. 2; 1 (default): as loud as it accurately can; above: louder, less accurate");
    table.flag("phaseOnly", &S::phaseOnly, "true (default): all transducers at one amplitude");
    table.number("threads", &S::threads, 1, 256, "of the solver (default 1)");
    table.number("motionTolerance",
                 &S::motionTolerance,
                 0.0,
                 1e3,
                 "wavelengths; what moves less is not solved again (default 0.01)");
    table.number("maxPoints",
                 &S::maxPoints,
                 0,
                 midair::base::kMostControlPoints,
                 "control points shared by all objects, at most 5000; 0: 1000 (default)");
    table.text(
        "hands",
        &S::hands,
        "where hands come from: none (default), recorded:FILE, recorded:FILE?loop, openxr:, or a "
        "name of the user's");
    table.number("reach",
                 &S::reach,
                 0.0,
                 10.0,
                 "m; only points so near to a hand are solved; 0: all (default)");
    table.flag("shadows",
               &S::shadows,
               "true or false; hands and obstacles are in the sound's way (default false)");
    table.number("maxPressure",
                 &S::maxPressure,
                 0.0,
                 kMostPressure_Pa,
                 "Pa (peak) that no control point gets more than; 0: no cap (default)");
    table.number("maxAmplitude",
                 &S::maxAmplitude,
                 0.0,
                 1.0,
                 "0 .. 1 of full drive that no transducer gets more than (default 1)");
    table.number("cycle",
                 &S::cycle,
                 1,
                 64,
                 "fields for shifted points in turn, which smooth what rests (default 1)");
    table.number("cycleSteps", &S::cycleSteps, 0, 16, "between one field and the next (default 0)");
    table.number(
        "subsets", &S::subsets, 1, 64, "of the points, played in turn: harder, less often (1)");
    table.number("fieldRate",
                 &S::fieldRate,
                 1.0,
                 40e3,
                 "fields a second, where they are played in turn (default 1000)");
    table.flag("denseOutlines",
               &S::denseOutlines,
               "true (default) or false; edges that rest are one smooth field");
    table.numberOrZero(
        "monitorInterval",
        &S::monitorInterval,
        0.05,
        1e6,
        "s, 0.05 .. 1e6; so often fields are certified and measured; 0: never (default)");
    return table;
}

bool isForSafety(const std::string& name)
{
    return name == "enabled" || name == "maxPressure" || name == "maxAmplitude" ||
           name == "calibration";
}

const OptionTable<HapticSettings>& settingsTable()
{
    static const OptionTable<HapticSettings> table = makeTable();
    return table;
}

} // namespace

bool HapticSettings::set(const std::string& name, const std::string& value, std::string& error)
{
    if (!settingsTable().set(*this, name, value, error))
    {
        // A limit that nobody understands is kept best by silence.
        if (!isForSafety(name)) return false;
        isSilenced = true;
        error += "; nothing is played";
        return false;
    }
    // Whoever sets it by name is no file.
    if (name == "array") wishes.array.reset();
    if (name == "device") wishes.device.reset();
    if (name == "hands") wishes.hands.reset();
    return true;
}

bool HapticSettings::isLimit(double maxPressure_Pa, double maxAmplitude)
{
    return maxPressure_Pa >= 0.0 && maxPressure_Pa <= kMostPressure_Pa && maxAmplitude >= 0.0 &&
           maxAmplitude <= 1.0; // false for NaN, too
}

std::vector<std::string> HapticSettings::repair()
{
    const bool isLimited = isLimit(maxPressure, maxAmplitude);
    std::vector<std::string> said = settingsTable().repair(*this);
    if (isLimited) return said;
    isSilenced = true;
    said.emplace_back("a limit is out of range: nothing is played");
    return said;
}

std::vector<std::pair<std::string, std::string>> HapticSettings::describe()
{
    return settingsTable().describe();
}

bool operator==(const HapticSettings& a, const HapticSettings& b)
{
    return a.enabled == b.enabled && a.array == b.array && a.device == b.device &&
           std::equal(a.calibration.ptr(), a.calibration.ptr() + 16, b.calibration.ptr(), same) &&
           same(a.metresPerUnit, b.metresPerUnit) && same(a.temperature, b.temperature) &&
           same(a.humidity, b.humidity) && same(a.airPressure, b.airPressure) &&
           a.solver == b.solver && a.maxIterations == b.maxIterations &&
           same(a.rmsTolerance, b.rmsTolerance) && same(a.deadline, b.deadline) &&
           same(a.lambda, b.lambda) && same(a.loudness, b.loudness) && a.phaseOnly == b.phaseOnly &&
           a.threads == b.threads && same(a.motionTolerance, b.motionTolerance) &&
           a.maxPoints == b.maxPoints && a.hands == b.hands && same(a.reach, b.reach) &&
           a.shadows == b.shadows && same(a.maxPressure, b.maxPressure) &&
           same(a.maxAmplitude, b.maxAmplitude) && a.cycle == b.cycle &&
           a.cycleSteps == b.cycleSteps && a.subsets == b.subsets &&
           same(a.fieldRate, b.fieldRate) && a.denseOutlines == b.denseOutlines &&
           same(a.monitorInterval, b.monitorInterval) && a.wishes == b.wishes &&
           a.isSilenced == b.isSilenced;
}

} // namespace osgMidair
