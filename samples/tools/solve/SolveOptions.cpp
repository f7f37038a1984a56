#include "samples/tools/solve/SolveOptions.h"

#include "haptics/array/TransducerArray.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/sequence/FieldSettings.h"
#include "haptics/solvers/SolverSettings.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/solve/SolveFiles.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// Adds the settings of a static field; the values in \a arguments are the defaults.
void addFieldSettings(CLI::App& app, SolveArguments& arguments)
{
    using Setting = base::Setting<haptics::FieldSettings>;
    const auto given = std::make_shared<Given>();
    for (const Setting& row : haptics::fieldSettings().rows())
    {
        if (!(row.use & base::Use::STILL)) continue;
        const auto problemOf = [&row](const std::string& text) -> std::string
        {
            haptics::FieldSettings scratch;
            if (row.assign(scratch, text)) return row.problem(scratch, text);
            return "is \"" + text + "\", should be " + row.expected();
        };
        addSetting(app,
                   row.name,
                   row.summary(arguments.settings),
                   typeOf(row.unit, !row.words.empty()),
                   std::holds_alternative<bool haptics::FieldSettings::*>(row.member),
                   problemOf,
                   *given)
            ->group("The field");
    }
    app.parse_complete_callback(
        [given, &arguments]
        {
            std::string error;
            for (const auto& [name, value] : *given)
                if (!haptics::fieldSettings().set(arguments.settings, name, value, error))
                    throw CLI::ValidationError(error);
        });
}

void addProbeOptions(CLI::App& app, SolveArguments& arguments)
{
    auto* probe =
        app.add_option("--probe",
                       arguments.probes,
                       "Record the pressure over time at X Y Z (metres, array frame) while the "
                       "field plays, with ringing and propagation delays: probe.csv, spectrum.csv, "
                       "probe_points.csv and probe.png; repeatable")
            ->transform(inUnit("m", base::parseQuantity))
            ->type_size(3)
            ->type_name("X Y Z")
            ->allow_extra_args(false);
    app.add_flag("--probe-points", arguments.probePoints, "Also probe each control point");
    app.add_option("--probe-patch",
                   arguments.probePatch_m,
                   "Probe the surface within this distance of each --probe, metres")
        ->transform(inUnit("m", base::parseQuantity))
        ->check(CLI::PositiveNumber)
        ->needs(probe)
        ->excludes("--points-file");
    app.add_option("--duration",
                   arguments.probeDuration_s,
                   "Duration of a probe, seconds, from the start of a cycle")
        ->transform(inUnit("s", base::parseQuantity))
        ->check(CLI::Range(1e-6, 3600.0))
        ->capture_default_str();
    app.add_option("--probe-rate", arguments.probeRate_Hz, "Samples per second of a probe")
        ->transform(inUnit("Hz", base::parseQuantity))
        ->check(CLI::Range(1.0, 1e6))
        ->capture_default_str();
    app.add_option("--modulation",
                   arguments.modulation_Hz,
                   "Amplitude modulation between 0 and full pressure, Hz, for probes and figures "
                   "with ringing; drives are written unmodulated")
        ->transform(inUnit("Hz", base::parseQuantity))
        ->check(CLI::Range(0.0, base::kMostModulation_Hz));
    app.add_option("--ringing",
                   arguments.ringing_s,
                   "Time constant of the transducers, seconds (default: the array's); 0: none")
        ->transform(inUnit("s", base::parseQuantity))
        ->check(CLI::Range(0.0, haptics::kMostRinging_s));
}

std::string orEmpty(double value)
{
    return std::isnan(value) ? std::string() : fmt::format("{:.6g}", value);
}

std::string lineOf(const haptics::ToleranceRow& row, const char* name, const char* unit)
{
    return fmt::format("{},{:.6g},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{}\n",
                       name,
                       row.value,
                       unit,
                       row.draws,
                       row.rms,
                       row.rms90,
                       row.loudness,
                       row.loudness10,
                       row.focus,
                       row.focus10,
                       orEmpty(row.expectedRms),
                       orEmpty(row.expectedFocus));
}

void printLine(const std::string& what, const haptics::ToleranceRow& row)
{
    std::printf("%-12s%-18s rms %.2f %%, loudness E %.3f, focus %.3f\n",
                "",
                what.c_str(),
                100.0 * row.rms,
                row.loudness,
                row.focus);
}

