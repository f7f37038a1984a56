#include "samples/experiments/paper/PaperScenes.h"

#include "haptics/surface/ObjReader.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/experiments/paper/LineExperiment.h"
#include "samples/experiments/paper/PaperFigures.h"

#include <fmt/format.h>

namespace midair::samples
{

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
