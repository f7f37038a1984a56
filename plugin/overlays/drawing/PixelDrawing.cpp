#include "plugin/overlays/drawing/PixelDrawing.h"

#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osg/BlendFunc>
#include <osgDB/FileUtils>
#include <osgDB/Options>
#include <osgText/Font>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair::pixels
{

namespace
{

/// Height of a glyph in texels: twice the usual, to be sharp on screens of twice the density;
/// others average two by two texels. Large letters have separate glyphs.
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

osg::ref_ptr<osgText::Text> label(const std::string& content,
                                  const osg::Vec3& position,
                                  float size_px,
                                  const osg::Vec4& color,
                                  osgText::TextBase::AlignmentType alignment)
{
    osg::ref_ptr<osgText::Text> made = text(content, {}, size_px, color, alignment);
    made->setPosition(position);
    made->setAxisAlignment(osgText::TextBase::SCREEN);
    made->setCharacterSizeMode(osgText::TextBase::SCREEN_COORDS);
    made->setBackdropType(osgText::Text::OUTLINE);
    made->setBackdropColor({0.05F, 0.06F, 0.08F, 1.0F});
    return made;
}

osg::ref_ptr<osgText::Text>
axisLabel(const std::string& content, const osg::Vec3& position, float size, const osg::Vec4& color)
{
    osg::ref_ptr<osgText::Text> made =
        label(content, position, size, color, osgText::TextBase::CENTER_CENTER);
    made->setFontResolution(kResolution, kResolution);
    made->setCharacterSizeMode(
        osgText::TextBase::OBJECT_COORDS_WITH_MAXIMUM_SCREEN_SIZE_CAPPED_BY_FONT_HEIGHT);
    return made;
}

osg::ref_ptr<osg::Geometry>
picture(const osg::Vec2& lowerLeft, const osg::Vec2& upperRight, osg::Image* image, bool turned)
{
    const osg::Vec3 across(upperRight.x() - lowerLeft.x(), 0.0F, 0.0F);
    const osg::Vec3 up(0.0F, upperRight.y() - lowerLeft.y(), 0.0F);
    osg::ref_ptr<osg::Geometry> made = osg::createTexturedQuadGeometry(
        osg::Vec3(lowerLeft, 0.0F), turned ? up : across, turned ? across : up);
    made->setUseDisplayList(false);
    made->setUseVertexBufferObjects(true);
    made->getOrCreateStateSet()->setTextureAttributeAndModes(0, makeTexture(image, true));
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
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    show(*geometry);
    return geometry;
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

Labels labelsTo(double high, int atMost)
{
    Labels labels;
    for (const double value : ticks(0.0, high, atMost))
        labels.emplace_back(value / high, number(value));
    return labels;
}

osg::ref_ptr<osg::Group> colorBar(const ColorMap& map,
                                  const std::string& heading,
                                  const osg::Vec2& lowerLeft,
                                  const osg::Vec2& size,
                                  double high,
                                  float textSize,
                                  const osg::Vec4& color)
{
    const osg::ref_ptr<osg::Group> bar = new osg::Group;
    const osg::Vec2 upper = lowerLeft + size;
    bar->addChild(picture(lowerLeft, upper, map.createImage(), true));
    Strokes strokes;
    osg::Vec4 thin = color;
    thin.a() *= 0.7F;
    strokes.frame(lowerLeft, upper, 1.0F, thin);
    const osg::Vec2 tick(0.35F * textSize, 0.0F);
    for (const auto& [place, label] : labelsTo(high, 6))
    {
        const osg::Vec2 at(upper.x(), lowerLeft.y() + static_cast<float>(place) * size.y());
        strokes.line(at, at + tick, 1.0F, color);
        bar->addChild(
            text(label, at + tick * 2.0F, textSize, color, osgText::TextBase::LEFT_CENTER));
    }
    bar->addChild(strokes.geometry());
    bar->addChild(text(heading, {lowerLeft.x(), upper.y() + textSize}, textSize, color));
    return bar;
}

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
    // Computes the bound here, whose value doesn't matter, because views that cull at the same time
    // would each compute it.
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
