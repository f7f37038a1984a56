#pragma once

#include <Eigen/Core>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// Mark at each point of a curve.
enum class CurveMark
{
    NONE,
    DISC,
    RING
};

/// A line through points in ascending order of x, or marks.
struct Curve
{
    Eigen::VectorXd x;
    Eigen::VectorXd y; ///< as many
    std::string name;  ///< in the legend; may be empty
    CurveMark mark = CurveMark::NONE;
    bool isJoined = true; ///< draw the line
    int color = -1;       ///< 0 .. 5; -1: the next one
};

/// A tinted range of an axis over the whole panel, with an optional line.
struct CurveBand
{
    double low = 0.0, high = 0.0;
    double middle = std::numeric_limits<double>::quiet_NaN(); ///< value of the line; NaN: none
    std::string name;                                         ///< in the legend; may be empty
    bool isOfX = false;                                       ///< a range of x; otherwise of y
    int color = 0;                                            ///< 0 .. 5
};

/// A pair of axes with curves, at most six of them with different colours.
struct CurvePanel
{
    std::string xName; ///< axis labels with units
    std::string yName;
    std::vector<Curve> curves;
    std::vector<CurveBand> bands = {}; ///< drawn behind the curves
    /// axis limits; NaN: from the curves, and 0 for y
    double xLow = std::numeric_limits<double>::quiet_NaN();
    double xHigh = std::numeric_limits<double>::quiet_NaN();
    double yHigh = std::numeric_limits<double>::quiet_NaN();
    /// tick labels of the x axis in place of numbers; may be empty
    std::vector<std::pair<double, std::string>> xTicks = {};
    /// y is logarithmic over \a decades below its largest value
    bool logarithmic = false;
    int decades = 5; ///< >= 1
};

/// Panels from top to bottom.
struct CurvePlot
{
    std::string title;
    std::string caption; ///< one line at the bottom; may be empty
    std::vector<CurvePanel> panels;
};

/// Draws \a plot into \a path (.png, .svg, .pdf) with drawPlot(). Returns an error message, or an
/// empty text.
std::string drawCurves(const std::string& path, const CurvePlot& plot);

/// Runs plot.py with the description \a plot to draw the file \a path (.png, .svg, .pdf); needs
/// Debian's Python with python3-matplotlib. Returns an error message, or an empty text.
std::string drawPlot(const std::string& path, const nlohmann::json& plot);

} // namespace midair::samples
