#include "samples/experiments/paper/LineExperiment.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Words.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/experiments/paper/PaperFigures.h"

#include <Eigen/Geometry>

#include <fmt/format.h>

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

std::vector<PaperScene> paperScenes(const std::string& model)
{
    const LineExperiment& oblique = lineExperiment("oblique");
    const LineExperiment& shifted = lineExperiment("shifted");
    const auto thresholdOf = [](const LineExperiment& experiment)
    {
        return fmt::format("felt as {} from {:.1f} ± {:.1f} {} on (paper)",
                           experiment.name,
                           experiment.paperMean,
                           experiment.paperDeviation,
                           experiment.unit);
    };
    return {
        {"focus", "one focus; paper: 5.53 kPa rms at 20 % drive", Eigen::Vector3d::Zero()},
        {"line", "line of 34 mm, 5 points; paper: about 10 mm wide", oblique.points(0.0)},
        {"flat star", "flat star of 34 mm, 11 points; paper's figures 3 and 4", flatStar(kLine_m)},
        {"star", "the kit's star, 11 points", haptics::readObj(model).vertices},
        {"oblique line", thresholdOf(oblique), oblique.points(oblique.paperMean)},
        {"shifted line", thresholdOf(shifted), shifted.points(shifted.paperMean)}};
}

} // namespace midair::samples
