#include "plugin/overlays/drawing/PixelDrawing.h"

#include <osgMidair/ColorMap>
#include <osgMidair/FieldPicture>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

constexpr float kLeft = 92.0F; // margins in pixels
constexpr float kRight = 150.0F;
constexpr float kBottom = 92.0F;
constexpr float kTop = 78.0F;
constexpr float kLongSide = 620.0F;
constexpr float kTextSize = 17.0F;
const osg::Vec4 kPictureInk(0.10F, 0.10F, 0.12F, 1.0F);

bool isFinite(const osg::Vec3d& v)
{
    return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

float largestOf(const FieldPicture& picture)
{
    float largest = 1e-6F;
    for (const float pressure : picture.pressures_Pa)
        largest = std::max(largest, std::abs(pressure));
    return largest;
}

/// Returns |p| in the colour map, one texel per sample.
osg::ref_ptr<osg::Image> colored(const FieldPicture& picture, float largest)
{
    osg::ref_ptr<osg::Image> colors = new osg::Image;
    colors->allocateImage(picture.columns, picture.rows, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int row = 0; row < picture.rows; ++row)
        for (int column = 0; column < picture.columns; ++column)
        {
            const float value = std::abs(
                picture.pressures_Pa[static_cast<std::size_t>(row * picture.columns + column)]);
            colors->setColor(
                osg::Vec4(ColorMap::pressure().color(value / largest), 1.0F), column, row);
        }
    return colors;
}

/// Returns the colour of a point for achieved over wanted pressure, or a light grey if that is
/// unknown.
osg::Vec4 pointColor(const FieldPicture::Point& point)
{
    if (point.wanted_Pa <= 0.0) return {0.95F, 0.95F, 0.95F, 1.0F};
    return {ColorMap::diverging().color(ColorMap::ratioPosition(
                static_cast<float>(point.achieved_Pa), static_cast<float>(point.wanted_Pa))),
            1.0F};
}

osg::Vec3d direction(osg::Vec3d edge)
{
    edge.normalize();
    return edge;
}

/// Maps the frame of the slice to the figure.
class PlaneMap
{
public:
    PlaneMap(const FieldPicture& picture, const osg::Vec2& lowerLeft, float scale) :
        _corner(picture.corner),
        _u(direction(picture.across)),
        _v(direction(picture.up)),
        _lowerLeft(lowerLeft),
        _scale(scale)
    {
    }

    osg::Vec2 operator()(const osg::Vec3d& point) const
    {
        const osg::Vec3d d = point - _corner;
        return _lowerLeft +
               osg::Vec2(static_cast<float>(d * _u), static_cast<float>(d * _v)) * _scale;
    }
    double distance(const osg::Vec3d& point) const
    {
        return std::abs((point - _corner) * (_u ^ _v));
    }

private:
    osg::Vec3d _corner;
    osg::Vec3d _u;
    osg::Vec3d _v;
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

Axis axisOf(const osg::Vec3d& corner, const osg::Vec3d& edge, const char* otherwise)
{
    const osg::Vec3d along = direction(edge);
    for (int i = 0; i < 3; ++i)
        if (along[i] > 0.9999) return {std::string(1, "xyz"[i]) + " (mm)", corner[i]};
    return {std::string(otherwise) + " (mm, from the middle)", -edge.length() / 2.0};
}

osg::ref_ptr<osg::Node>
axes(const FieldPicture& picture, const osg::Vec2& lowerLeft, const osg::Vec2& size, float scale)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    pixels::Strokes strokes;
    strokes.frame(lowerLeft, lowerLeft + size, 1.2F, kPictureInk);
    const Axis across = axisOf(picture.corner, picture.across, "u");
    const Axis up = axisOf(picture.corner, picture.up, "v");
    // Both axes are drawn alike: ticks along \a along, pointing \a outwards.
    const auto drawTicks = [&](double start_m,
                               double length_m,
                               const osg::Vec2& along,
                               const osg::Vec2& outwards,
                               osgText::TextBase::AlignmentType alignment)
    {
        for (const double tick : pixels::ticks(1e3 * start_m, 1e3 * (start_m + length_m), 9))
        {
            const osg::Vec2 at =
                lowerLeft + along * (static_cast<float>(tick * 1e-3 - start_m) * scale);
            strokes.line(at, at + outwards * 6.0F, 1.2F, kPictureInk);
            group->addChild(pixels::text(
                pixels::number(tick), at + outwards * 11.0F, kTextSize, kPictureInk, alignment));
        }
    };
    drawTicks(across.start,
              picture.across.length(),
              {1.0F, 0.0F},
              {0.0F, -1.0F},
              osgText::TextBase::CENTER_TOP);
    drawTicks(up.start,
              picture.up.length(),
              {0.0F, 1.0F},
              {-1.0F, 0.0F},
              osgText::TextBase::RIGHT_CENTER);
    group->addChild(strokes.geometry());
    group->addChild(pixels::text(across.name,
                                 lowerLeft + osg::Vec2(size.x() / 2.0F, -38.0F),
                                 kTextSize,
                                 kPictureInk,
                                 osgText::TextBase::CENTER_TOP));
    const osg::ref_ptr<osgText::Text> upright =
        pixels::text(up.name,
                     lowerLeft + osg::Vec2(-60.0F, size.y() / 2.0F),
                     kTextSize,
                     kPictureInk,
                     osgText::TextBase::CENTER_BASE_LINE);
    upright->setAxisAlignment(osgText::TextBase::USER_DEFINED_ROTATION);
    upright->setRotation(osg::Quat(osg::PI_2, osg::Z_AXIS));
    group->addChild(upright);
    return group;
}

osg::ref_ptr<osg::Node> drawing(const FieldPicture& picture, int& width, int& height)
{
    const double edgeU = picture.across.length();
    const double edgeV = picture.up.length();
    const auto scale = static_cast<float>(kLongSide / std::max(edgeU, edgeV));
    const osg::Vec2 size(std::max(static_cast<float>(edgeU) * scale, 160.0F),
                         static_cast<float>(edgeV) * scale);
    const osg::Vec2 lowerLeft(kLeft, kBottom);
    width = static_cast<int>(kLeft + size.x() + kRight);
    height = static_cast<int>(kBottom + size.y() + kTop);
    const float largest = largestOf(picture);

    osg::ref_ptr<osg::Group> group = new osg::Group;
    pixels::paintInOrder(*group, 1);
    group->addChild(pixels::picture(lowerLeft, lowerLeft + size, colored(picture, largest)));
    const PlaneMap map(picture, lowerLeft, scale);
    pixels::Strokes marks;
    for (std::size_t s = 0; s + 1 < picture.outline.size(); s += 2)
        marks.line(
            map(picture.outline[s]), map(picture.outline[s + 1]), 1.6F, {1.0F, 1.0F, 1.0F, 0.9F});
    // Points more than half a wavelength from the plane are not drawn.
    const double near = 0.5 * 343.0 / 40e3;
    for (const FieldPicture::Point& point : picture.points)
    {
        if (map.distance(point.position) > near) continue;
        marks.disc(map(point.position), 5.0F, kPictureInk);
        marks.disc(map(point.position), 3.6F, pointColor(point));
    }
    group->addChild(marks.geometry());
    group->addChild(axes(picture, lowerLeft, size, scale));

    group->addChild(pixels::colorBar(ColorMap::pressure(),
                                     "|p| (Pa, peak)",
                                     lowerLeft + osg::Vec2(size.x() + 26.0F, 0.0F),
                                     {22.0F, size.y()},
                                     largest,
                                     kTextSize,
                                     kPictureInk));
    group->addChild(pixels::text(picture.title,
                                 osg::Vec2(kLeft, static_cast<float>(height) - 34.0F),
                                 1.25F * kTextSize,
                                 kPictureInk));
    group->addChild(
        pixels::text(picture.caption, osg::Vec2(kLeft, 14.0F), 0.85F * kTextSize, kPictureInk));
    return group;
}

/// Returns the slice alone, enlarged to about the size of the figure, with control points as white
/// squares with a dark rim.
osg::ref_ptr<osg::Image> withoutText(const FieldPicture& picture)
{
    const float largest = largestOf(picture);
    const osg::ref_ptr<osg::Image> small = colored(picture, largest);
    const int factor = std::max(1, static_cast<int>(kLongSide) / std::max(small->s(), small->t()));
    osg::ref_ptr<osg::Image> large = new osg::Image;
    large->allocateImage(small->s() * factor, small->t() * factor, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int y = 0; y < large->t(); ++y)
        for (int x = 0; x < large->s(); ++x)
            large->setColor(small->getColor(x / factor, y / factor), x, y);
    const PlaneMap map(picture, {}, static_cast<float>(large->s() / picture.across.length()));
    for (const FieldPicture::Point& point : picture.points)
    {
        const osg::Vec2 at = map(point.position);
        for (int dy = -3; dy <= 3; ++dy)
            for (int dx = -3; dx <= 3; ++dx)
            {
                const int x = static_cast<int>(at.x()) + dx;
                const int y = static_cast<int>(at.y()) + dy;
                if (x < 0 || y < 0 || x >= large->s() || y >= large->t()) continue;
                const bool rim = std::max(std::abs(dx), std::abs(dy)) == 3;
                large->setColor(rim ? kPictureInk : pointColor(point), x, y);
            }
    }
    return large;
}

} // namespace

