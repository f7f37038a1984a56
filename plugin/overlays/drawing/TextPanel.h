#pragma once

#include "plugin/overlays/drawing/PixelDrawing.h"

#include <osg/Group>
#include <osg/Texture2D>

#include <deque>
#include <string>

namespace osgMidair::pixels
{

/// Panel with text and strokes that change often, drawn in two draw calls whatever its content: the
/// number of drawables costs time, not the pixels.
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
    std::vector<std::pair<double, std::string>> labels; ///< position (0 .. 1) and text

    /// Sets the labels to round numbers from 0 to \a high, at most \a atMost.
    void label(double high, int atMost);
    void draw(TextPanel& sheet, float textSize, const osg::Vec4& color) const;
};

/// Small curve of the last values of a figure from 0 to their maximum, with its name, the last
/// value and the maximum.
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
