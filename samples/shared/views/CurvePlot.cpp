#include "samples/shared/views/CurvePlot.h"

#include <algorithm>
#include <cmath>

namespace midair::samples
{

namespace
{

using nlohmann::json;

constexpr double kColumns = 1800.0; // half pixels across a panel

std::vector<double> listOf(const Eigen::VectorXd& values)
{
    return {values.data(), values.data() + values.size()};
}

// Reduces the points in a column to the lowest and the highest in their order, because the points
// of an hour's probe would not fit into memory as text.
Curve thinned(const Curve& curve)
{
    const double first = curve.x[0], width = curve.x[curve.x.size() - 1] - first;
    if (!curve.isJoined || curve.x.size() < 2 * kColumns || !(width > 0.0)) return curve;
    const auto columnOf = [&](Eigen::Index k)
    { return static_cast<int>(kColumns * (curve.x[k] - first) / width); };
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0, end = 0; k < curve.x.size(); k = end)
    {
        Eigen::Index low = k, high = k;
        for (; end < curve.x.size() && columnOf(end) == columnOf(k); ++end)
        {
            if (curve.y[end] < curve.y[low]) low = end;
            if (curve.y[end] > curve.y[high]) high = end;
        }
        kept.push_back(std::min(low, high));
        if (low != high) kept.push_back(std::max(low, high));
    }
    Curve fewer = curve;
    fewer.x = curve.x(kept);
    fewer.y = curve.y(kept);
    return fewer;
}

std::string nameOf(CurveMark mark)
{
    if (mark == CurveMark::NONE) return "NONE";
    return mark == CurveMark::DISC ? "DISC" : "RING";
}

// NaN is written as null, because JSON has no NaN.
json jsonOf(const CurvePanel& panel)
{
    json curves = json::array(), bands = json::array();
    for (const Curve& curve : panel.curves)
    {
        const Curve drawn = thinned(curve);
        curves.push_back({{"x", listOf(drawn.x)},
                          {"y", listOf(drawn.y)},
                          {"name", curve.name},
                          {"mark", nameOf(curve.mark)},
                          {"isJoined", curve.isJoined},
                          {"color", curve.color}});
    }
    for (const CurveBand& band : panel.bands)
        bands.push_back({{"low", band.low},
                         {"high", band.high},
                         {"middle", band.middle},
                         {"name", band.name},
                         {"isOfX", band.isOfX},
                         {"color", band.color}});
    return {{"xName", panel.xName},
            {"yName", panel.yName},
            {"curves", curves},
            {"bands", bands},
            {"xLow", panel.xLow},
            {"xHigh", panel.xHigh},
            {"yHigh", panel.yHigh},
            {"xTicks", panel.xTicks},
            {"logarithmic", panel.logarithmic},
            {"decades", panel.decades}};
}

std::string problemOf(const CurvePlot& plot)
{
    if (plot.panels.empty()) return "there are no panels to draw";
    for (const CurvePanel& panel : plot.panels)
    {
        if (panel.curves.empty()) return "a panel has no curves";
        for (const Curve& curve : panel.curves)
            if (curve.x.size() == 0 || curve.x.size() != curve.y.size() || !curve.x.allFinite() ||
                !curve.y.allFinite())
                return "a curve has no points, not as many x as y, or numbers that are not finite";
        for (const CurveBand& band : panel.bands)
            if (!(band.low <= band.high) || !std::isfinite(band.low) || !std::isfinite(band.high))
                return "a band has no range";
    }
    return {};
}

} // namespace

std::string drawCurves(const std::string& path, const CurvePlot& plot)
{
    const std::string problem = problemOf(plot);
    if (!problem.empty()) return path + " isn't drawn: " + problem;
    json panels = json::array();
    for (const CurvePanel& panel : plot.panels)
        panels.push_back(jsonOf(panel));
    return drawPlot(
        path,
        {{"kind", "curves"}, {"title", plot.title}, {"caption", plot.caption}, {"panels", panels}});
}

} // namespace midair::samples
