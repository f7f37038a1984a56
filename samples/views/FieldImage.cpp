#include "samples/views/FieldImage.h"

#include "plugin/overlays/drawing/PixelDrawing.h"
#include "samples/views/Offscreen.h"

#include <osgDB/WriteFile>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using osgMidair::ColorMap;
namespace pixels = osgMidair::pixels;

constexpr float kLeft = 92.0F; // margins in pixels
constexpr float kRight = 150.0F;
constexpr float kBottom = 92.0F;
constexpr float kTop = 78.0F;
constexpr float kLongSide = 620.0F;
constexpr float kTextSize = 17.0F;
const osg::Vec4 kInk(0.10F, 0.10F, 0.12F, 1.0F);
const osg::Vec4 kPaper(1.0F, 1.0F, 1.0F, 1.0F);

/// Returns |p| in the colour map, one texel per sample.
osg::ref_ptr<osg::Image> colored(const FieldImage& image, float largest)
{
    osg::ref_ptr<osg::Image> picture = new osg::Image;
    picture->allocateImage(image.grid.columns, image.grid.rows, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int row = 0; row < image.grid.rows; ++row)
        for (int column = 0; column < image.grid.columns; ++column)
        {
            const float value = std::abs(image.pressure_Pa[row * image.grid.columns + column]);
            picture->setColor(
                osg::Vec4(ColorMap::pressure().color(value / largest), 1.0F), column, row);
        }
    return picture;
}

/// Returns the colour of point \a l for achieved over wanted pressure, or a light grey if that is
/// not known.
osg::Vec4 pointColor(const FieldImage& image, int l)
{
    if (image.achieved_Pa.size() != image.points.size() || image.level_Pa <= 0.0)
        return {0.95F, 0.95F, 0.95F, 1.0F};
    const double wanted =
        image.level_Pa * image.points.targets[l] / image.points.targets.maxCoeff();
    return {ColorMap::diverging().color(
                ColorMap::ratioPosition(image.achieved_Pa[l], static_cast<float>(wanted))),
            1.0F};
}

/// Maps the array frame to the picture.
class PlaneMap
{
public:
    PlaneMap(const haptics::FieldGrid& grid, const osg::Vec2& lowerLeft, float scale) :
        _corner(grid.corner),
        _u(grid.u.normalized()),
        _v(grid.v.normalized()),
        _lowerLeft(lowerLeft),
        _scale(scale)
    {
    }

    osg::Vec2 operator()(const Eigen::Vector3d& point) const
    {
        const Eigen::Vector3d d = point - _corner;
        return _lowerLeft +
               osg::Vec2(static_cast<float>(d.dot(_u)), static_cast<float>(d.dot(_v))) * _scale;
    }
    double distance(const Eigen::Vector3d& point) const
    {
        return std::abs((point - _corner).dot(_u.cross(_v)));
    }

private:
    Eigen::Vector3d _corner;
    Eigen::Vector3d _u;
    Eigen::Vector3d _v;
    osg::Vec2 _lowerLeft;
    float _scale;
};

/// Name of an axis and the position of the grid's corner on it (m): an axis of the array if the
/// edge is parallel to it, otherwise the distance from the middle of the slice.
struct Axis
{
    std::string name;
    double start;
};

Axis axisOf(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge, const char* otherwise)
{
    const Eigen::Vector3d direction = edge.normalized();
    for (int i = 0; i < 3; ++i)
        if (direction[i] > 0.9999) return {std::string(1, "xyz"[i]) + " (mm)", corner[i]};
    return {std::string(otherwise) + " (mm, from the middle)", -edge.norm() / 2.0};
}

