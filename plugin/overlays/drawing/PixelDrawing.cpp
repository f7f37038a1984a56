#include "plugin/overlays/drawing/PixelDrawing.h"

#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"

#include <osg/BlendFunc>
#include <osg/Texture2D>
#include <osgDB/FileUtils>
#include <osgDB/Options>

#include <algorithm>
#include <cmath>

namespace osgMidair::pixels
{

namespace
{

osg::ref_ptr<osg::Geometry>
geometryOf(osg::Vec3Array* vertices, osg::Vec4Array* colors, osg::Array::Binding binding)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(colors, binding);
    geometry->addPrimitiveSet(
        new osg::DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices->size())));
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    return geometry;
}

} // namespace

osg::ref_ptr<osgText::Font> font()
{
    // Paths of the font in Debian and other systems; the last one is searched in OSG's file path.
    static const osg::ref_ptr<osgText::Font> found = []
    {
        // A font object of our own, as the settings below must not change the application's.
        // Software OpenGL takes four times as long to filter with mipmaps and eight times with
        // anisotropy, and letters are drawn at about the size of their texels.
        const osg::ref_ptr<osgDB::Options> options = new osgDB::Options;
        options->setObjectCacheHint(osgDB::Options::CACHE_NONE);
        osg::ref_ptr<osgText::Font> made;
        for (const char* name : {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                 "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                 "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                 "fonts/DejaVuSans.ttf"})
            if (!osgDB::findDataFile(name).empty() &&
                (made = osgText::readRefFontFile(name, options)))
                break;
        if (!made) return osg::ref_ptr<osgText::Font>(osgText::Font::getDefaultFont());
        made->setMinFilterHint(osg::Texture::LINEAR);
        made->setMaxAnisotropy(1.0F);
        return made;
    }();
    return found;
}

osg::ref_ptr<osgText::Text> text(const std::string& content,
                                 const osg::Vec2& position,
                                 float size,
                                 const osg::Vec4& color,
                                 osgText::TextBase::AlignmentType alignment)
{
    osg::ref_ptr<osgText::Text> made = new osgText::Text;
    made->setFont(font());
    made->setFontResolution(32, 32);
    made->setCharacterSize(size);
    made->setPosition(osg::Vec3(position, 0.0F));
    made->setColor(color);
    made->setAlignment(alignment);
    made->setText(content, osgText::String::ENCODING_UTF8);
    made->setDataVariance(osg::Object::DYNAMIC);
    return made;
}

osg::ref_ptr<osg::Geometry>
rectangle(const osg::Vec2& lowerLeft, const osg::Vec2& upperRight, const osg::Vec4& color)
{
    const float x0 = lowerLeft.x();
    const float y0 = lowerLeft.y();
    const float x1 = upperRight.x();
    const float y1 = upperRight.y();
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const osg::Vec2& p : {osg::Vec2(x0, y0),
                               osg::Vec2(x1, y0),
                               osg::Vec2(x1, y1),
                               osg::Vec2(x0, y0),
                               osg::Vec2(x1, y1),
                               osg::Vec2(x0, y1)})
        vertices->push_back(osg::Vec3(p, 0.0F));
    osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array(1, &color);
    return geometryOf(vertices, colors, osg::Array::BIND_OVERALL);
}

osg::ref_ptr<osg::Geometry> picture(const osg::Vec2& lowerLeft,
                                    const osg::Vec2& upperRight,
                                    osg::Image* image,
                                    bool smooth,
                                    bool turned)
{
    osg::ref_ptr<osg::Geometry> made =
        rectangle(lowerLeft, upperRight, osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F));
    osg::ref_ptr<osg::Vec2Array> coordinates = new osg::Vec2Array;
    for (const osg::Vec2& p : {osg::Vec2(0, 0),
                               osg::Vec2(1, 0),
                               osg::Vec2(1, 1),
                               osg::Vec2(0, 0),
                               osg::Vec2(1, 1),
                               osg::Vec2(0, 1)})
        coordinates->push_back(turned ? osg::Vec2(p.y(), p.x()) : p);
    made->setTexCoordArray(0, coordinates, osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D(image);
    texture->setResizeNonPowerOfTwoHint(false);
    texture->setFilter(osg::Texture::MIN_FILTER,
                       smooth ? osg::Texture::LINEAR : osg::Texture::NEAREST);
    texture->setFilter(osg::Texture::MAG_FILTER,
                       smooth ? osg::Texture::LINEAR : osg::Texture::NEAREST);
    texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
    texture->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_EDGE);
    made->getOrCreateStateSet()->setTextureAttributeAndModes(0, texture);
    return made;
}

