#include "samples/shared/views/FieldImage.h"

#include "haptics/base/SmallMatrices.h"
#include "samples/shared/views/Offscreen.h"

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

} // namespace

osgMidair::FieldPicture fieldPicture(const haptics::FieldGrid& grid,
                                     const Eigen::VectorXf& pressure_Pa,
                                     const haptics::ControlPoints& points,
                                     const Eigen::VectorXd& achieved_Pa,
                                     double level_Pa)
{
    osgMidair::FieldPicture picture;
    picture.corner = toOsg(grid.corner);
    picture.across = toOsg(grid.u);
    picture.up = toOsg(grid.v);
    picture.columns = grid.columns;
    picture.rows = grid.rows;
    picture.pressures_Pa.assign(pressure_Pa.begin(), pressure_Pa.end());
    const bool isKnown = achieved_Pa.size() == points.size() && level_Pa > 0.0;
    for (int l = 0; l < points.size(); ++l)
    {
        osgMidair::FieldPicture::Point& point = picture.points.emplace_back();
        point.position = toOsg(points.positions.col(l));
        if (!isKnown) continue;
        point.wanted_Pa = level_Pa * points.targets[l] / points.targets.maxCoeff();
        point.achieved_Pa = achieved_Pa[l];
    }
    return picture;
}

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
        // Normal: the thinnest direction for flat or nearly flat points, otherwise an axis of the
        // array frame.
        Eigen::Vector3d normal = spread.vectors.col(0);
        if (spread.values[0] > 0.25 * spread.values[1])
        {
            int thinnest = 0;
            d.cwiseAbs().rowwise().maxCoeff().minCoeff(&thinnest);
            normal = Eigen::Vector3d::Unit(thinnest);
        }
        // The median puts the slice where most points are; a raised centre doesn't move it off the
        // outline.
        Eigen::VectorXd heights = normal.transpose() * d;
        std::nth_element(heights.begin(), heights.begin() + heights.size() / 2, heights.end());
        centre += normal * heights[heights.size() / 2];
        // Align the edges with the array's axes as far as possible, so that pictures of successive
        // frames look alike.
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

// Vertices within rounding errors of the plane count as in it.
std::vector<osg::Vec3d> outlineInPlane(const haptics::TriangleMesh& mesh,
                                       const Eigen::Isometry3d& pose,
                                       const haptics::FieldGrid& grid)
{
    const Eigen::Vector3d normal = grid.u.cross(grid.v).normalized();
    const Eigen::Matrix3Xd vertices = pose * mesh.vertices;
    const double flat = 1e-6 + 1e-4 * mesh.extent().maxCoeff();
    Eigen::VectorXd height = (normal.transpose() * (vertices.colwise() - grid.corner)).transpose();
    height = (height.array().abs() < flat).select(0.0, height);
    std::vector<osg::Vec3d> outline;
    std::map<std::pair<int, int>, int> facesAt; // number of faces in the plane at each edge
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Eigen::Vector3i corners = mesh.triangles.col(t);
        const bool isFace =
            corners[0] != corners[1] && corners[1] != corners[2]; // otherwise a line
        const bool isInPlane = isFace && height(corners).isZero(0.0);
        std::vector<osg::Vec3d> cut; // intersections with the plane, without edges in it
        for (int k = 0; k < 3; ++k)
        {
            const int a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
            if (a != b && height[a] == 0.0 && height[b] == 0.0)
                facesAt[std::minmax(a, b)] += isInPlane ? 1 : 0;
            if (height[c] == 0.0 && height[a] * height[b] < 0.0)
                cut.push_back(toOsg(vertices.col(c)));
            if (height[a] * height[b] >= 0.0) continue;
            const double f = height[a] / (height[a] - height[b]);
            cut.push_back(toOsg(vertices.col(a) + f * (vertices.col(b) - vertices.col(a))));
        }
        outline.insert(outline.end(), cut.begin(), cut.end());
    }
    for (const auto& [edge, faces] : facesAt)
        if (faces != 2)
            for (const int end : {edge.first, edge.second})
                outline.push_back(toOsg(vertices.col(end)));
    return outline;
}

bool writeFieldPicture(const std::string& path,
                       const osgMidair::FieldPicture& picture,
                       std::string& message)
{
    const osg::Vec4 paper(1.0F, 1.0F, 1.0F, 1.0F);
    message = picture.getProblem();
    if (!message.empty()) return false;
    int width = 0;
    int height = 0;
    const osg::ref_ptr<osg::Node> figure = picture.createFigure(width, height);
    osg::ref_ptr<osg::Image> drawn = renderFlat(*figure, width, height, paper, &message);
    if (!drawn)
    {
        drawn = picture.createSlice();
        message = path + " is drawn without axes and text: " + message;
    }
    if (osgDB::writeImageFile(*drawn, path)) return true;
    message = "can't write the picture " + path + " (is the folder there, and is it a .png?)";
    return false;
}

} // namespace midair::samples
