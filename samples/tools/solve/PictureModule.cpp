// Module that draws midair-solve's picture, separate so that the program itself needs no scene
// graph.
#include "haptics/propagation/PressureField.h"
#include "samples/shared/views/FieldImage.h"
#include "samples/tools/solve/Picture.h"

#include <exception>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

std::string draw(const Solution& solution, const std::string& title, const std::string& path)
{
    const SolveScene& scene = solution.scene;
    const std::vector<Eigen::VectorXcf>& fields = solution.sequence.fields;
    const haptics::FieldGrid grid = bestSlice(solution.points, 0.02, 4e-4);
    // Several fields: draw the root mean square, because skin averages them.
    Eigen::VectorXf square = Eigen::VectorXf::Zero(grid.columns * grid.rows);
    for (const Eigen::VectorXcf& q : fields)
        square += haptics::pressureAt(grid.points(), scene.array, scene.medium, q, 2).cwiseAbs2() /
                  static_cast<float>(fields.size());
    osgMidair::FieldPicture picture =
        fieldPicture(grid,
                     square.cwiseSqrt(),
                     solution.points,
                     solution.achieved_Pa,
                     solution.target_Pa.size() > 0 ? solution.target_Pa.maxCoeff() : 0.0);
    if (scene.mesh.triangles.cols() > 0)
        picture.outline = outlineInPlane(scene.mesh, scene.pose, grid);
    picture.title = title;
    const haptics::SolveReport& report = solution.sequence.report;
    picture.caption = fmt::format("{}, {} points, rms {:.2f} %, {:.0f} Pa peak",
                                  report.solver,
                                  report.points,
                                  100.0 * report.rms,
                                  report.level_Pa);
    std::string message;
    writeFieldPicture(path, picture, message);
    return message;
}

} // namespace

} // namespace midair::samples

extern "C" void midairDrawPicture(const midair::samples::Solution& solution,
                                  const std::string& title,
                                  const std::string& path,
                                  std::string& problem)
{
    try
    {
        problem = midair::samples::draw(solution, title, path);
    }
    catch (const std::exception& error)
    {
        problem = error.what();
    }
}