std::vector<osg::Vec3d> FieldPicture::getPlaces() const
{
    std::vector<osg::Vec3d> places;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            places.push_back(corner + across * (column / std::max(1.0, columns - 1.0)) +
                             up * (row / std::max(1.0, rows - 1.0)));
    return places;
}

std::string FieldPicture::getProblem() const
{
    if (columns < 2 || rows < 2)
        return fmt::format(
            "a field image needs at least 2 x 2 samples, not {} x {}", columns, rows);
    if (pressures_Pa.size() != static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows))
        return fmt::format("a field image of {} x {} samples was given {} pressures",
                           columns,
                           rows,
                           pressures_Pa.size());
    if (!std::all_of(pressures_Pa.begin(),
                     pressures_Pa.end(),
                     [](float pressure) { return std::isfinite(pressure); }))
        return "a field image was given pressures that are not finite";
    if (!isFinite(corner) || !isFinite(across) || !isFinite(up) || across.length() <= 0.0 ||
        up.length() <= 0.0 || std::abs(across * up) > 1e-6 * across.length() * up.length())
        return "a field image needs two finite edges, perpendicular to each other";
    const bool arePlaces =
        std::all_of(points.begin(),
                    points.end(),
                    [](const Point& point) { return isFinite(point.position); }) &&
        std::all_of(outline.begin(), outline.end(), isFinite);
    if (!arePlaces) return "a field image was given places that are not finite";
    return {};
}

osg::ref_ptr<osg::Node> FieldPicture::createFigure(int& width, int& height) const
{
    return getProblem().empty() ? drawing(*this, width, height) : nullptr;
}

osg::ref_ptr<osg::Image> FieldPicture::createSlice() const
{
    return getProblem().empty() ? withoutText(*this) : nullptr;
}

} // namespace osgMidair
