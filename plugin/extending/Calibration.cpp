#include "engine-bridge/calibration/Calibration.h"

#include "engine-bridge/scene/Convert.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "plugin/extending/ArrayConversion.h"

#include <osgMidair/Calibration>

#include <algorithm>
#include <iostream>
#include <sstream>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

Eigen::Matrix3Xd columns(const std::vector<osg::Vec3d>& points)
{
    Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        all.col(static_cast<Eigen::Index>(i)) = midair::bridge::toEigen(points[i]);
    return all;
}

/// The kinds are in the same order, after WRONG_INPUT, which the bridge throws.
CalibrationWarning::Problem problemOf(midair::bridge::CalibrationProblem problem)
{
    using Problem = midair::bridge::CalibrationProblem;
    constexpr auto same = [](Problem one)
    { return static_cast<CalibrationWarning::Problem>(static_cast<int>(one) + 1); };
    static_assert(same(Problem::TOO_FEW_POINTS) == CalibrationWarning::TOO_FEW_POINTS);
    static_assert(same(Problem::WRONG_UNIT) == CalibrationWarning::WRONG_UNIT);
    static_assert(same(Problem::OUTLIERS) == CalibrationWarning::OUTLIERS);
    return same(problem);
}

constexpr std::size_t kMostBytes = std::size_t(16) << 20;

/// Reads standard input up to the size limit, because a pipe may be endless.
midair::bridge::PointPairs pairsOfStdin()
{
    std::string text(kMostBytes + 1, '\0');
    std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > kMostBytes)
        throw midair::base::InputError("stdin has over 16 MiB, should have at most as much");
    std::istringstream in(text);
    return midair::bridge::readPointPairs(in, "stdin");
}

midair::bridge::PointPairs pairsOf(const std::string& file)
{
    try
    {
        std::istringstream in(midair::base::readRegularFile(file, kMostBytes));
        return midair::bridge::readPointPairs(in, file);
    }
    catch (const midair::base::FileError& error)
    {
        throw midair::base::InputError("point pairs \"" + file + "\": " + error.what() +
                                       "; give a file of point pairs, or - for stdin");
    }
}

CalibrationReport refused(const std::string& why)
{
    CalibrationReport report;
    report.warnings.push_back({CalibrationWarning::WRONG_INPUT, why});
    report.text = why + "\n";
    return report;
}

} // namespace

bool readPointPairs(const std::string& file, PointPairs& pairs, std::string& error)
{
    midair::bridge::PointPairs read;
    if (!succeeds([&] { read = file == "-" ? pairsOfStdin() : pairsOf(file); }, error))
        return false;
    pairs.world.clear();
    pairs.array.clear();
    for (int k = 0; k < read.size(); ++k)
    {
        pairs.world.push_back(midair::bridge::toOsg(Eigen::Vector3d(read.world.col(k))));
        pairs.array.push_back(midair::bridge::toOsg(Eigen::Vector3d(read.array.col(k))));
    }
    return true;
}

double unitInMetres(const std::string& nameOrNumber, std::string& error)
{
    double metres = 0.0;
    succeeds([&] { metres = midair::bridge::unitInMetres(nameOrNumber); }, error);
    return metres;
}

bool CalibrationReport::has(CalibrationWarning::Problem problem) const
{
    return std::any_of(warnings.begin(),
                       warnings.end(),
                       [problem](const CalibrationWarning& one) { return one.problem == problem; });
}

CalibrationReport calibrate(const std::vector<osg::Vec3d>& world,
                            const std::vector<osg::Vec3d>& array,
                            const CalibrationOptions& options)
{
    if (world.size() != array.size())
        return refused(fmt::format("there are {} points in the world and {} in the array; there "
                                   "must be as many of each",
                                   world.size(),
                                   array.size()));
    midair::bridge::CalibrationReport found;
    midair::bridge::CalibrationOptions given;
    given.edge_m = options.edge_m;
    given.outlierSigmas = options.outlierSigmas;
    given.scaleTolerance = options.scaleTolerance;
    given.trials = options.trials;
    given.seed = options.seed;
    std::string error;
    if (!succeeds(
            [&] {
                found = midair::bridge::calibrate({columns(world), columns(array)}, given);
            },
            error))
        return refused(error);
    CalibrationReport report;
    report.usable = found.usable;
    if (found.usable) report.worldToArray = midair::bridge::toOsg(found.worldToArray.matrix());
    report.residuals_m.assign(found.residuals_m.data(),
                              found.residuals_m.data() + found.residuals_m.size());
    report.outlier = found.outlier;
    report.rms_m = found.rms_m;
    report.noise_m = found.noise_m;
    report.scale = found.scale;
    report.scaleError = found.scaleError;
    report.edgeErrorMedian_m = found.edgeErrorMedian_m;
    report.edgeError95_m = found.edgeError95_m;
    for (const midair::bridge::CalibrationWarning& warning : found.warnings)
        report.warnings.push_back({problemOf(warning.problem), warning.text});
    report.text = found.text();
    return report;
}

} // namespace osgMidair