/// Adds the input and its pose.
void addPlaces(CLI::App& app, SolveArguments& arguments)
{
    auto* model =
        app.add_option("MODEL", arguments.model, "Wavefront OBJ file (.obj); no other format");
    app.add_option("--points-file",
                   arguments.pointsFile,
                   "CSV file instead of a model: x_m,y_m,z_m,nx,ny,nz and target_Pa (absolute) or "
                   "target (relative)")
        ->excludes(model, app.get_option("--cycle"), app.get_option("--even"));
    app.add_option("--ears",
                   arguments.earsFile,
                   "CSV file of listening places, x_m,y_m,z_m: writes their levels into "
                   "exposure.csv and applies the ear limit there, too");
    app.add_option("--size",
                   arguments.size_m,
                   "Largest extent of the model in metres, or 8cm (default: as in the file)")
        ->transform(inUnit("m", base::parseQuantity))
        ->check(CLI::PositiveNumber);
    app.add_option("--position", arguments.position, "Position of the model's centre, metres")
        ->transform(inUnit("m", base::parseQuantity))
        ->expected(3);
    app.add_option("--rotation-deg",
                   arguments.rotation_deg,
                   "Rotation about x, then y, then z of the array frame")
        ->transform(inUnit("deg", base::parseQuantity))
        ->expected(3);
}

/// Adds what stands in the field.
void addStanding(CLI::App& app, SolveArguments& arguments)
{
    app.add_option(
        "--scatterer",
        arguments.scattererFile,
        "OBJ file of a closed, rigid body (metres, array frame; at 40 kHz at most some 40 cm^2), "
        "\"reflectors\" for rigid rectangles by their full waves, or \"hand\" for a right hand "
        "that points at the topmost point: tell what it does to the field, and correct points at "
        "rest "
        "for it");
    app.add_option("--scatterer-at",
                   arguments.scattererAt_m,
                   "Lowest place of the hand's index fingertip, metres (default: 1 mm above the "
                   "topmost point)")
        ->transform(inUnit("m", base::parseQuantity))
        ->expected(3);
    app.add_option("--scatterer-elements",
                   arguments.scattererElements,
                   "Most triangles of the hand: half of them take a quarter of the time, and are "
                   "less accurate")
        ->check(CLI::Range(1000, static_cast<int>(haptics::RigidBody::kMostElements)))
        ->capture_default_str();
    app.add_flag("--no-cache",
                 arguments.noCache,
                 "Make the matrix of a body anew, and don't keep it in ~/.cache/osgMidair");
    app.add_option("--reflectors",
                   arguments.reflectorsFile,
                   "JSON file of up to 8 flat reflectors (ARRAYS.md), besides the array's own: the "
                   "field is solved for their reflections where that pays");
    app.add_flag(
        "--no-correction",
        arguments.noCorrection,
        "Solve for free air, and only tell what reflectors and the scatterer do to the field");
}

/// Adds the array and the sampling of the model.
void addPoints(CLI::App& app, SolveArguments& arguments)
{
    static const std::map<std::string, haptics::Sampling> kSamplings{
        {"surface", haptics::Sampling::SURFACE},
        {"edges", haptics::Sampling::EDGES},
        {"vertices", haptics::Sampling::VERTICES}};
    app.add_option(
           "--array", arguments.array, "octagon, board, a shipped array's name, or FILE.json")
        ->capture_default_str();
    addStanding(app, arguments);
    app.add_option("--spacing",
                   arguments.spacing_m,
                   "Distance between control points, metres (default: one wavelength)")
        ->transform(inUnit("m", base::parseQuantity))
        ->check(CLI::PositiveNumber);
    app.add_option(
           "--sampling", arguments.sampling, "surface, edges or vertices (default: surface)")
        ->transform(CLI::CheckedTransformer(kSamplings).description(""));
    app.add_option(
           "--pressure",
           arguments.pressure_Pa,
           "Peak pressure at every point, Pa (default: as strong as the field stays accurate)")
        ->transform(inUnit("Pa", base::parseQuantity))
        ->check(CLI::PositiveNumber);
    static const std::map<std::string, haptics::Crowding> kCrowdings{
        {"thin", haptics::Crowding::THIN},
        {"merge", haptics::Crowding::MERGE},
        {"drop", haptics::Crowding::DROP}};
    app.add_option("--crowding",
                   arguments.crowding,
                   "thin, merge or drop points closer than a third of a wavelength (default: thin; "
                   "points of a file are kept)")
        ->transform(CLI::CheckedTransformer(kCrowdings).description(""))
        ->each([&arguments](const std::string&) { arguments.crowdingGiven = true; });
    app.add_option("--directivity",
                   arguments.directivity,
                   "t4010a1-harmonics, t4010a1-table or point (default: the array's)");
}

} // namespace

