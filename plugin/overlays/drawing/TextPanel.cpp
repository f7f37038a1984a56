#include "plugin/overlays/drawing/TextPanel.h"

#include <osg/Texture2D>
#include <osgText/Font>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair::pixels
{

namespace
{

/// Height of a glyph in texels: twice the usual, so that it is sharp on screens of twice the
/// density; others average two by two texels. Large letters have glyphs of their own.
constexpr unsigned int kResolution = 26;
constexpr unsigned int kLargeResolution = 64;
constexpr float kLarge = 20.0F;

std::vector<unsigned int> codesOf(const std::string& utf8)
{
    const osgText::String decoded(utf8, osgText::String::ENCODING_UTF8);
    return {decoded.begin(), decoded.end()};
}

osgText::Glyph* glyphOf(unsigned int code, float size)
{
    const unsigned int texels = size < kLarge ? kResolution : kLargeResolution;
    return font()->getGlyph({texels, texels}, code);
}

osg::ref_ptr<osg::Geometry> dynamicGeometry()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setDataVariance(osg::Object::DYNAMIC);
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    geometry->setCullingActive(false);
    return geometry;
}

std::string withUnit(double value, const std::string& unit)
{
    const int digits = value < 1.0 ? 2 : value < 100.0 ? 1 : 0;
    return fmt::format("{:.{}f} {}", value, digits, unit);
}

} // namespace

TextPanel::TextPanel() :
    _shapes(dynamicGeometry()),
    _text(dynamicGeometry()),
    _corners(new osg::Vec3Array),
    _coordinates(new osg::Vec2Array),
    _colors(new osg::Vec4Array)
{
    _text->setVertexArray(_corners);
    _text->setTexCoordArray(0, _coordinates, osg::Array::BIND_PER_VERTEX);
    _text->setColorArray(_colors, osg::Array::BIND_PER_VERTEX);
    _text->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, 0));
    addChild(_shapes);
    addChild(_text);
    finish();
    // The bound is computed here and doesn't matter: views that cull at the same time would each
    // compute it.
    getBound();
}

void TextPanel::clear()
{
    _strokes.clear();
    _corners->clear();
    _coordinates->clear();
    _colors->clear();
}

void TextPanel::finish()
{
    _strokes.show(*_shapes);
    _corners->dirty();
    _coordinates->dirty();
    _colors->dirty();
    auto& quads = static_cast<osg::DrawArrays&>(*_text->getPrimitiveSet(0));
    quads.setCount(static_cast<GLsizei>(_corners->size()));
    quads.dirty();
}

void TextPanel::glyph(unsigned int code, const osg::Vec2& pen, float size, const osg::Vec4& color)
{
    osgText::Glyph* glyph = glyphOf(code, size);
    if (!glyph || glyph->getWidth() <= 0.0F) return; // a space
    const osgText::Glyph::TextureInfo* info = glyph->getOrCreateTextureInfo(osgText::GREYSCALE);
    if (!info || !info->texture) return;
    if (!_glyphs)
    {
        _glyphs = info->texture;
        _text->getOrCreateStateSet()->setTextureAttributeAndModes(0, _glyphs);
    }
    if (info->texture != _glyphs)
        return; // only the first texture is used; some hundred glyphs fit into it
    // One texel more on every side, as smoothed edges extend beyond the glyph.
    const osg::Vec2 texels(
        (info->maxTexCoord.x() - info->minTexCoord.x()) * _glyphs->getTextureWidth(),
        (info->maxTexCoord.y() - info->minTexCoord.y()) * _glyphs->getTextureHeight());
    const osg::Vec2 extent = osg::Vec2(glyph->getWidth(), glyph->getHeight()) * size;
    const osg::Vec2 edge(extent.x() / texels.x(), extent.y() / texels.y());
    const osg::Vec2 texel(1.0F / static_cast<float>(_glyphs->getTextureWidth()),
                          1.0F / static_cast<float>(_glyphs->getTextureHeight()));
    const osg::Vec2 low = pen + glyph->getHorizontalBearing() * size - edge;
    const osg::Vec2 high = low + extent + edge * 2.0F;
    const osg::Vec2 from = info->minTexCoord - texel;
    const osg::Vec2 to = info->maxTexCoord + texel;
    const auto corner = [&](float x, float y, float s, float t)
    {
        _corners->push_back(osg::Vec3(x, y, 0.0F));
        _coordinates->push_back(osg::Vec2(s, t));
        _colors->push_back(color);
    };
    corner(low.x(), low.y(), from.x(), from.y());
    corner(high.x(), low.y(), to.x(), from.y());
    corner(high.x(), high.y(), to.x(), to.y());
    corner(low.x(), high.y(), from.x(), to.y());
}