Strokes::Strokes() : _vertices(new osg::Vec3Array), _colors(new osg::Vec4Array) {}

void Strokes::triangle(const osg::Vec2& a,
                       const osg::Vec2& b,
                       const osg::Vec2& c,
                       const osg::Vec4& color)
{
    for (const osg::Vec2& p : {a, b, c})
    {
        _vertices->push_back(osg::Vec3(p, 0.0F));
        _colors->push_back(color);
    }
}

void Strokes::line(const osg::Vec2& from, const osg::Vec2& to, float width, const osg::Vec4& color)
{
    osg::Vec2 along = to - from;
    if (along.normalize() <= 0.0F) return;
    const osg::Vec2 side = osg::Vec2(-along.y(), along.x()) * (width / 2.0F);
    triangle(from - side, to - side, to + side, color);
    triangle(from - side, to + side, from + side, color);
}

void Strokes::frame(const osg::Vec2& lowerLeft,
                    const osg::Vec2& upperRight,
                    float width,
                    const osg::Vec4& color)
{
    const float h = width / 2.0F; // extends lines to the corners
    const float x0 = lowerLeft.x();
    const float y0 = lowerLeft.y();
    const float x1 = upperRight.x();
    const float y1 = upperRight.y();
    line({x0 - h, y0}, {x1 + h, y0}, width, color);
    line({x0 - h, y1}, {x1 + h, y1}, width, color);
    line({x0, y0}, {x0, y1}, width, color);
    line({x1, y0}, {x1, y1}, width, color);
}

void Strokes::rectangle(const osg::Vec2& lowerLeft,
                        const osg::Vec2& upperRight,
                        const osg::Vec4& color)
{
    const osg::Vec2 lowerRight(upperRight.x(), lowerLeft.y());
    const osg::Vec2 upperLeft(lowerLeft.x(), upperRight.y());
    triangle(lowerLeft, lowerRight, upperRight, color);
    triangle(lowerLeft, upperRight, upperLeft, color);
}

void Strokes::disc(const osg::Vec2& centre, float radius, const osg::Vec4& color)
{
    constexpr int kSides = 24;
    const auto rim = [&](int i)
    {
        const float angle =
            static_cast<float>(midair::base::kTwoPi) * static_cast<float>(i) / kSides;
        return centre + osg::Vec2(std::cos(angle), std::sin(angle)) * radius;
    };
    for (int i = 0; i < kSides; ++i)
        triangle(centre, rim(i), rim(i + 1), color);
}

osg::ref_ptr<osg::Geometry> Strokes::geometry()
{
    return geometryOf(_vertices, _colors, osg::Array::BIND_PER_VERTEX);
}

void Strokes::show(osg::Geometry& geometry)
{
    if (geometry.getVertexArray() != _vertices)
    {
        geometry.setVertexArray(_vertices);
        geometry.setColorArray(_colors, osg::Array::BIND_PER_VERTEX);
        geometry.removePrimitiveSet(0, geometry.getNumPrimitiveSets());
        geometry.addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 0));
    }
    _vertices->dirty();
    _colors->dirty();
    auto& triangles = static_cast<osg::DrawArrays&>(*geometry.getPrimitiveSet(0));
    triangles.setCount(static_cast<GLsizei>(_vertices->size()));
    triangles.dirty();
}

void Strokes::clear()
{
    _vertices->clear();
    _colors->clear();
}

