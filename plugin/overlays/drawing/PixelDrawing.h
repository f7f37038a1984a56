#pragma once

#include <osgMidair/ColorMap>

#include <osg/Geometry>
#include <osg/Group>
#include <osg/Texture2D>
#include <osgText/Text>

#include <deque>
#include <string>
#include <utility>
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

/// Makes a text in a scene that faces the eye and has a dark edge, to be readable on any
/// background. OSG draws its letters half of \a size_px high.
osg::ref_ptr<osgText::Text> label(const std::string& content,
                                  const osg::Vec3& position,
                                  float size_px,
                                  const osg::Vec4& color,
                                  osgText::TextBase::AlignmentType alignment);

/// Makes such a text around \a position, \a size high in the scene's units, but at most as large as
/// the figures' letters.
osg::ref_ptr<osgText::Text> axisLabel(const std::string& content,
                                      const osg::Vec3& position,
                                      float size,
                                      const osg::Vec4& color);

/// Makes a rectangle that shows \a image, smoothed; \a turned swaps its axes.
osg::ref_ptr<osg::Geometry> picture(const osg::Vec2& lowerLeft,
                                    const osg::Vec2& upperRight,
                                    osg::Image* image,
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

/// Turns depth test and lighting off and blending on, and draws children in the order of their
/// addition.
void paintInOrder(osg::Node& node, int bin);

/// Returns at most \a atMost round values between \a from and \a to, 1, 2 or 5 times a power of ten
/// apart.
std::vector<double> ticks(double from, double to, int atMost);

/// Returns the label of a tick: no superfluous digits, thousands separated by a blank.
std::string number(double value);

/// Labels of a scale: positions (0 .. 1) and texts.
using Labels = std::vector<std::pair<double, std::string>>;

/// Returns at most \a atMost round numbers from 0 to \a high (> 0), which is at position 1.
Labels labelsTo(double high, int atMost);

/// Makes the scale of a colour map from 0 to \a high for a figure: an upright bar with numbers on
/// the right and the heading, which names quantity and unit, above. \a size: of the bar; pixels.
osg::ref_ptr<osg::Group> colorBar(const ColorMap& map,
                                  const std::string& heading,
                                  const osg::Vec2& lowerLeft,
                                  const osg::Vec2& size,
                                  double high,
                                  float textSize,
                                  const osg::Vec4& color);

/// Panel with frequently changing text and strokes, drawn in two draw calls whatever its content,
/// because the number of drawables costs time, not the pixels.
class TextPanel : public osg::Group
{
public:
    enum Align
    {
        LEFT,
        RIGHT,
        CENTER
    };

    TextPanel();

    /// Removes the content; finish() shows the change.
    void clear();
    /// Shows the content added since clear().
    void finish();

    Strokes& strokes() { return _strokes; }
    /// Adds \a content (UTF-8, one line) with its baseline at \a position, \a size pixels high.
    /// Returns its width.
    float text(const std::string& content,
               const osg::Vec2& position,
               float size,
               const osg::Vec4& color,
               Align align = LEFT);
    /// Returns the width that \a content would have.
    static float width(const std::string& content, float size);
    /// Returns \a content, with its end replaced by two dots if it is wider than \a width.
    static std::string fitted(const std::string& content, float size, float width);

private:
    void glyph(unsigned int code, const osg::Vec2& pen, float size, const osg::Vec4& color);

    Strokes _strokes;
    osg::ref_ptr<osg::Geometry> _shapes;
    osg::ref_ptr<osg::Geometry> _text;
    osg::ref_ptr<osg::Vec3Array> _corners;
    osg::ref_ptr<osg::Vec2Array> _coordinates;
    osg::ref_ptr<osg::Vec4Array> _colors;
    osg::ref_ptr<osg::Texture2D> _glyphs; ///< glyphs of the font
};

/// Upright scale of a colour map, with numbers on the right of the bar and the heading above.
struct Scale
{
    const ColorMap* map = nullptr;
    std::string heading;
    osg::Vec2 lowerLeft;
    osg::Vec2 size;
    Labels labels;

    void draw(TextPanel& sheet, float textSize, const osg::Vec4& color) const;
};

/// Small curve of a figure's last values from 0 to their maximum, with its name, the last value and
/// the maximum.
class Sparkline
{
public:
    /// \a unit is shown after each number.
    Sparkline(std::string name, std::string unit);

    void add(double value);
    void draw(TextPanel& sheet, const osg::Vec2& lowerLeft, const osg::Vec2& size) const;

private:
    static constexpr std::size_t kValues = 120;

    std::string _name;
    std::string _unit;
    std::deque<double> _values;
};

} // namespace osgMidair::pixels
