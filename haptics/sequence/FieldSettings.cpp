#include "haptics/sequence/FieldSettings.h"

#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/Number.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/SolverSettings.h"

namespace midair::base
{

template struct Setting<haptics::FieldSettings>;
template bool isSame(const Member<haptics::FieldSettings>&,
                     const haptics::FieldSettings&,
                     const haptics::FieldSettings&);

} // namespace midair::base

namespace midair::haptics
{

namespace
{

using namespace base;

using S = FieldSettings;

std::vector<Setting<S>> air()
{
    return {Row<S>("temperature", &S::temperature, "temperature of the air")
                .range(kLeastTemperature_C, kMostTemperature_C, "C")
                .effect(Effect::NOTHING), // playing fields follow the air
            Row<S>("humidity", &S::humidity, "relative humidity of the air").range(0.0, 1.0),
            Row<S>("airPressure", &S::airPressure, "pressure of the air")
                .range(kLeastAirPressure_Pa, kMostAirPressure_Pa, "Pa")};
}

std::vector<Setting<S>> solver()
{
    const std::string names = fmt::format("{}", fmt::join(solverNames(), ", "));
    return {
        Row<S>("solver", &S::solver, "method: " + names + "; empty: the first").variable("SOLVER")};
}

std::vector<Setting<S>> points()
{
    const int most = SelectorOptions().maxPoints;
    return {
        Row<S>("motionTolerance", &S::motionTolerance, "objects that move by less keep their field")
            .range(0.0, 1e3, "wavelengths")
            .use(Use::POINTS),
        Row<S>("maxPoints",
               &S::maxPoints,
               fmt::format("limit of control points, shared by all objects; 0: {}", most))
            .range(0, kMostControlPoints)};
}

const char* const kEvenHelp =
    "passes for evening out a cycle's fields together while objects rest; a held field takes 24 "
    "times as many, two 12 times, three 8 times; 0: none";

std::vector<Setting<S>> playing()
{
    return {
        Row<S>(
            "maxPressure", &S::maxPressure, "cap on the peak pressure at control points; 0: no cap")
            .range(0.0, kMostPressure_Pa, "Pa")
            .variable("MAX_PRESSURE")
            .safety()
            .use(Use::STILL),
        Row<S>("cycle",
               &S::cycle,
               "number of fields with shifted points, played in turn to smooth objects at rest")
            .range(1, kMostCycle)
            .named({{"calm", "calm", 1}, {"balanced", "balanced", 2}, {"smooth", "smooth", 8}})
            .variable("CYCLE")
            .use(Use::STILL),
        Row<S>("cycleSteps",
               &S::cycleSteps,
               "intermediate steps from one field of the cycle to the next, which make it less "
               "audible")
            .range(0, kMostCycleSteps)
            .use(Use::STILL),
        Row<S>("subsets",
               &S::subsets,
               "number of subsets of the points, played in turn: each stronger, but less often")
            .range(1, kMostSubsets)
            .variable("SUBSETS")
            .use(Use::STILL),
        Row<S>("fieldRate", &S::fieldRate, "rate of fields that are played in turn, steps included")
            .range(1.0, kMostFieldRate_Hz, "Hz"),
        Row<S>("denseOutlines", &S::denseOutlines, "play edges at rest as one smooth field")
            .use(Use::PLAYED),
        Row<S>("monitorInterval",
               &S::monitorInterval,
               "shortest time between two measurements of what is played; 0: never")
            .range(kLeastMonitorInterval_s, kMostMonitorInterval_s, "s")
            .orZero()
            .variable("MONITOR")
            .noIdentity()
            .use(Use::PLAYED),
        Row<S>(
            "maxAmplitude", &S::maxAmplitude, "cap on each transducer's amplitude; 1: full drive")
            .range(0.0, 1.0)
            .variable("MAX_AMPLITUDE")
            .safety()
            .use(Use::PLAYED), // devices enforce it
        Row<S>("even", &S::even, kEvenHelp).range(0, kMostEven).use(Use::STILL),
        Row<S>(
            "earLimit",
            &S::earLimit,
            "cap on the rms level at listening places around the array, re 20 uPa, with 6 dB for a "
            "head; 0 or none: no cap")
            .range(kLeastEarLimit_dB, kMostEarLimit_dB, "dB")
            .orZero()
            .zeroIs("none")
            .variable("EAR_LIMIT")
            .safety()
            .use(Use::STILL)};
}

std::vector<Setting<S>> feeling()
{
    return {Row<S>("feelThreshold",
                   &S::feelThreshold,
                   "least force on a fingertip that is felt, for the words of how strong it is; 0: "
                   "as published")
                .range(1e-6, 1.0, "N")
                .orZero()
                .use(Use::STILL)};
}

/// Returns the text of \a read's InputError, or an empty text.
template<typename Read>
std::string refusalOf(const Read& read)
{
    try
    {
        read();
    }
    catch (const InputError& error)
    {
        return error.what();
    }
    return {};
}

std::vector<Setting<S>> transducers()
{
    return {
        Row<S>("dead",
               &S::dead,
               "transducers that are never driven, besides the array's own: 17, 400-410")
            .safety()
            .effect(Effect::REOPEN)
            .judgedBy([](const S& s) { return refusalOf([&s] { parseIndices(s.dead, "dead"); }); }),
        Row<S>("weak",
               &S::weak,
               fmt::format("gains of transducers, above 0 and at most {:g}, in place of the "
                           "array's: 17:0.5, 400-410:0.8",
                           kMostGain))
            .safety()
            .effect(Effect::REOPEN)
            .judgedBy(
                [](const S& s)
                { return refusalOf([&s] { parseIndexedNumbers(s.weak, "weak", kMostGain); }); })};
}

} // namespace

// Files store rows in this order; .osgb is positional, so a row must keep its place.
const SettingTable<FieldSettings>& fieldSettings()
{
    static const SettingTable<S> table(joined<S>({air(),
                                                  solver(),
                                                  inherited<S>(solverSettings().rows()),
                                                  points(),
                                                  playing(),
                                                  feeling(),
                                                  transducers()}));
    return table;
}

Medium mediumOf(const FieldSettings& settings)
{
    return {settings.temperature, settings.humidity, settings.airPressure};
}

} // namespace midair::haptics
