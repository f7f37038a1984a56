// Computes the rigid matrix from a scene's world to the array from points measured in both, and
// reports its accuracy; with --boards, finds where an array's boards are.
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/boards/BoardFit.h"
#include "samples/shared/CalibrationFiles.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"

#include <osgMidair/Calibration>

#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// Options of midair-calibrate --boards.
struct BoardSettings
{
    bool isAsked = false;
    std::string array = "octagon"; ///< nominal array: a name or a file
    std::string measurements;      ///< file, or - for stdin; empty: print the plan
    std::string out;               ///< array file to write; empty: none
    std::string plan;              ///< file for the plan; empty: stdout
    haptics::BoardPlanOptions distances;
    double temperature_C = 20.0; ///< of the air, for times of flight
};

using base::InputError;

constexpr std::size_t kMostBytes = std::size_t(16) << 20U;

std::string readAll(const std::string& file)
{
    if (file != "-")
        return base::readRegularFile(file, kMostBytes, "measurements \"" + file + "\": ");
    std::string text(kMostBytes + 1, '\0');
    std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > kMostBytes)
        throw InputError("stdin has over 16 MiB, should have at most as much");
    return text;
}

// Returns a template to fill in, with the nominal distance of each line in a comment.
std::string textOf(const haptics::BoardPlan& plan, const haptics::TransducerArray& array)
{
    std::string text =
        fmt::format("# {} distances between corners of the boards of \"{}\", from the centre of "
                    "one transducer to the centre of the other.\n"
                    "# N:a is the transducer of board N at its first column and row, b at the last "
                    "column of that row, c opposite a, d opposite b.\n"
                    "# Replace each ? with the measured distance, as 0.1512, 151.2mm or 5.95in. "
                    "Delete lines that you can't measure.\n",
                    plan.distances.size(),
                    array.name);
    for (const haptics::PlannedDistance& one : plan.distances)
        text += fmt::format("{} {} ?   # transducers {} and {}, about {:.1f} mm\n",
                            one.from,
                            one.to,
                            one.fromTransducer,
                            one.toTransducer,
                            1e3 * one.distance_m);
    return text;
}

int printPlan(const BoardSettings& settings, const haptics::TransducerArray& array)
{
    const haptics::BoardPlan plan = haptics::planBoards(array, settings.distances);
    const std::string text = textOf(plan, array);
    if (settings.plan.empty())
        std::fputs(text.c_str(), stdout);
    else
    {
        std::ofstream file(settings.plan);
        file << text;
        file.close();
        if (!file) throw InputError("can't write the plan to \"" + settings.plan + "\"");
    }
    for (const std::string& problem : plan.problems)
        std::fprintf(stderr, "midair-calibrate: %s\n", problem.c_str());
    if (!plan.problems.empty())
    {
        std::fprintf(stderr,
                     "midair-calibrate: these distances are not enough. Allow longer ones "
                     "(--longest) or more of them (--count), or measure the boards to a place off "
                     "to the side: \"place hook about x y z\"\n");
        return EXIT_PROBLEM;
    }
    std::fprintf(stderr,
                 "midair-calibrate: with an error of %.2f mm per distance, all boards are known to "
                 "%.2f mm\n",
                 1e3 * settings.distances.sigma_m,
                 1e3 * plan.uncertain_m);
    return EXIT_DONE;
}

void printReport(const haptics::BoardFitReport& report,
                 const haptics::BoardMeasurements& measurements)
{
    for (std::size_t k = 0; k < measurements.all.size(); ++k)
        if (report.residuals_m.size() > 0)
            std::printf("%-24s %+8.2f mm%s\n",
                        measurements.all[k].name().c_str(),
                        1e3 * report.residuals_m[static_cast<Eigen::Index>(k)],
                        report.leftOut[k] ? "  left out" : "");
    for (const haptics::BoardPose& board : report.boards)
        std::printf("board %3d  moved %6.2f mm, turned %5.2f degrees; known to %.2f mm, %.2f "
                    "degrees, from %d measurements\n",
                    board.board,
                    1e3 * board.moved_m,
                    board.turned_deg,
                    1e3 * board.uncertain_m,
                    board.uncertain_deg,
                    board.measurements);
    for (const haptics::MeasuredPlace& place : report.places)
        std::printf("place %s is at (%.4f, %.4f, %.4f) m\n",
                    place.name.c_str(),
                    place.position.x(),
                    place.position.y(),
                    place.position.z());
    if (report.delay_s != 0.0) std::printf("times have a delay of %.1f us\n", 1e6 * report.delay_s);
    std::printf("noise: %.2f mm per measurement\n", 1e3 * report.noise_m);
    for (const std::string& note : report.notes)
        std::printf("note: %s\n", note.c_str());
    for (const std::string& problem : report.problems)
        std::printf("not usable: %s\n", problem.c_str());
}

/// Prints the plan, or fits the boards to the measurements, prints the result and writes the
/// array's file. Returns 0, or 1 if the measurements are not usable; then it prints the reasons and
/// writes nothing. Throws midair::base::InputError.
int calibrateBoards(const BoardSettings& settings)
{
    const haptics::TransducerArray array = haptics::TransducerArray::load(settings.array);
    if (settings.measurements.empty()) return printPlan(settings, array);
    const haptics::BoardMeasurements measurements = haptics::readBoardMeasurements(
        readAll(settings.measurements),
        settings.measurements == "-" ? "stdin" : settings.measurements,
        array);
    if (measurements.all.empty()) throw InputError("there are no measurements");
    haptics::Medium medium;
    medium.temperature_C = settings.temperature_C;
    std::string error;
    if (!medium.isValid(&error)) throw InputError(error);
    haptics::BoardFitOptions options;
    options.sigma_m = settings.distances.sigma_m;
    options.mostUncertain_m = 5.0 * settings.distances.sigma_m;
    options.soundSpeed_m_s = medium.soundSpeed();
    const haptics::BoardFitReport report = haptics::fitBoards(array, measurements, options);
    printReport(report, measurements);
    if (!report.usable) return EXIT_PROBLEM;
    if (settings.out.empty()) return EXIT_DONE;
    report.array.save(settings.out);
    std::printf("array written to %s\n", settings.out.c_str());
    return EXIT_DONE;
}

