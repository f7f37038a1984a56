#pragma once

#include <osgMidair/ColorMap>

#include <osg/Geometry>
#include <osg/Group>
#include <osgText/Text>

#include <string>
#include <vector>

/// Drawing in pixels, for the HUD and for figures.
namespace osgMidair::pixels
{

/// Returns DejaVu Sans if it is installed (Debian: fonts-dejavu-core), otherwise OSG's own bitmap
/// font.
osg::ref_ptr<osgText::Font> font();

/// Makes a text of \a content (UTF-8) at \a position, \a size pixels high.
osg::ref_ptr<osgText::Text>
text(const std::string& content,
     const osg::Vec2& position,
     float size,
     const osg::Vec4& color,
     osgText::TextBase::AlignmentType alignment = osgText::TextBase::LEFT_BASE_LINE);

/// Makes a filled rectangle.
osg::ref_ptr<osg::Geometry>
rectangle(const osg::Vec2& lowerLeft, const osg::Vec2& upperRight, const osg::Vec4& color);

/// Makes a rectangle that shows \a image, smoothed or texel by texel; \a turned swaps its axes.
osg::ref_ptr<osg::Geometry> picture(const osg::Vec2& lowerLeft,
                                    const osg::Vec2& upperRight,
                                    osg::Image* image,
                                    bool smooth,
                                    bool turned = false);

/// Collects strokes and areas into one geometry. Strokes are drawn as rectangles, so that their
/// width scales with the picture.
class Strokes
{
public:
    Strokes();

    void line(const osg::Vec2& from, const osg::Vec2& to, float width, const osg::Vec4& color);
    void frame(const osg::Vec2& lowerLeft,
               const osg::Vec2& upperRight,
               float width,
               const osg::Vec4& color);
    void rectangle(const osg::Vec2& lowerLeft, const osg::Vec2& upperRight, const osg::Vec4& color);
    void disc(const osg::Vec2& centre, float radius, const osg::Vec4& color);

    osg::ref_ptr<osg::Geometry> geometry();
    /// Makes \a geometry show what has been collected so far; call it again after changes.
    void show(osg::Geometry& geometry);
    void clear();

private:
    void
    triangle(const osg::Vec2& a, const osg::Vec2& b, const osg::Vec2& c, const osg::Vec4& color);

    osg::ref_ptr<osg::Vec3Array> _vertices;
    osg::ref_ptr<osg::Vec4Array> _colors;
};

/// Turns depth test and lighting off and blending on, and draws children in the order in which they
/// were added.
void paintInOrder(osg::Node& node, int bin);

/// Returns at most \a atMost round values between \a from and \a to, 1, 2 or 5 times a power of ten
/// apart.
std::vector<double> ticks(double from, double to, int atMost);

/// Returns the label of a tick: no needless digits, thousands separated by a blank.
std::string number(double value);

/// Scale of a colour map: a bar with ticks, numbers and a heading that names quantity and unit.
/// Upright bars have their numbers on the right, horizontal ones below.
class ColorBar : public osg::Group
{
public:
    struct Layout
    {
        osg::Vec2 lowerLeft;
        osg::Vec2 size; ///< size of the bar without its numbers; pixels
        float textSize = 13.0F;
        osg::Vec4 textColor = {1.0F, 1.0F, 1.0F, 1.0F};
        int maxTicks = 6;
    };

    ColorBar(const ColorMap& map, const std::string& heading, const Layout& layout);

    /// Sets round numbers from \a low to \a high; does nothing if they are the same.
    void setRange(double low, double high);
    /// Sets labels at given positions (0 .. 1).
    void setLabels(const std::vector<std::pair<double, std::string>>& labels);

private:
    Layout _layout;
    double _low = 0.0;
    double _high = 0.0;
    osg::ref_ptr<osg::Group> _labels;
};

} // namespace osgMidair::pixels
