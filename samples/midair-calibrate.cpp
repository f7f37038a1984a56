// Computes the rigid matrix from a scene's world to the array from points measured in both, and
// reports its accuracy.

#include "engine-bridge/calibration/Calibration.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"

#include <osgMidair/HapticScene>

#include <osg/NodeVisitor>
#include <osgDB/ReadFile>
#include <osgDB/Registry>
#include <osgDB/WriteFile>

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <locale>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

using namespace midair;

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

constexpr std::size_t kMostBytes = std::size_t(16) << 20;

/// Reads standard input up to the size limit, as a pipe may have no end.
bridge::PointPairs readPairsFromStdin()
{
    std::string text(kMostBytes + 1, '\0');
    std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > kMostBytes)
        throw base::InputError("stdin has over 16 MiB, should have at most as much");
    std::istringstream in(text);
    return bridge::readPointPairs(in, "stdin");
}

bridge::PointPairs readPairs(const std::string& path)
{
    if (path == "-") return readPairsFromStdin();
    try
    {
        std::istringstream in(base::readRegularFile(path, kMostBytes));
        return bridge::readPointPairs(in, path);
    }
    catch (const base::FileError& error)
    {
        throw base::InputError("point pairs \"" + path + "\": " + error.what() +
                               "; give a file of point pairs, or - for stdin");
    }
}

void printResiduals(const bridge::CalibrationReport& report)
{
    std::cout << std::fixed << std::setprecision(2);
    for (std::size_t k = 0; k < report.outlier.size(); ++k)
        std::cout << "pair " << std::setw(3) << k + 1 << std::setw(9)
                  << 1e3 * report.residuals_m[static_cast<Eigen::Index>(k)] << " mm"
                  << (report.outlier[k] ? "  left out\n" : "\n");
}

void writeMatrix(const std::string& path, const Eigen::Isometry3d& worldToArray)
{
    std::ofstream out(path);
    out.imbue(std::locale::classic());
    out << "# array = M world, column vectors, metres\n"
        << std::setprecision(17) << worldToArray.matrix() << "\n";
    out.flush();
    if (!out) throw base::InputError("can't write the matrix to \"" + path + "\"");
}

/// Sets the calibration of every HapticScene that it visits.
class SetCalibration : public osg::NodeVisitor
{
public:
    explicit SetCalibration(const Eigen::Isometry3d& worldToArray) :
        osg::NodeVisitor(TRAVERSE_ALL_CHILDREN),
        _matrix(bridge::toOsg(worldToArray.matrix()))
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

/// The kit's plugins are in lib next to this program's bin, in a build and after installation.
void findKit()
{
    std::error_code error;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    if (!error)
        osgDB::Registry::instance()->getLibraryFilePathList().push_front(
            (self.parent_path().parent_path() / "lib").string());
}

void writeScene(const std::string& from,
                const std::string& to,
                const Eigen::Isometry3d& worldToArray)
{
    findKit();
    const osg::ref_ptr<osg::Node> scene = osgDB::readRefNodeFile(from);
    if (!scene) throw base::InputError("can't read the scene \"" + from + "\"");
    SetCalibration set(worldToArray);
    scene->accept(set);
    if (set.scenes == 0)
        throw base::InputError("there is no osgMidair::HapticScene in \"" + from +
                               "\" to hold a calibration");
    if (!osgDB::writeNodeFile(*scene, to))
        throw base::InputError("can't write the scene to \"" + to + "\"");
    std::cout << "calibration written into " << set.scenes << " HapticScene of " << to << "\n";
}

int calibrate(const Settings& settings)
{
    const double worldUnit_m = bridge::unitInMetres(settings.worldUnit);
    const double arrayUnit_m = bridge::unitInMetres(settings.arrayUnit);
    bridge::PointPairs pairs = readPairs(settings.pairs);
    pairs.world *= worldUnit_m;
    pairs.array *= arrayUnit_m;
    bridge::CalibrationOptions options;
    options.edge_m = 1e-3 * settings.edge_mm;
    const bridge::CalibrationReport report = bridge::calibrate(pairs, options);
    if (report.usable) printResiduals(report);
    std::cout << report.text();
    if (!report.usable) return NOT_USABLE;
    if (!settings.matrix.empty()) writeMatrix(settings.matrix, report.worldToArray);
    if (!settings.sceneIn.empty())
        writeScene(settings.sceneIn,
                   settings.sceneOut.empty() ? settings.sceneIn : settings.sceneOut,
                   report.worldToArray);
    return CALIBRATED;
}

} // namespace

int main(int argc, char** argv)
{
    Settings settings;
    CLI::App app("midair-calibrate: from point pairs to the matrix from world to array.\n"
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
    app.add_option("--matrix", settings.matrix, "write the matrix to this file");
    const auto scene =
        app.add_option("--scene", settings.sceneIn, "set the calibration in this scene file");
    app.add_option("--out", settings.sceneOut, "and write it here instead of over it")
        ->needs(scene);
    CLI11_PARSE(app, argc, argv);
    try
    {
        return calibrate(settings);
    }
    catch (const base::InputError& error)
    {
        std::cerr << "midair-calibrate: " << error.what() << "\n";
        return WRONG_INPUT;
    }
}