struct Settings
{
    std::string pairs = "-";
    std::string worldUnit = "m";
    std::string arrayUnit = "m";
    std::string matrix;
    std::string sceneIn;
    std::string sceneOut;
    double edge_mm = 150.0;
};

double unitInMetres(const std::string& unit)
{
    std::string error;
    const double metres = osgMidair::unitInMetres(unit, error);
    if (!error.empty()) throw InputError(error);
    return metres;
}

void printResiduals(const osgMidair::CalibrationReport& report)
{
    std::cout << std::fixed << std::setprecision(2);
    for (std::size_t k = 0; k < report.outlier.size(); ++k)
        std::cout << "pair " << std::setw(3) << k + 1 << std::setw(9) << 1e3 * report.residuals_m[k]
                  << " mm" << (report.outlier[k] ? "  left out\n" : "\n");
}

int calibrate(const Settings& settings)
{
    const double worldUnit_m = unitInMetres(settings.worldUnit);
    const double arrayUnit_m = unitInMetres(settings.arrayUnit);
    osgMidair::PointPairs pairs;
    std::string error;
    if (!osgMidair::readPointPairs(settings.pairs, pairs, error)) throw InputError(error);
    for (osg::Vec3d& spot : pairs.world)
        spot *= worldUnit_m;
    for (osg::Vec3d& spot : pairs.array)
        spot *= arrayUnit_m;
    osgMidair::CalibrationOptions options;
    options.edge_m = 1e-3 * settings.edge_mm;
    const osgMidair::CalibrationReport report =
        osgMidair::calibrate(pairs.world, pairs.array, options);
    if (report.has(osgMidair::CalibrationWarning::WRONG_INPUT))
        throw InputError(report.warnings.front().text);
    if (report.usable) printResiduals(report);
    std::cout << report.text;
    if (!report.usable) return EXIT_PROBLEM;
    if (!settings.matrix.empty()) writeMatrix(settings.matrix, report.worldToArray);
    if (!settings.sceneIn.empty())
        writeScene(settings.sceneIn,
                   settings.sceneOut.empty() ? settings.sceneIn : settings.sceneOut,
                   report.worldToArray);
    return EXIT_DONE;
}

void addBoardOptions(CLI::App& app, BoardSettings& boards)
{
    using base::parseQuantity;
    auto* asked = app.add_flag(
        "--boards",
        boards.isAsked,
        "find where the boards of an array are; without --measurements, print what to measure");
    const auto add = [&](const char* name, auto& value, const char* what)
    { return app.add_option(name, value, what)->needs(asked)->capture_default_str(); };
    add("--array", boards.array, "the nominal array: a name or a file");
    add("--measurements",
        boards.measurements,
        "file of distances and times, or - for stdin: lines such as \"0:a 1:b 151.2mm\"");
    add("--array-out", boards.out, "write the array with the measured boards to this file");
    add("--plan", boards.plan, "write what to measure to this file");
    add("--longest", boards.distances.longest_m, "longest distance that can be measured, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--sigma", boards.distances.sigma_m, "standard deviation of a distance, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--count",
        boards.distances.count,
        "distances to measure; 0: one and a half for each unknown")
        ->check(CLI::Range(0, 10000));
    add("--temperature", boards.temperature_C, "temperature of the air, C, for times")
        ->transform(inUnit("C", parseQuantity));
}

int run(int argc, char** argv)
{
    Settings settings;
    BoardSettings boards;
    CLI::App app("Computes the matrix from the world to the array from pairs of points; with "
                 "--boards, the places of an array's boards from distances.\n"
                 "Example: midair-calibrate pairs.csv --unit cm --scene room.osgt\n"
                 "Each line of pairs.csv is one spot measured twice: world x, y, z, array x, y, z. "
                 "Take 12 or more spots that are not in one plane.");
    app.add_option("pairs", settings.pairs, "file of point pairs, or - for stdin")
        ->capture_default_str();
    app.add_option("--unit",
                   settings.worldUnit,
                   "unit of the world points: m, cm, mm, in, ft, or its length in metres")
        ->capture_default_str();
    app.add_option("--array-unit", settings.arrayUnit, "unit of the array points")
        ->capture_default_str();
    app.add_option("--edge",
                   settings.edge_mm,
                   "distance from the array's origin to the edge of the workspace, mm")
        ->capture_default_str();
    app.add_option(
        "--matrix", settings.matrix, "write the matrix to this file, row by row as in OSG");
    const auto scene =
        app.add_option("--scene", settings.sceneIn, "set the calibration in this scene file");
    app.add_option("--out", settings.sceneOut, "write the scene to this file instead")
        ->needs(scene);
    addBoardOptions(app, boards);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    return boards.isAsked ? calibrateBoards(boards) : calibrate(settings);
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-calibrate: %s\n", error.what());
        return EXIT_WRONG;
    }
}
