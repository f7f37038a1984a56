#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::samples
{

/// A line through points, x ascending.
struct Curve
{
    Eigen::VectorXd x;
    Eigen::VectorXd y; ///< as many
    std::string name;  ///< in the legend; may be empty
};

/// A pair of axes with curves, at most six of which differ in colour.
struct CurvePanel
{
    std::string xName; ///< of the axes, with units
    std::string yName;
    std::vector<Curve> curves;
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

/// Writes \a plot to \a path (.png), drawn off screen with OpenGL; curves of more points than
/// pixels keep their lowest and highest in each. Returns false if nothing could be written, or
/// there is nothing to draw; \a message then says why.
bool writeCurvePlot(const std::string& path, const CurvePlot& plot, std::string* message = nullptr);

/// Returns 1, 2 or 5 times a power of ten: the least such step with which \a range (above 0) has at
/// most \a most steps.
double tickStep(double range, int most);

} // namespace midair::samples
