#include "engine-bridge/scene/drawn/TextOutlines.h"

#include <osg/TriangleIndexFunctor>
#include <osgText/Font>
#include <osgText/Glyph>
#include <osgText/Text3D>
#include <osgText/Text>

#include <algorithm>
#include <cstring>
#include <map>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Lines between vertices in the plane of a text.
struct Lines
{
    std::vector<osg::Vec3> vertices;
    std::vector<std::pair<int, int>> ends;
    int withoutOutline = 0; ///< characters
};

/// Adds the outline of \a glyph, whose picture is drawn around \a middle; \a size: width and height
/// of a character that is 1 wide and 1 high in the font.
void addGlyph(osgText::Glyph& glyph, const osg::Vec2& middle, const osg::Vec2& size, Lines& out)
{
    if (glyph.getWidth() <= 0.0f || glyph.getHeight() <= 0.0f) return; // a blank
    osgText::Glyph3D* const solid =
        glyph.getFont()
            ? glyph.getFont()->getGlyph3D(glyph.getFontResolution(), glyph.getGlyphCode())
            : nullptr;
    const osg::Vec3Array* const raw = solid ? solid->getRawVertexArray() : nullptr;
    if (!raw || raw->empty())
    {
        ++out.withoutOutline;
        return;
    }
    // The picture's lower left corner is the outline's origin plus the bearing.
    const osg::Vec2 corner =
        osg::Vec2(0.5f * glyph.getWidth(), 0.5f * glyph.getHeight()) + glyph.getHorizontalBearing();
    const auto base = static_cast<int>(out.vertices.size());
    for (const osg::Vec3& v : *raw)
        out.vertices.emplace_back(middle.x() + (v.x() - corner.x()) * size.x(),
                                  middle.y() + (v.y() - corner.y()) * size.y(),
                                  0.0f);
    for (const auto& contour : solid->getRawFacePrimitiveSetList())
        for (unsigned int i = 0; i + 1 < contour->getNumIndices(); ++i)
            out.ends.emplace_back(base + static_cast<int>(contour->index(i)),
                                  base + static_cast<int>(contour->index(i + 1)));
}

// A flat text draws a picture of each character on a rectangle of two triangles.
void addFlat(const osgText::Text& text, Lines& out)
{
    constexpr unsigned int kCorners = 6;
    const osg::Vec3Array& coords = *text.getCoords();
    const osg::Vec2 size(text.getCharacterHeight() / text.getCharacterAspectRatio(),
                         text.getCharacterHeight());
    for (const auto& [texture, quads] : text.getTextureGlyphQuadMap())
        for (unsigned int i = 0; i < quads.getGlyphs().size(); ++i)
        {
            const osg::DrawElements* corners = quads._primitives.get();
            if (!corners || corners->getNumIndices() < kCorners * (i + 1)) break;
            osg::BoundingBox box;
            for (unsigned int k = kCorners * i; k < kCorners * (i + 1); ++k)
                if (corners->index(k) < coords.size()) box.expandBy(coords[corners->index(k)]);
            if (!box.valid()) continue;
            addGlyph(*quads.getGlyphs()[i], {box.center().x(), box.center().y()}, size, out);
        }
}

/// Collects the directed edges of triangles, for osg::TriangleIndexFunctor.
struct DirectedEdges
{
    std::vector<std::pair<int, int>> all;
    std::vector<int> welded; ///< for each vertex: the first in its place

    void operator()(unsigned int a, unsigned int b, unsigned int c)
    {
        if (std::max({a, b, c}) >= welded.size()) return;
        add(welded[a], welded[b]);
        add(welded[b], welded[c]);
        add(welded[c], welded[a]);
    }

private:
    void add(int from, int to)
    {
        if (from != to) all.emplace_back(from, to);
    }
};

/// Returns for each of \a vertices the first one in the same place.
std::vector<int> weldedIndices(const osg::Vec3Array& vertices)
{
    std::map<osg::Vec3, int> places;
    std::vector<int> welded;
    for (const osg::Vec3& vertex : vertices)
        welded.push_back(places.emplace(vertex, static_cast<int>(welded.size())).first->second);
    return welded;
}

// Uses the edges of the front face that belong to only one triangle.
void addSolid(const osgText::Text3D& text, Lines& out)
{
    // Protected in OSG, because only drawing needs it.
    struct Faces : osgText::Text3D
    {
        using osgText::Text3D::_frontPrimitiveSetList;
    };
    osg::TriangleIndexFunctor<DirectedEdges> edges;
    edges.welded = weldedIndices(*text.getCoords());
    for (const auto& front : text.*&Faces::_frontPrimitiveSetList)
        front->accept(edges);
    std::sort(edges.all.begin(), edges.all.end());
    out.vertices.assign(text.getCoords()->begin(), text.getCoords()->end());
    for (const auto& [a, b] : edges.all)
        if (!std::binary_search(edges.all.begin(), edges.all.end(), std::make_pair(b, a)))
            out.ends.emplace_back(a, b);
}

} // namespace

const osgText::TextBase* textOf(const osg::Drawable& drawable)
{
    if (std::strcmp(drawable.libraryName(), "osgText") != 0) return nullptr;
    return dynamic_cast<const osgText::TextBase*>(&drawable);
}

bool followsScreen(const osgText::TextBase& text)
{
    return text.getAutoRotateToScreen() || text.getAxisAlignment() == osgText::TextBase::SCREEN ||
           text.getCharacterSizeMode() != osgText::TextBase::OBJECT_COORDS;
}

TextOutlines textOutlines(const osgText::TextBase& text)
{
    TextOutlines found;
    if (followsScreen(text))
    {
        found.problem = "is text that turns or scales with the screen, so it has no place in the "
                        "world; it can't be felt";
        return found;
    }
    Lines lines;
    const bool isDrawn = text.getCoords() && (text.getDrawMode() & osgText::TextBase::TEXT) != 0;
    if (const auto* flat = dynamic_cast<const osgText::Text*>(&text); flat && isDrawn)
        addFlat(*flat, lines);
    if (const auto* solid = dynamic_cast<const osgText::Text3D*>(&text); solid && isDrawn)
        addSolid(*solid, lines);
    if (lines.withoutOutline > 0)
        found.problem =
            fmt::format("is text of which {} {} no outline in their font (a TrueType font "
                        "has them); they can't be felt",
                        lines.withoutOutline,
                        lines.withoutOutline == 1 ? "character has" : "characters have");
    else if (lines.ends.empty())
        found.problem = "is text without any character that is drawn; it can't be felt";
    for (const osg::Vec3& vertex : lines.vertices)
        found.places.push_back(osg::Vec3d(vertex) * text.getMatrix());
    found.lines = std::move(lines.ends);
    return found;
}

} // namespace midair::bridge
