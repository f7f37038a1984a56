#include "samples/shared/views/FieldImage.h"

#include "haptics/base/SmallMatrices.h"
#include "samples/shared/views/Offscreen.h"

#include <osgMidair/FieldPicture>

#include <osgDB/WriteFile>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace midair::samples
{

namespace
{

osg::Vec3d toOsg(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

osgMidair::FieldPicture pictureOf(const FieldImage& image)
{
    osgMidair::FieldPicture picture;
    picture.corner = toOsg(image.grid.corner);
    picture.across = toOsg(image.grid.u);
    picture.up = toOsg(image.grid.v);
    picture.columns = image.grid.columns;
    picture.rows = image.grid.rows;
    for (const std::complex<float> pressure : image.pressure_Pa)
        picture.pressures_Pa.push_back(std::abs(pressure));
    const bool isKnown = image.achieved_Pa.size() == image.points.size() && image.level_Pa > 0.0;
    for (int l = 0; l < image.points.size(); ++l)
    {
        osgMidair::FieldPicture::Point& point = picture.points.emplace_back();
        point.position = toOsg(image.points.positions.col(l));
        if (!isKnown) continue;
        point.wanted_Pa =
            image.level_Pa * image.points.targets[l] / image.points.targets.maxCoeff();
        point.achieved_Pa = image.achieved_Pa[l];
    }
    for (Eigen::Index s = 0; s < image.outline.cols(); ++s)
        picture.outline.push_back(toOsg(image.outline.col(s)));
    picture.title = image.title;
    picture.caption = image.caption;
    return picture;
}

} // namespace

haptics::FieldGrid bestSlice(const haptics::ControlPoints& points, double margin_m, double step_m)
{
    haptics::FieldGrid grid;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d u = Eigen::Vector3d::UnitX();
    Eigen::Vector3d v = Eigen::Vector3d::UnitZ();
    Eigen::Vector2d half = Eigen::Vector2d::Constant(margin_m);
    if (points.size() > 0)
    {
        centre = points.positions.rowwise().mean();
        const Eigen::Matrix3Xd d = points.positions.colwise() - centre;
        const base::SymmetricAxes<3> spread =
            base::symmetricAxes(Eigen::Matrix3d(d * d.transpose()));
        // For flat or nearly flat points the normal is their thinnest direction, otherwise an axis
        // of the array frame.
        Eigen::Vector3d normal = spread.vectors.col(0);
        if (spread.values[0] > 0.25 * spread.values[1])
        {
            int thinnest = 0;
            d.cwiseAbs().rowwise().maxCoeff().minCoeff(&thinnest);
            normal = Eigen::Vector3d::Unit(thinnest);
        }
        // The median puts the slice where most points are: a raised middle doesn't move it off the
        // outline.
        Eigen::VectorXd heights = normal.transpose() * d;
        std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
        centre += normal * heights[heights.size() / 2];
        // The edges are as parallel to the array's axes as the plane allows, so that pictures of
        // successive frames look alike.
        int steepest = 0;
        normal.cwiseAbs().maxCoeff(&steepest);
        const Eigen::Vector3d first = Eigen::Vector3d::Unit(steepest == 0 ? 2 : 0);
        const Eigen::Vector3d second = Eigen::Vector3d::Unit(steepest == 1 ? 2 : 1);
        u = (first - first.dot(normal) * normal).normalized();
        v = normal.cross(u);
        if (v.dot(second) < 0.0) v = -v;
        // The margin leaves room for the side lobes of a single point or a line.
        half = Eigen::Vector2d((u.transpose() * d).cwiseAbs().maxCoeff(),
                               (v.transpose() * d).cwiseAbs().maxCoeff()) +
               Eigen::Vector2d::Constant(margin_m);
    }
    grid.corner = centre - half.x() * u - half.y() * v;
    grid.u = 2.0 * half.x() * u;
    grid.v = 2.0 * half.y() * v;
    grid.columns = std::max(2, static_cast<int>(std::lround(2.0 * half.x() / step_m)) + 1);
    grid.rows = std::max(2, static_cast<int>(std::lround(2.0 * half.y() / step_m)) + 1);
    return grid;
}

Eigen::Matrix3Xd outlineInPlane(const haptics::TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                const haptics::FieldGrid& grid)
{
    const Eigen::Vector3d normal = grid.u.cross(grid.v).normalized();
    const Eigen::Matrix3Xd vertices = pose * mesh.vertices;
    const Eigen::VectorXd height =
        (normal.transpose() * (vertices.colwise() - grid.corner)).transpose();
    const double flat = 1e-6 + 1e-4 * mesh.extent().maxCoeff();
    std::vector<Eigen::Vector3d> ends;
    // Number of triangles of the plane that use each edge.
    std::map<std::pair<int, int>, int> edgesInPlane;
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        std::vector<Eigen::Vector3d> crossings;
        for (int k = 0; k < 3; ++k)
        {
            const int a = mesh.triangles(k, t);
            const int b = mesh.triangles((k + 1) % 3, t);
            if (std::abs(height[a]) < flat && std::abs(height[b]) < flat)
                ++edgesInPlane[std::minmax(a, b)];
            else if ((height[a] < 0.0) != (height[b] < 0.0))
            {
                const double f = height[a] / (height[a] - height[b]);
                crossings.emplace_back(vertices.col(a) + f * (vertices.col(b) - vertices.col(a)));
            }
        }
        if (crossings.size() == 2) ends.insert(ends.end(), crossings.begin(), crossings.end());
    }
    for (const auto& [edge, count] : edgesInPlane)
        if (count == 1)
        {
            ends.emplace_back(vertices.col(edge.first));
            ends.emplace_back(vertices.col(edge.second));
        }
    Eigen::Matrix3Xd outline(3, static_cast<Eigen::Index>(ends.size()));
    for (std::size_t i = 0; i < ends.size(); ++i)
        outline.col(static_cast<Eigen::Index>(i)) = ends[i];
    return outline;
}

bool writeFieldImage(const std::string& path, const FieldImage& image, std::string* message)
{
    const osg::Vec4 paper(1.0F, 1.0F, 1.0F, 1.0F);
    const osgMidair::FieldPicture picture = pictureOf(image);
    std::string problem = picture.getProblem();
    if (message) *message = problem;
    if (!problem.empty()) return false;
    int width = 0;
    int height = 0;
    const osg::ref_ptr<osg::Node> figure = picture.createFigure(width, height);
    osg::ref_ptr<osg::Image> drawn = renderFlat(*figure, width, height, paper, &problem);
    if (!drawn)
    {
        drawn = picture.createSlice();
        problem = path + " has no axes and no text: " + problem;
    }
    if (message) *message = problem;
    if (osgDB::writeImageFile(*drawn, path)) return true;
    if (message)
        *message = "can't write the picture " + path + " (is the folder there, and is it a .png?)";
    return false;
}

} // namespace midair::samples
