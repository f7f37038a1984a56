#pragma once

#include "plugin/overlays/PixelDrawing.h"

#include <osg/Group>
#include <osg/Texture2D>

#include <deque>
#include <string>

namespace osgMidair::pixels
{

/// Text and strokes that change often, in two draw calls however much is on it: what costs time is
/// not the pixels but the number of drawables.
class OSGMIDAIR_EXPORT TextPanel : public osg::Group
{
public:
    enum Align
    {
        LEFT,
        RIGHT,
        CENTER
    };

    TextPanel();

    /// What is put on it from now on replaces what was there.
    void clear();
    /// Shows what was put on it since clear().
    void finish();

    Strokes& strokes() { return _strokes; }
    /// \a content (UTF-8, one line) with its baseline at \a position, \a size pixels high; returns
    /// how wide it is.
    float text(const std::string& content,
               const osg::Vec2& position,
               float size,
               const osg::Vec4& color,
               Align align = LEFT);
    /// How wide \a content would be.
    static float width(const std::string& content, float size);
    /// \a content, its end replaced by two dots if it is wider than \a width.
    static std::string fitted(const std::string& content, float size, float width);

private:
    void glyph(unsigned int code, const osg::Vec2& pen, float size, const osg::Vec4& color);

    Strokes _strokes;
    osg::ref_ptr<osg::Geometry> _shapes;
    osg::ref_ptr<osg::Geometry> _text;
    osg::ref_ptr<osg::Vec3Array> _corners;
    osg::ref_ptr<osg::Vec2Array> _coordinates;
    osg::ref_ptr<osg::Vec4Array> _colors;
    osg::ref_ptr<osg::Texture2D> _glyphs; ///< all of a font's glyphs that are used
};

/// A map with its scale, upright: numbers on the right of the bar, the heading above.
struct Scale
{
    const ColorMap* map = nullptr;
    std::string heading;
    osg::Vec2 lowerLeft;
    osg::Vec2 size;
    std::vector<std::pair<double, std::string>> labels; ///< place (0 .. 1) and text

    /// Round numbers from 0 to \a high.
    void label(double high, int atMost);
    void draw(TextPanel& sheet, float textSize, const osg::Vec4& color) const;
};

/// The last values of a figure as a small curve from 0 to their maximum, with its name, the last
/// value and the maximum.
class OSGMIDAIR_EXPORT Sparkline
{
public:
    /// \a unit follows every number.
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
