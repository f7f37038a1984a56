#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::samples
{

/// The two experiments of the paper: from which angle on a line is felt as oblique, and from which
/// distance on as shifted.
enum class LineKind
{
    OBLIQUE, ///< turned about its middle in the cross-section xz
    SHIFTED  ///< moved along z, across itself
};

/// What is asked, in what range, and what the paper found.
struct LineExperiment
{
    LineKind kind = LineKind::OBLIQUE;
    std::string name;            ///< "oblique", "shifted"; in files and on the command line
    std::string title;           ///< of plots
    std::string question;        ///< that is answered by yes or no
    std::string quantity;        ///< what values are: "angle", "shift"
    std::string unit;            ///< of values: "deg", "mm"
    double maximum = 0.0;        ///< where staircases begin
    double step = 0.0;           ///< by which they go, unless told otherwise; a part of maximum
    double paperMean = 0.0;      ///< threshold, mean over the paper's participants
    double paperDeviation = 0.0; ///< its standard deviation over them

    /// Returns the five control points, 8.5 mm apart, of the line that is turned or shifted by \a
    /// value: 3 x 5, metres, array frame. At 0 it lies along x through the centre.
    Eigen::Matrix3Xd points(double value) const;
};

/// Returns both experiments.
const std::vector<LineExperiment>& lineExperiments();

/// Returns the one of that name. Throws base::InputError.
const LineExperiment& lineExperiment(const std::string& name);

/// Length of the paper's line, m, and the number of its control points, a wavelength apart.
constexpr double kLine_m = 0.034;
constexpr int kLinePoints = 5;

/// One of the paper's scenes: control points of equal pressure.
struct PaperScene
{
    std::string name;
    std::string caption;     ///< what it is, and the paper's number where it has one
    Eigen::Matrix3Xd points; ///< 3 x n, metres, array frame
};

/// Returns all scenes: the focus, the line, the flat star, the star of \a model (the vertices of an
/// OBJ file), and the lines of the two experiments at the paper's thresholds.
std::vector<PaperScene> paperScenes(const std::string& model);

} // namespace midair::samples
