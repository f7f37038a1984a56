// Computes the rigid matrix from a scene's world to the array from points measured in both, and
// reports its accuracy; or finds where an array's boards are.

#include "haptics/base/InputError.h"
#include "haptics/base/text/Quantity.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/calibrate/BoardCalibration.h"

#include <osgMidair/Calibration>
#include <osgMidair/FileFormats>
#include <osgMidair/HapticScene>

#include <osg/NodeVisitor>
#include <osgDB/WriteFile>

#include <fstream>
#include <iomanip>
#include <iostream>
#include <locale>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

namespace
{

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

/// Wrong input; what() says what would be right.
class InputError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
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

/// Sets the calibration of every HapticScene that it visits.
class SetCalibration : public osg::NodeVisitor
{
public:
    explicit SetCalibration(const osg::Matrixd& worldToArray) :
        osg::NodeVisitor(TRAVERSE_ALL_CHILDREN),
        _matrix(worldToArray)
    {
    }

    void apply(osg::Group& group) override
    {
        if (auto* scene = dynamic_cast<osgMidair::HapticScene*>(&group))
        {
            scene->setCalibration(_matrix);
            ++scenes;
        }
        traverse(group);
    }

    int scenes = 0;

private:
    osg::Matrixd _matrix;
};

void writeScene(const std::string& from, const std::string& to, const osg::Matrixd& worldToArray)
{
    const osg::ref_ptr<osg::Node> scene = osgMidair::readModel(from).getNode();
    if (!scene) throw InputError("can't read the scene \"" + from + "\"");
    SetCalibration set(worldToArray);
    scene->accept(set);
    if (set.scenes == 0)
        throw InputError("there is no osgMidair::HapticScene in \"" + from +
                         "\" to hold a calibration");
    if (!osgDB::writeNodeFile(*scene, to))
        throw InputError("can't write the scene to \"" + to + "\"");
    std::cout << "calibration written into " << set.scenes << " HapticScene of " << to << "\n";
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

void addBoardOptions(CLI::App& app, midair::samples::BoardSettings& boards)
{
    using midair::base::parseQuantity;
    using midair::samples::inUnit;
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
    add("--longest", boards.longest_m, "longest distance that can be measured, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--sigma", boards.sigma_m, "standard deviation of a distance, metres")
        ->transform(inUnit("m", parseQuantity));
    add("--count", boards.count, "distances to measure; 0: one and a half for each unknown")
        ->check(CLI::Range(0, 10000));
    add("--temperature", boards.temperature_C, "of the air, C, for times")
        ->transform(inUnit("C", parseQuantity));
}

} // namespace

int main(int argc, char** argv)
{
    Settings settings;
    midair::samples::BoardSettings boards;
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
    try
    {
        return boards.isAsked ? midair::samples::calibrateBoards(boards) : calibrate(settings);
    }
    catch (const midair::base::InputError& error)
    {
        std::cerr << "midair-calibrate: " << error.what() << "\n";
        return WRONG_INPUT;
    }
    catch (const InputError& error)
    {
        std::cerr << "midair-calibrate: " << error.what() << "\n";
        return WRONG_INPUT;
    }
}