osg::ref_ptr<osg::Node>
axes(const FieldImage& image, const osg::Vec2& lowerLeft, const osg::Vec2& size, float scale)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    pixels::Strokes strokes;
    strokes.frame(lowerLeft, lowerLeft + size, 1.2F, kInk);
    const Axis across = axisOf(image.grid.corner, image.grid.u, "u");
    const Axis up = axisOf(image.grid.corner, image.grid.v, "v");
    for (const double tick :
         pixels::ticks(1e3 * across.start, 1e3 * (across.start + image.grid.u.norm()), 9))
    {
        const osg::Vec2 at =
            lowerLeft + osg::Vec2(static_cast<float>(tick * 1e-3 - across.start) * scale, 0.0F);
        strokes.line(at, at - osg::Vec2(0.0F, 6.0F), 1.2F, kInk);
        group->addChild(pixels::text(pixels::number(tick),
                                     at - osg::Vec2(0.0F, 11.0F),
                                     kTextSize,
                                     kInk,
                                     osgText::TextBase::CENTER_TOP));
    }
    for (const double tick :
         pixels::ticks(1e3 * up.start, 1e3 * (up.start + image.grid.v.norm()), 9))
    {
        const osg::Vec2 at =
            lowerLeft + osg::Vec2(0.0F, static_cast<float>(tick * 1e-3 - up.start) * scale);
        strokes.line(at, at - osg::Vec2(6.0F, 0.0F), 1.2F, kInk);
        group->addChild(pixels::text(pixels::number(tick),
                                     at - osg::Vec2(11.0F, 0.0F),
                                     kTextSize,
                                     kInk,
                                     osgText::TextBase::RIGHT_CENTER));
    }
    group->addChild(strokes.geometry());
    group->addChild(pixels::text(across.name,
                                 lowerLeft + osg::Vec2(size.x() / 2.0F, -38.0F),
                                 kTextSize,
                                 kInk,
                                 osgText::TextBase::CENTER_TOP));
    const osg::ref_ptr<osgText::Text> upright =
        pixels::text(up.name,
                     lowerLeft + osg::Vec2(-60.0F, size.y() / 2.0F),
                     kTextSize,
                     kInk,
                     osgText::TextBase::CENTER_BASE_LINE);
    upright->setAxisAlignment(osgText::TextBase::USER_DEFINED_ROTATION);
    upright->setRotation(osg::Quat(osg::PI_2, osg::Z_AXIS));
    group->addChild(upright);
    return group;
}

osg::ref_ptr<osg::Node> drawing(const FieldImage& image, int& width, int& height)
{
    const double edgeU = image.grid.u.norm();
    const double edgeV = image.grid.v.norm();
    const auto scale = static_cast<float>(kLongSide / std::max(edgeU, edgeV));
    const osg::Vec2 size(std::max(static_cast<float>(edgeU) * scale, 160.0F),
                         static_cast<float>(edgeV) * scale);
    const osg::Vec2 lowerLeft(kLeft, kBottom);
    width = static_cast<int>(kLeft + size.x() + kRight);
    height = static_cast<int>(kBottom + size.y() + kTop);
    const float largest = std::max(image.pressure_Pa.cwiseAbs().maxCoeff(), 1e-6F);

    osg::ref_ptr<osg::Group> group = new osg::Group;
    pixels::paintInOrder(*group, 1);
    group->addChild(pixels::picture(lowerLeft, lowerLeft + size, colored(image, largest), true));
    const PlaneMap map(image.grid, lowerLeft, scale);
    pixels::Strokes marks;
    for (Eigen::Index s = 0; s + 1 < image.outline.cols(); s += 2)
        marks.line(map(image.outline.col(s)),
                   map(image.outline.col(s + 1)),
                   1.6F,
                   {1.0F, 1.0F, 1.0F, 0.9F});
    // Points more than half a wavelength from the plane are not drawn.
    const double near = 0.5 * 343.0 / 40e3;
    for (int l = 0; l < image.points.size(); ++l)
    {
        const Eigen::Vector3d point = image.points.positions.col(l);
        if (map.distance(point) > near) continue;
        marks.disc(map(point), 5.0F, kInk);
        marks.disc(map(point), 3.6F, pointColor(image, l));
    }
    group->addChild(marks.geometry());
    group->addChild(axes(image, lowerLeft, size, scale));

    pixels::ColorBar::Layout bar;
    bar.lowerLeft = lowerLeft + osg::Vec2(size.x() + 26.0F, 0.0F);
    bar.size = {22.0F, size.y()};
    bar.textSize = kTextSize;
    bar.textColor = kInk;
    const osg::ref_ptr<pixels::ColorBar> colorBar =
        new pixels::ColorBar(ColorMap::pressure(), "|p| (Pa, peak)", bar);
    colorBar->setRange(0.0, largest);
    group->addChild(colorBar);
    group->addChild(pixels::text(image.title,
                                 osg::Vec2(kLeft, static_cast<float>(height) - 34.0F),
                                 1.25F * kTextSize,
                                 kInk));
    group->addChild(pixels::text(image.caption, osg::Vec2(kLeft, 14.0F), 0.85F * kTextSize, kInk));
    return group;
}