float TextPanel::width(const std::string& content, float size)
{
    float sum = 0.0F;
    for (const unsigned int code : codesOf(content))
        if (const osgText::Glyph* glyph = glyphOf(code, size)) sum += glyph->getHorizontalAdvance();
    return sum * size;
}

std::string TextPanel::fitted(const std::string& content, float size, float width)
{
    if (TextPanel::width(content, size) <= width) return content;
    std::string shorter = content;
    while (!shorter.empty() && TextPanel::width(shorter + "..", size) > width)
    {
        // Removes whole characters, which may be several bytes in UTF-8.
        while (shorter.size() > 1 && (static_cast<unsigned char>(shorter.back()) & 0xC0) == 0x80)
            shorter.pop_back();
        shorter.pop_back();
    }
    return shorter + "..";
}

float TextPanel::text(const std::string& content,
                      const osg::Vec2& position,
                      float size,
                      const osg::Vec4& color,
                      Align align)
{
    const float wide = width(content, size);
    osg::Vec2 pen = position;
    if (align == RIGHT) pen.x() -= wide;
    if (align == CENTER) pen.x() -= 0.5F * wide;
    pen.set(std::round(pen.x()), std::round(pen.y())); // sharp where a unit is a pixel
    for (const unsigned int code : codesOf(content))
        if (const osgText::Glyph* found = glyphOf(code, size))
        {
            glyph(code, pen, size, color);
            pen.x() += found->getHorizontalAdvance() * size;
        }
    return wide;
}

void Scale::label(double high, int atMost)
{
    labels.clear();
    for (const double value : ticks(0.0, high, atMost))
        labels.emplace_back(value / high, number(value));
}

void Scale::draw(TextPanel& sheet, float textSize, const osg::Vec4& color) const
{
    constexpr int kBands = 64;
    const osg::Vec2 upper = lowerLeft + size;
    const float step = size.y() / kBands;
    for (int i = 0; i < kBands; ++i)
    {
        const float y = lowerLeft.y() + step * static_cast<float>(i);
        const osg::Vec3f band = map->color((static_cast<float>(i) + 0.5F) / kBands);
        sheet.strokes().rectangle({lowerLeft.x(), y}, {upper.x(), y + step}, {band, 1.0F});
    }
    osg::Vec4 thin = color;
    thin.a() *= 0.7F;
    sheet.strokes().frame(lowerLeft, upper, 1.0F, thin);
    sheet.text(heading, {lowerLeft.x(), upper.y() + 0.8F * textSize}, textSize, color);
    for (const auto& [place, label] : labels)
    {
        const osg::Vec2 at(upper.x(), lowerLeft.y() + static_cast<float>(place) * size.y());
        sheet.strokes().line(at, at + osg::Vec2(0.35F * textSize, 0.0F), 1.0F, color);
        sheet.text(label, at + osg::Vec2(0.7F, -0.36F) * textSize, textSize, color);
    }
}

Sparkline::Sparkline(std::string name, std::string unit) :
    _name(std::move(name)),
    _unit(std::move(unit))
{
}

void Sparkline::add(double value)
{
    if (!std::isfinite(value)) return;
    _values.push_back(value);
    if (_values.size() > kValues) _values.pop_front();
}

void Sparkline::draw(TextPanel& sheet, const osg::Vec2& lowerLeft, const osg::Vec2& size) const
{
    static const osg::Vec4 kCurve(0.55F, 0.85F, 0.95F, 1.0F);
    static const osg::Vec4 kDim(0.68F, 0.72F, 0.78F, 1.0F);
    constexpr float kTextSize = 12.0F;
    const float above = lowerLeft.y() + size.y() + 6.0F;
    sheet.strokes().line(
        lowerLeft, lowerLeft + osg::Vec2(size.x(), 0.0F), 1.0F, {0.45F, 0.48F, 0.54F, 0.8F});
    sheet.text(_name, {lowerLeft.x(), above}, kTextSize, kDim);
    if (_values.empty()) return;
    const double most = std::max(1e-9, *std::max_element(_values.begin(), _values.end()));
    const auto at = [&](std::size_t i)
    {
        return lowerLeft + osg::Vec2(size.x() * static_cast<float>(i + kValues - _values.size()) /
                                         (kValues - 1),
                                     size.y() * static_cast<float>(_values[i] / most));
    };
    for (std::size_t i = 1; i < _values.size(); ++i)
        sheet.strokes().line(at(i - 1), at(i), 1.5F, kCurve);
    sheet.text(withUnit(_values.back(), _unit),
               {lowerLeft.x() + size.x(), above},
               kTextSize,
               {1.0F, 1.0F, 1.0F, 1.0F},
               TextPanel::RIGHT);
    sheet.text("max " + withUnit(most, _unit),
               lowerLeft + osg::Vec2(size.x() + 8.0F, size.y() - 9.0F),
               11.0F,
               kDim);
}

} // namespace osgMidair::pixels