void paintInOrder(osg::Node& node, int bin)
{
    osg::StateSet* state = node.getOrCreateStateSet();
    state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF | osg::StateAttribute::OVERRIDE);
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF | osg::StateAttribute::OVERRIDE);
    state->setAttributeAndModes(new osg::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA));
    state->setRenderBinDetails(bin, "TraversalOrderBin", osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
    node.setCullingActive(false);
}

std::vector<double> ticks(double from, double to, int atMost)
{
    if (!(to > from) || atMost < 1 || !std::isfinite(to - from)) return {};
    double step = std::pow(10.0, std::floor(std::log10((to - from) / atMost)));
    for (const double factor : {2.0, 2.5, 2.0, 2.0, 2.5, 2.0}) // 1, 2, 5, 10, 20, 50 ..
    {
        if (std::floor(to / step + 1e-9) - std::ceil(from / step - 1e-9) + 1.0 <= atMost) break;
        step *= factor;
    }
    std::vector<double> made;
    for (double i = std::ceil(from / step - 1e-9); i <= std::floor(to / step + 1e-9); i += 1.0)
        made.push_back(i * step);
    return made;
}

std::string number(double value)
{
    std::string made = midair::base::shortNumber(std::abs(value) < 1e-12 ? 0.0 : value);
    const std::size_t first = made.front() == '-' ? 1 : 0;
    const std::size_t whole = made.find_first_not_of("0123456789", first);
    const std::size_t end = whole == std::string::npos ? made.size() : whole;
    if (end - first > 4)
        for (std::size_t at = end - 3; at > first && at < end; at -= 3)
        {
            made.insert(at, " ");
            if (at < first + 3) break;
        }
    return made;
}

ColorBar::ColorBar(const ColorMap& map, const std::string& heading, const Layout& layout) :
    _layout(layout),
    _labels(new osg::Group)
{
    const bool upright = layout.size.y() > layout.size.x();
    const osg::Vec2 upper = layout.lowerLeft + layout.size;
    addChild(picture(layout.lowerLeft, upper, map.createImage(), true, upright));
    Strokes outline;
    osg::Vec4 thin = layout.textColor;
    thin.a() *= 0.7F;
    outline.frame(layout.lowerLeft, upper, 1.0F, thin);
    addChild(outline.geometry());
    addChild(
        text(heading,
             osg::Vec2(layout.lowerLeft.x(), upper.y() + (upright ? 1.0F : 0.6F) * layout.textSize),
             layout.textSize,
             layout.textColor));
    addChild(_labels);
}

void ColorBar::setRange(double low, double high)
{
    if (low == _low && high == _high) return;
    _low = low;
    _high = high;
    std::vector<std::pair<double, std::string>> labels;
    for (const double value : ticks(low, high, _layout.maxTicks))
        labels.emplace_back((value - low) / (high - low), number(value));
    setLabels(labels);
}

void ColorBar::setLabels(const std::vector<std::pair<double, std::string>>& labels)
{
    _labels->removeChildren(0, _labels->getNumChildren());
    const bool upright = _layout.size.y() > _layout.size.x();
    const float tick = 0.35F * _layout.textSize;
    Strokes strokes;
    for (const auto& [place, label] : labels)
    {
        const auto along = static_cast<float>(place);
        const osg::Vec2 at = upright ? osg::Vec2(_layout.lowerLeft.x() + _layout.size.x(),
                                                 _layout.lowerLeft.y() + along * _layout.size.y())
                                     : osg::Vec2(_layout.lowerLeft.x() + along * _layout.size.x(),
                                                 _layout.lowerLeft.y());
        const osg::Vec2 outward = upright ? osg::Vec2(tick, 0.0F) : osg::Vec2(0.0F, -tick);
        strokes.line(at, at + outward, 1.0F, _layout.textColor);
        _labels->addChild(
            text(label,
                 at + outward * 2.0F,
                 _layout.textSize,
                 _layout.textColor,
                 upright ? osgText::TextBase::LEFT_CENTER : osgText::TextBase::CENTER_TOP));
    }
    _labels->addChild(strokes.geometry());
}

} // namespace osgMidair::pixels
