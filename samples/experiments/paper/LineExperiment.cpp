#include "samples/experiments/paper/LineExperiment.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Words.h"

#include <Eigen/Geometry>

namespace midair::samples
{

Eigen::Matrix3Xd LineExperiment::points(double value) const
{
    Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, kLinePoints);
    points.row(0).setLinSpaced(-0.5 * kLine_m, 0.5 * kLine_m);
    if (kind == LineKind::OBLIQUE)
        return Eigen::AngleAxisd(base::toRadians(value), Eigen::Vector3d::UnitY())
                   .toRotationMatrix() *
               points;
    points.row(2).setConstant(1e-3 * value);
    return points;
}

const std::vector<LineExperiment>& lineExperiments()
{
    static const std::vector<LineExperiment> both = {{LineKind::OBLIQUE,
                                                      "oblique",
                                                      "Oblique line",
                                                      "Is the second line oblique?",
                                                      "angle",
                                                      "deg",
                                                      45.0,
                                                      2.5,
                                                      17.9,
                                                      6.6},
                                                     {LineKind::SHIFTED,
                                                      "shifted",
                                                      "Shifted line",
                                                      "Is the second line shifted?",
                                                      "shift",
                                                      "mm",
                                                      27.0,
                                                      1.5,
                                                      10.4,
                                                      2.5}};
    return both;
}

const LineExperiment& lineExperiment(const std::string& name)
{
    std::vector<std::string> names;
    for (const LineExperiment& experiment : lineExperiments())
    {
        if (experiment.name == name) return experiment;
        names.push_back(experiment.name);
    }
    throw base::InputError("experiment \"" + name +
                           "\" isn't known; there are oblique and shifted" +
                           base::didYouMean(name, names));
}

} // namespace midair::samples
