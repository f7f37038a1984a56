#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::samples
{

/// The paper's two experiments: the smallest angle at which a line feels oblique, and the smallest
/// distance at which it feels shifted.
enum class LineKind
{
    OBLIQUE, ///< rotated about its centre in the cross-section xz
    SHIFTED  ///< moved along z, perpendicular to the line
};

/// Question, range and the paper's result.
struct LineExperiment
{
    LineKind kind = LineKind::OBLIQUE;
    std::string name;            ///< "oblique", "shifted"; in files and on the command line
    std::string title;           ///< of plots
    std::string question;        ///< yes/no question
    std::string quantity;        ///< "angle", "shift"
    std::string unit;            ///< "deg", "mm"
    double maximum = 0.0;        ///< start of staircases
    double step = 0.0;           ///< default step; a whole part of maximum
    double paperMean = 0.0;      ///< mean threshold of the paper's participants
    double paperDeviation = 0.0; ///< its standard deviation

    /// Returns the five control points, 8.5 mm apart, of the line rotated or shifted by \a value: 3
    /// x 5, metres, array frame. At 0 the line is along x through the centre.
    Eigen::Matrix3Xd points(double value) const;
};

/// Returns both experiments.
const std::vector<LineExperiment>& lineExperiments();

/// Returns the experiment of that name. Throws base::InputError.
const LineExperiment& lineExperiment(const std::string& name);

/// Length of the paper's line, m, and the number of its control points, a wavelength apart.
constexpr double kLine_m = 0.034;
constexpr int kLinePoints = 5;

/// One of the paper's scenes: control points of equal pressure.
struct PaperScene
{
    std::string name;
    std::string caption;     ///< description, with the paper's figure if there is one
    Eigen::Matrix3Xd points; ///< 3 x n, metres, array frame
};

/// Returns all scenes: the focus, the line, the flat star, the star of \a model (the vertices of an
/// OBJ file), and the lines of the two experiments at the paper's thresholds.
std::vector<PaperScene> paperScenes(const std::string& model);

} // namespace midair::samples
