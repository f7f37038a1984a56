// Computes the rigid matrix from a scene's world to the array from points measured in both, and
// reports its accuracy; or finds where an array's boards are.
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/boards/BoardFit.h"
#include "samples/shared/ScenesBelow.h"
#include "samples/shared/SettingOptions.h"

#include <osgMidair/Calibration>
#include <osgMidair/FileFormats>
#include <osgMidair/HapticScene>

#include <osgDB/WriteFile>

#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <locale>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// What midair-calibrate --boards is asked for.
struct BoardSettings
{
    bool isAsked = false;
    std::string array = "octagon"; ///< as it was meant: a name or a file
    std::string measurements;      ///< file, or - for stdin; empty: what to measure is printed
    std::string out;               ///< array file to write; empty: none
    std::string plan;              ///< file to write what to measure into; empty: stdout
    haptics::BoardPlanOptions distances;
    double temperature_C = 20.0; ///< for times
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

// A template to fill in: each distance as it should be, behind a comment sign.
std::string textOf(const haptics::BoardPlan& plan, const haptics::TransducerArray& array)
{
    std::string text = fmt::format(
        "# {} distances between corners of the boards of \"{}\", from the middle of a transducer "
        "to "
        "the middle of the other.\n"
        "# N:a is the transducer of board N at its first column and row, b at the last column of "
        "that row, c opposite a, d opposite b.\n"
        "# Write what you measure in place of the ?, as 0.1512, 151.2mm or 5.95in; a line that you "
        "can't measure you leave out.\n",
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
        std::fprintf(
            stderr,
            "midair-calibrate: these distances are not enough: a longer tape "
            "(--longest), more of them (--count), or a place off to the side, \"place hook "
            "about x y z\", that the boards are measured to\n");
        return 1;
    }
    std::fprintf(stderr,
                 "midair-calibrate: with %.2f mm a distance all boards are known to %.2f mm\n",
                 1e3 * settings.distances.sigma_m,
                 1e3 * plan.uncertain_m);
    return 0;
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
    std::printf("noise: %.2f mm a measurement\n", 1e3 * report.noise_m);
    for (const std::string& note : report.notes)
        std::printf("note: %s\n", note.c_str());
    for (const std::string& problem : report.problems)
        std::printf("not usable: %s\n", problem.c_str());
}

/// Prints what to measure, or finds the boards from what was measured, prints where they are and
/// writes the array's file. Returns 0, or 1 if the measurements are of no use: the reasons are
/// printed and nothing is written. Throws midair::base::InputError.
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
    if (!report.usable) return 1;
    if (settings.out.empty()) return 0;
    report.array.save(settings.out);
    std::printf("array written to %s\n", settings.out.c_str());
    return 0;
}

enum ExitCode
{
    CALIBRATED = 0,
    NOT_USABLE = 1, ///< the report gives the reason; nothing was written
    WRONG_INPUT = 2
};

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

void writeMatrix(const std::string& path, const osg::Matrixd& worldToArray)
{
    std::ofstream out(path);
    out.imbue(std::locale::classic());
    out << "# the rows of an osg::Matrixd, as Calibration has them: array = world * M, metres\n"
        << std::setprecision(17);
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            out << worldToArray(row, column) << (column < 3 ? " " : "\n");
    out.flush();
    if (!out) throw InputError("can't write the matrix to \"" + path + "\"");
}

void writeScene(const std::string& from, const std::string& to, const osg::Matrixd& worldToArray)
{
    const osg::ref_ptr<osg::Node> scene = osgMidair::readModel(from).getNode();
    if (!scene) throw InputError("can't read the scene \"" + from + "\"");
    const std::vector<osgMidair::HapticScene*> found = scenesBelow(*scene, false);
    for (osgMidair::HapticScene* one : found)
        one->setCalibration(worldToArray);
    if (found.empty())
        throw InputError("there is no osgMidair::HapticScene in \"" + from +
                         "\" to hold a calibration");
    if (!osgDB::writeNodeFile(*scene, to))
        throw InputError("can't write the scene to \"" + to + "\"");
    std::cout << "calibration written into " << found.size() << " HapticScene of " << to << "\n";
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
    if (!report.usable) return NOT_USABLE;
    if (!settings.matrix.empty()) writeMatrix(settings.matrix, report.worldToArray);
    if (!settings.sceneIn.empty())
        writeScene(settings.sceneIn,
                   settings.sceneOut.empty() ? settings.sceneIn : settings.sceneOut,
                   report.worldToArray);
    return CALIBRATED;
}

void addBoardOptions(CLI::App& app, BoardSettings& boards)
{
    using base::parseQuantity;
    auto* asked = app.add_flag("--boards",
                               boards.isAsked,
                               "find where the boards of an array are; without --measurements: "
                               "print what to measure");
    const auto add = [&](const char* name, auto& value, const char* what)
    { return app.add_option(name, value, what)->needs(asked)->capture_default_str(); };
    add("--array", boards.array, "the array as it was meant: a name or a file");
    add("--measurements",
        boards.measurements,
        "file of distances and times, or - for stdin: lines such as \"0:a 1:b 151.2mm\"");
    add("--array-out", boards.out, "write the array with its boards where they are to this file");
    add("--plan", boards.plan, "write what to measure to this file");
    add("--longest", boards.distances.longest_m, "longest distance that can be measured, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--sigma", boards.distances.sigma_m, "standard deviation of a distance, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--count",
        boards.distances.count,
        "distances to measure; 0: one and a half for each unknown")
        ->check(CLI::Range(0, 10000));
    add("--temperature", boards.temperature_C, "of the air, C, for times")
        ->transform(inUnit("C", parseQuantity));
}

int run(int argc, char** argv)
{
    Settings settings;
    BoardSettings boards;
    CLI::App app(
        "midair-calibrate: from point pairs to the matrix from world to array; with --boards from "
        "distances to where an array's boards are.\n"
        "A line is one spot measured twice: world x, y, z, array x, y, z. Take 12 or "
        "more, not in one plane.");
    app.add_option("pairs", settings.pairs, "file of point pairs, or - for stdin")
        ->capture_default_str();
    app.add_option("--unit",
                   settings.worldUnit,
                   "unit of the world points: m, cm, mm, in, ft, or how many metres it has")
        ->capture_default_str();
    app.add_option("--array-unit", settings.arrayUnit, "unit of the array points")
        ->capture_default_str();
    app.add_option("--edge", settings.edge_mm, "mm from the array's origin to the workspace's edge")
        ->capture_default_str();
    app.add_option(
        "--matrix", settings.matrix, "write the matrix to this file, row by row as OSG does");
    const auto scene =
        app.add_option("--scene", settings.sceneIn, "set the calibration in this scene file");
    app.add_option("--out", settings.sceneOut, "and write it here instead of over it")
        ->needs(scene);
    addBoardOptions(app, boards);
    CLI11_PARSE(app, argc, argv);
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
        return WRONG_INPUT;
    }
}