void addOptions(CLI::App& app, SolveArguments& arguments)
{
    addFieldSettings(app, arguments);
    app.get_option("--cycle-steps")->needs("--cycle");
    app.get_option("--even")->each([&arguments](const std::string&)
                                   { arguments.evenGiven = true; });
    addPlaces(app, arguments);
    addPoints(app, arguments);
    auto* outline = app.add_flag(
        "--outline",
        arguments.outline,
        "Play the model's edges as one stationary field of dense points, nearly without ripples");
    outline->excludes("--points-file",
                      "--cycle",
                      "--even",
                      "--subsets",
                      "--solver",
                      "--max-points",
                      "--crowding");
    // Outlines have their own solver.
    for (const auto& row : haptics::solverSettings().rows())
        if (row.name != "loudness" && row.name != "threads")
            outline->excludes(optionName(row.name));
    // These options sample, place or scale a model; a points file defines all of that.
    for (const char* name :
         {"--size", "--position", "--rotation-deg", "--spacing", "--sampling", "--pressure"})
        app.get_option("--points-file")->excludes(name);
    addProbeOptions(app, arguments);
    addToleranceOptions(app, arguments);
    app.add_flag("--certify",
                 arguments.certify,
                 "Print how far this field is from a lower bound for all possible phases");
    app.add_option("--out",
                   arguments.out,
                   "Output folder for control_points.csv, drive.csv (or drive_01.csv ..), "
                   "summary.json, field.png and exposure.csv")
        ->capture_default_str();
}

void addToleranceOptions(CLI::App& app, SolveArguments& arguments)
{
    auto* study = app.add_flag("--tolerance",
                               arguments.hasTolerance,
                               "Compute the effect of errors of the array and the air on the field "
                               "(Monte Carlo): tolerance.csv and tolerance.png");
    haptics::ToleranceOptions& options = arguments.tolerance;
    const auto addValues =
        [&](const char* name, std::vector<double>& values, const char* unit, const char* what)
    {
        app.add_option(name, values, what)
            ->transform(inUnit(unit, base::parseQuantity))
            ->delimiter(',')
            ->needs(study)
            ->capture_default_str();
    };
    addValues("--tolerance-position",
              options.position_m,
              "m",
              "Displacements of whole boards, rms in each of x, y and z, metres");
    addValues("--tolerance-tilt",
              options.tilt_deg,
              "deg",
              "Rotations of boards about their centres, rms about each of x, y and z, degrees");
    addValues("--tolerance-phase", options.phase_deg, "deg", "Phase errors, rms, degrees");
    addValues(
        "--tolerance-temperature", options.temperature_K, "", "Temperature rise of the air, K");
    addValues("--tolerance-dead", options.dead, "", "Share of dead transducers");
    app.add_option("--tolerance-draws", options.draws, "Random arrays for each of these values")
        ->check(CLI::Range(1, 10000))
        ->needs(study)
        ->capture_default_str();
    app.add_option("--tolerance-seed", options.seed, "Random seed")
        ->needs(study)
        ->capture_default_str();
}

void writeTolerance(const std::string& path, const haptics::ToleranceStudy& study)
{
    TextFile file(path);
    file.stream() << "deviation,value,unit,draws,rms,rms_p90,loudness,loudness_p10,focus,focus_p10,"
                     "expected_rms,expected_focus\n"
                  << lineOf(study.nominal, "nominal", "");
    for (const haptics::ToleranceRow& row : study.rows)
        file.stream() << lineOf(
            row, haptics::deviationName(row.deviation), haptics::deviationUnit(row.deviation));
    file.finish();
}

void printTolerance(const haptics::ToleranceStudy& study)
{
    std::printf(
        "tolerance   %d arrays simulated in %.1f s of processor time; medians of %d per value:\n",
        study.arrays,
        study.cpu_s,
        study.draws);
    printLine("nominal", study.nominal);
    const auto shownValue = [](const haptics::ToleranceRow& row)
    {
        using haptics::Deviation;
        const std::string name = haptics::deviationName(row.deviation);
        if (row.deviation == Deviation::POSITION)
            return fmt::format("{} {:g} mm", name, 1e3 * row.value);
        if (row.deviation == Deviation::DEAD)
            return fmt::format("{} {:g} %", name, 100.0 * row.value);
        return fmt::format("{} {:g} {}", name, row.value, haptics::deviationUnit(row.deviation));
    };
    for (const haptics::ToleranceRow& row : study.rows)
        printLine(shownValue(row), row);
}

} // namespace midair::samples
