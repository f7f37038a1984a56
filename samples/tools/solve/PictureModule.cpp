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

/// The points, and the middle of what scatters within 0.1 m of them, so that a picture shows both.
haptics::ControlPoints withScatterer(const Solution& solution)
{
    constexpr double kNear_m = 0.1;
    haptics::ControlPoints all = solution.points;
    if (all.size() == 0) return all;
    const Eigen::Vector3d middle = all.positions.rowwise().mean();
    haptics::ControlPoints other;
    other.positions = Eigen::Vector3d::Zero();
    other.targets = Eigen::VectorXd::Zero(1);
    int count = 0;
    for (const auto& corner : solution.scatterer.vertices.colwise())
    {
        if ((corner - middle).norm() > kNear_m) continue;
        other.positions += corner;
        ++count;
    }
    if (count == 0) return all;
    other.positions /= count;
    append(all, other);
    return all;
}

std::string draw(const Solution& solution, const std::string& title, const std::string& path)
{
    const SolveScene& scene = solution.scene;
    const std::vector<Eigen::VectorXcf>& fields = solution.sequence.fields;
    const bool isScattered = static_cast<bool>(solution.scattered_Pa);
    // Each place takes a sum over all elements of what scatters.
    const haptics::FieldGrid grid =
        bestSlice(withScatterer(solution), 0.02, isScattered ? 1e-3 : 4e-4);
    // Several fields: draw the root mean square, because skin averages them.
    Eigen::VectorXf square = Eigen::VectorXf::Zero(grid.columns * grid.rows);
    for (const Eigen::VectorXcf& q : fields)
    {
        const Eigen::VectorXf p_Pa =
            isScattered ? solution.scattered_Pa(grid.points(), q)
                        : haptics::pressureAt(grid.points(), scene.array, scene.medium, q, 2)
                              .cwiseAbs()
                              .eval();
        square += p_Pa.cwiseAbs2() / static_cast<float>(fields.size());
    }
    osgMidair::FieldPicture picture =
        fieldPicture(grid,
                     square.cwiseSqrt(),
                     solution.points,
                     solution.achieved_Pa,
                     solution.target_Pa.size() > 0 ? solution.target_Pa.maxCoeff() : 0.0);
    if (scene.mesh.triangles.cols() > 0)
        picture.outline = outlineInPlane(scene.mesh, scene.pose, grid);
    if (isScattered)
        for (const osg::Vec3d& end :
             outlineInPlane(solution.scatterer, Eigen::Isometry3d::Identity(), grid))
            picture.outline.push_back(end);
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