/// Returns only the slice, enlarged to about the size of the figure, with control points as white
/// squares with a dark rim.
osg::ref_ptr<osg::Image> withoutText(const FieldImage& image)
{
    const float largest = std::max(image.pressure_Pa.cwiseAbs().maxCoeff(), 1e-6F);
    const osg::ref_ptr<osg::Image> small = colored(image, largest);
    const int factor = std::max(1, static_cast<int>(kLongSide) / std::max(small->s(), small->t()));
    osg::ref_ptr<osg::Image> large = new osg::Image;
    large->allocateImage(small->s() * factor, small->t() * factor, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int y = 0; y < large->t(); ++y)
        for (int x = 0; x < large->s(); ++x)
            large->setColor(small->getColor(x / factor, y / factor), x, y);
    const PlaneMap map(image.grid, {}, static_cast<float>(large->s() / image.grid.u.norm()));
    for (int l = 0; l < image.points.size(); ++l)
    {
        const osg::Vec2 at = map(image.points.positions.col(l));
        for (int dy = -3; dy <= 3; ++dy)
            for (int dx = -3; dx <= 3; ++dx)
            {
                const int x = static_cast<int>(at.x()) + dx;
                const int y = static_cast<int>(at.y()) + dy;
                if (x < 0 || y < 0 || x >= large->s() || y >= large->t()) continue;
                const bool rim = std::max(std::abs(dx), std::abs(dy)) == 3;
                large->setColor(rim ? kInk : pointColor(image, l), x, y);
            }
    }
    return large;
}

std::string whatIsWrong(const FieldImage& image)
{
    if (image.grid.columns < 2 || image.grid.rows < 2)
        return fmt::format("a field image needs at least 2 x 2 samples, not {} x {}",
                           image.grid.columns,
                           image.grid.rows);
    if (image.pressure_Pa.size() != static_cast<Eigen::Index>(image.grid.columns) * image.grid.rows)
        return fmt::format("a field image of {} x {} samples was given {} pressures",
                           image.grid.columns,
                           image.grid.rows,
                           image.pressure_Pa.size());
    if (!image.pressure_Pa.allFinite())
        return "a field image was given pressures that are not finite";
    return {};
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
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(d * d.transpose());
        // For flat or nearly flat points the normal is their thinnest direction, otherwise an axis
        // of the array frame.
        Eigen::Vector3d normal = spread.eigenvectors().col(0);
        if (spread.eigenvalues()[0] > 0.25 * spread.eigenvalues()[1])
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
    std::string problem = whatIsWrong(image);
    if (message) *message = problem;
    if (!problem.empty()) return false;
    int width = 0;
    int height = 0;
    const osg::ref_ptr<osg::Node> scene = drawing(image, width, height);
    osg::ref_ptr<osg::Image> picture = renderFlat(*scene, width, height, kPaper, &problem);
    if (!picture)
    {
        picture = withoutText(image);
        problem = path + " has no axes and no text: " + problem;
    }
    if (message) *message = problem;
    if (osgDB::writeImageFile(*picture, path)) return true;
    if (message)
        *message = "can't write the picture " + path + " (is the folder there, and is it a .png?)";
    return false;
}

} // namespace midair::samples
