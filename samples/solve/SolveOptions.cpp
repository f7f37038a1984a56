#include "samples/solve/SolveOptions.h"

#include "haptics/base/Limits.h"
#include "haptics/solvers/HologramSolver.h"

#include <map>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

void addOptions(CLI::App& app, SolveArguments& arguments)
{
    static const std::map<std::string, haptics::Sampling> kSamplings{
        {"surface", haptics::Sampling::SURFACE},
        {"edges", haptics::Sampling::EDGES},
        {"vertices", haptics::Sampling::VERTICES}};
    const std::string solvers = fmt::format("{}", fmt::join(haptics::solverNames(), ", "));

    auto* model = app.add_option("MODEL", arguments.model, "Wavefront OBJ file");
    app.add_option("--points-file",
                   arguments.pointsFile,
                   "CSV instead of a model: x_m,y_m,z_m,nx,ny,nz and target_Pa (absolute) or "
                   "target (relative)")
        ->excludes(model);
    app.add_option("--size",
                   arguments.size_m,
                   "Largest extent of the model in metres (default: as in the file)")
        ->check(CLI::PositiveNumber);
    app.add_option("--position", arguments.position, "Where the model's centre goes, metres")
        ->expected(3);
    app.add_option("--rotation-deg",
                   arguments.rotation_deg,
                   "Rotation about x, then y, then z of the array frame")
        ->expected(3);
    app.add_option(
           "--array", arguments.array, "octagon, board, a shipped array's name, or FILE.json")
        ->capture_default_str();
    app.add_option("--spacing",
                   arguments.spacing_m,
                   "Between control points, metres (default: one wavelength)")
        ->check(CLI::PositiveNumber);
    app.add_option(
           "--sampling", arguments.sampling, "surface, edges or vertices (default: surface)")
        ->transform(CLI::CheckedTransformer(kSamplings).description(""));
    app.add_option("--pressure",
                   arguments.pressure_Pa,
                   "Peak pressure at every point in Pa (default: as loud as it accurately can)")
        ->check(CLI::PositiveNumber);
    app.add_option("--max-pressure",
                   arguments.maxPressure_Pa,
                   "Peak Pa that no point gets more than: the drive is scaled down to that "
                   "(default: no cap)")
        ->check(CLI::Range(1.0, base::kMostPressure_Pa));
    static const std::map<std::string, haptics::Crowding> kCrowdings{
        {"thin", haptics::Crowding::THIN},
        {"merge", haptics::Crowding::MERGE},
        {"drop", haptics::Crowding::DROP}};
    app.add_option(
           "--crowding",
           arguments.crowding,
           "thin, merge or drop what is nearer than a third of a wavelength (default: thin)")
        ->transform(CLI::CheckedTransformer(kCrowdings).description(""));
    app.add_option("--loudness",
                   arguments.loudness,
                   "1: as loud as it accurately can; below: quieter; above: louder, less accurate")
        ->check(CLI::Range(0.01, base::kMostLoudness))
        ->capture_default_str();
    app.add_option("--solver", arguments.solver, "One of " + solvers + " (default: the first)");
    app.add_option(
           "--temperature", arguments.temperature_C, "Of the air, degrees Celsius, -40 to 60")
        ->capture_default_str();
    app.add_option(
        "--directivity", arguments.directivity, "t4010a1-harmonics, t4010a1-table or point");
    app.add_option(
           "--cycle",
           arguments.cycle,
           "Fields in turn, each for its own shifted points on the same surface; each gets a "
           "drive_NN.csv")
        ->check(CLI::Range(1, base::kMostCycle))
        ->excludes("--points-file");
    app.add_option("--cycle-steps", arguments.cycleSteps, "Between one of them and the next")
        ->check(CLI::Range(0, base::kMostCycleSteps))
        ->needs("--cycle");
    app.add_option("--even",
                   arguments.sweeps,
                   "Sweeps in which the fields of a cycle are evened out together; takes seconds")
        ->check(CLI::Range(0, 100))
        ->needs("--cycle");
    app.add_option("--subsets", arguments.subsets, "Of the points, in turn: harder, less often")
        ->check(CLI::Range(1, base::kMostSubsets));
    app.add_option("--field-rate", arguments.fieldRate_Hz, "Fields a second where they take turns")
        ->check(CLI::Range(1.0, base::kMostFieldRate_Hz))
        ->capture_default_str();
    app.add_flag(
           "--outline",
           arguments.outline,
           "The model's edges in one stationary field of dense points, nearly without ripples")
        ->excludes("--points-file", "--cycle", "--subsets", "--solver");
    app.add_flag(
        "--certify",
        arguments.certify,
        "Bound from below what any phases could reach, and tell how far this field is from it");
    app.add_option(
           "--out",
           arguments.out,
           "Folder for control_points.csv, drive.csv (or drive_01.csv ..), summary.json and "
           "field.png")
        ->capture_default_str();
}

} // namespace midair::samples
