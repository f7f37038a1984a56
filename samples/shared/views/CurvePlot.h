#pragma once

#include <Eigen/Core>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// What stands at each point of a curve.
enum class CurveMark
{
    NONE,
    DISC,
    RING
};

/// A line through points, x ascending, or marks at them.
struct Curve
{
    Eigen::VectorXd x;
    Eigen::VectorXd y; ///< as many
    std::string name;  ///< in the legend; may be empty
    CurveMark mark = CurveMark::NONE;
    bool isJoined = true; ///< by a line; otherwise marks alone
    int color = -1;       ///< one of six; -1: the next one
};

/// A range of an axis that is tinted over the whole panel, with a line at a value in it.
struct CurveBand
{
    double low = 0.0, high = 0.0;
    double middle = std::numeric_limits<double>::quiet_NaN(); ///< NaN: no line
    std::string name;                                         ///< in the legend; may be empty
    bool isOfX = false; ///< a range of x, upright; otherwise of y
    int color = 0;      ///< one of six
};

/// A pair of axes with curves, at most six of which differ in colour.
struct CurvePanel
{
    std::string xName; ///< of the axes, with units
    std::string yName;
    std::vector<Curve> curves;
    std::vector<CurveBand> bands = {}; ///< behind the curves
    /// Ends of the axes; NaN: those of the curves, and 0 for y
    double xLow = std::numeric_limits<double>::quiet_NaN();
    double xHigh = std::numeric_limits<double>::quiet_NaN();
    double yHigh = std::numeric_limits<double>::quiet_NaN();
    /// Names at places of the x axis, in place of numbers; may be empty
    std::vector<std::pair<double, std::string>> xTicks = {};
    /// True: y has a logarithmic axis of \a decades below its largest value
    bool logarithmic = false;
    int decades = 5; ///< >= 1
};

/// Panels above each other, the first on top.
struct CurvePlot
{
    std::string title;
    std::string caption; ///< one line below; may be empty
    std::vector<CurvePanel> panels;
};

/// Draws \a plot into \a path (.png, .svg, .pdf) by drawPlot(). Returns what went wrong, or an
/// empty text.
std::string drawCurves(const std::string& path, const CurvePlot& plot);

/// Draws what \a plot describes as plot.py reads it into the file \a path (.png, .svg, .pdf), by
/// Debian's Python and its package python3-matplotlib. Returns what went wrong, or an empty text.
std::string drawPlot(const std::string& path, const nlohmann::json& plot);

} // namespace midair::samples
