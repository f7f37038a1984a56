#include "engine-bridge/scene/GeometryReader.h"

#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/drawn/TextOutlines.h"
#include "haptics/base/Limits.h"

#include <osg/Geometry>
#include <osg/TriangleFunctor>
#include <osg/TriangleIndexFunctor>
#include <osgAnimation/MorphGeometry>
#include <osgAnimation/MorphTransformHardware>
#include <osgAnimation/RigGeometry>
#include <osgAnimation/RigTransformHardware>

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Collects the indices of a geometry's triangles. Ignores strip triangles with two corners in one
/// place, which join two pieces and draw nothing on purpose.
struct TriangleIndices
{
    std::vector<Eigen::Vector3i> triangles;
    const Eigen::Matrix3Xd* vertices = nullptr;
    bool isStrip = false;

    void operator()(unsigned int a, unsigned int b, unsigned int c)
    {
        const Eigen::Vector3i corners(
            static_cast<int>(a), static_cast<int>(b), static_cast<int>(c));
        if (!isStrip || !isJoin(corners)) triangles.push_back(corners);
    }

private:
    bool isJoin(const Eigen::Vector3i& corners) const
    {
        if (corners.minCoeff() < 0 || corners.maxCoeff() >= vertices->cols()) return false;
        const auto same = [&](int i, int k)
        { return vertices->col(corners[i]) == vertices->col(corners[k]); };
        return same(0, 1) || same(1, 2) || same(2, 0);
    }
};

/// Appends the lines or points of the indices \a begin .. end of \a primitives, as triangles
/// without area. (OSG's functors read beyond the end of an odd number of indices.)
void appendLinesOrPoints(const PrimitiveCopy& primitives,
                         unsigned int begin,
                         unsigned int end,
                         std::vector<Eigen::Vector3i>& out)
{
    constexpr std::size_t kMost = base::kMostTriangles; // larger meshes are refused
    const GLenum mode = primitives.mode();
    const auto append = [&](unsigned int i, unsigned int k)
    {
        const auto b = static_cast<int>(primitives.index(k));
        out.emplace_back(static_cast<int>(primitives.index(i)), b, b);
    };
    if (mode == GL_POINTS)
        for (unsigned int i = begin; i < end && out.size() <= kMost; ++i)
            append(i, i);
    else
        for (unsigned int i = begin; i + 1 < end && out.size() <= kMost;
             i += mode == GL_LINES ? 2 : 1)
            append(i, i + 1);
    if (mode == GL_LINE_LOOP && end > begin + 2) append(end - 1, begin);
}

/// Collects the corners of a drawable's triangles, for osg::TriangleFunctor.
struct TriangleSoup
{
    std::vector<osg::Vec3> corners;
    void operator()(const osg::Vec3& a, const osg::Vec3& b, const osg::Vec3& c, bool = false)
    {
        corners.insert(corners.end(), {a, b, c});
    }
};

void readSoup(const osg::Drawable& drawable, MeshPiece& piece)
{
    osg::TriangleFunctor<TriangleSoup> functor;
    if (!drawable.supports(functor)) return;
    drawable.accept(functor);
    const auto& corners = functor.corners;
    piece.vertices.resize(3, static_cast<Eigen::Index>(corners.size()));
    for (std::size_t i = 0; i < corners.size(); ++i)
        piece.vertices.col(static_cast<Eigen::Index>(i)) = toEigen(osg::Vec3d(corners[i]));
    for (int i = 0; i + 2 < static_cast<int>(corners.size()); i += 3)
        piece.triangles.emplace_back(i, i + 1, i + 2);
}

} // namespace

std::string quoted(const osg::Object& object)
{
    return std::string(object.className()) +
           (object.getName().empty() ? std::string() : " '" + object.getName() + "'");
}

const osg::Object* deformerOf(const osg::Geometry& geometry)
{
    if (std::strcmp(geometry.libraryName(), "osgAnimation") != 0) return nullptr;
    if (const auto* rig = dynamic_cast<const osgAnimation::RigGeometry*>(&geometry))
        return rig->getRigTransformImplementation();
    if (const auto* morph = dynamic_cast<const osgAnimation::MorphGeometry*>(&geometry))
        return morph->getMorphTransformImplementation();
    return nullptr;
}

void GeometryReader::readText(const osgText::TextBase& text, MeshPiece& piece)
{
    _sources.emplace_back(text.getCoords().get());
    TextOutlines outlines = textOutlines(text);
    if (outlines.problem.empty() && _paint.source != PaintOptions::NONE)
        outlines.problem = "is text; it is felt unpainted";
    if (!outlines.problem.empty()) _warnings.push_back(quoted(text) + " " + outlines.problem);
    piece.vertices.resize(3, static_cast<Eigen::Index>(outlines.places.size()));
    for (std::size_t i = 0; i < outlines.places.size(); ++i)
        piece.vertices.col(static_cast<Eigen::Index>(i)) = toEigen(outlines.places[i]);
    for (const auto& [a, b] : outlines.lines)
        piece.triangles.emplace_back(a, b, b);
}

MeshPiece GeometryReader::readOther(const osg::Drawable& drawable)
{
    MeshPiece piece;
    if (const osgText::TextBase* text = textOf(drawable))
    {
        readText(*text, piece);
        return piece;
    }
    readSoup(drawable, piece);
    if (piece.triangles.empty())
        _warnings.push_back(quoted(drawable) + " has no triangles; it can't be felt");
    return piece;
}

void GeometryReader::checkSkinning(const osg::Geometry& geometry)
{
    const osg::Object* deformer = deformerOf(geometry);
    if (dynamic_cast<const osgAnimation::RigTransformHardware*>(deformer) ||
        dynamic_cast<const osgAnimation::MorphTransformHardware*>(deformer))
        _warnings.push_back(quoted(geometry) + " is deformed by the graphics card (" +
                            deformer->className() + "); it is felt in its rest pose");
    if (dynamic_cast<const osgAnimation::RigGeometry*>(&geometry) && !geometry.getVertexArray())
        _warnings.push_back(quoted(geometry) + " has no vertices before its first update");
}

GeometryCopy GeometryReader::begin(const osg::Geometry& geometry, const PaintState& state)
{
    checkSkinning(geometry);
    GeometryCopy copy;
    copy.name = quoted(geometry);
    const osg::Array* array = geometry.getVertexArray();
    if (!array) return copy;
    const auto vertices = std::make_shared<VertexCopy>(*array);
    if (!vertices->isKnown())
    {
        _warnings.push_back(copy.name + " has vertices of an unknown type (" + array->className() +
                            "); it can't be felt");
        return copy;
    }
    copy.surface = std::make_shared<SurfaceCopy>();
    _sources.emplace_back(array);
    for (const auto& primitives : geometry.getPrimitiveSetList())
    {
        _sources.emplace_back(primitives.get());
        copy.surface->primitives.emplace_back(*primitives);
        if (primitives->getNumInstances() > 1)
            _warnings.push_back(fmt::format(
                "{} is drawn {} times by instancing in a shader; it is felt once, as it is stored",
                copy.name,
                primitives->getNumInstances()));
        if (feltAs(primitives->getMode()) != Felt::NOT) continue;
        _warnings.push_back(fmt::format("{} has primitives of mode {:#x} (neither triangles, "
                                        "lines nor points); they can't be felt",
                                        copy.name,
                                        primitives->getMode()));
    }
    if (!copy.surface->mayBeFelt()) return copy;
    copy.vertices = vertices;
    beginPaint(geometry, state, *copy.surface);
    return copy;
}

void GeometryReader::beginPaint(const osg::Geometry& geometry,
                                const PaintState& state,
                                SurfaceCopy& surface)
{
    surface.paint = _paint;
    if (geometry.getColorArray() && _paint.source == PaintOptions::VERTEX_COLORS)
        _sources.emplace_back(geometry.getColorArray());
    if (_paint.source != PaintOptions::TEXTURE) return;
    if (!state.texture)
    {
        _warnings.push_back(quoted(geometry) + " has no texture in unit 0; it is felt unpainted");
        return;
    }
    if (state.isGenerated.value_or(false))
    {
        _warnings.push_back(quoted(geometry) +
                            " has texture coordinates that the graphics card makes (TexGen); it is "
                            "felt unpainted");
        return;
    }
    surface.isTextured = true;
    surface.isTurned = state.matrix != nullptr;
    if (state.matrix) surface.textureMatrix = state.matrix->getMatrix();
    _sources.emplace_back(state.texture);
    if (state.matrix) _sources.emplace_back(state.matrix);
    const osg::Array* coordinates = geometry.getTexCoordArray(0);
    if (!coordinates) return;
    _sources.emplace_back(coordinates);
    std::string warning;
    surface.image = _images.get(*state.texture, _paint, warning);
    if (!warning.empty()) _warnings.push_back(quoted(geometry) + ": " + warning);
}

namespace
{

void readPrimitives(const SurfaceCopy& surface, MeshPiece& piece)
{
    osg::TriangleIndexFunctor<TriangleIndices> triangles;
    std::vector<Eigen::Vector3i> flat;
    triangles.vertices = &piece.vertices;
    for (const PrimitiveCopy& primitives : surface.primitives)
    {
        const GLenum mode = primitives.mode();
        triangles.isStrip = mode == GL_TRIANGLE_STRIP || mode == GL_QUAD_STRIP;
        const Felt felt = feltAs(mode);
        if (felt == Felt::AS_TRIANGLES)
            primitives.accept(triangles);
        else if (felt == Felt::AS_LINES_OR_POINTS)
            primitives.eachRun([&](unsigned int begin, unsigned int end)
                               { appendLinesOrPoints(primitives, begin, end, flat); });
    }
    piece.triangles = std::move(triangles.triangles);
    piece.triangles.insert(piece.triangles.end(), flat.begin(), flat.end());
}

void readPaint(const GeometryCopy& copy, MeshPiece& piece, std::vector<std::string>& warnings)
{
    if (piece.triangles.empty()) return;
    const SurfaceCopy& surface = *copy.surface;
    const auto count = static_cast<std::size_t>(piece.vertices.cols());
    if (surface.paint.source == PaintOptions::VERTEX_COLORS)
    {
        if (surface.colors)
            piece.intensity = vertexIntensities(*surface.colors, count, surface.paint);
        if (piece.intensity.empty())
            warnings.push_back(copy.name + " has no vertex colours; it is felt unpainted");
    }
    if (!surface.isTextured) return;
    if (surface.coordinates)
        piece.coordinates = textureCoordinates(
            *surface.coordinates, count, surface.isTurned ? &surface.textureMatrix : nullptr);
    if (piece.coordinates.cols() == 0)
        warnings.push_back(copy.name +
                           " has no texture coordinates in unit 0; it is felt unpainted");
    else
        piece.image = surface.image;
}

} // namespace

MeshPiece pieceOf(const GeometryCopy& copy, std::vector<std::string>& warnings)
{
    MeshPiece piece;
    piece.vertices = copy.vertices->vertices();
    readPrimitives(*copy.surface, piece);
    const auto count = static_cast<int>(piece.vertices.cols());
    const auto last = std::remove_if(piece.triangles.begin(),
                                     piece.triangles.end(),
                                     [count](const Eigen::Vector3i& t)
                                     { return t.minCoeff() < 0 || t.maxCoeff() >= count; });
    if (last != piece.triangles.end())
    {
        warnings.push_back(
            fmt::format("{} has indices beyond its {} vertices; those triangles are left out",
                        copy.name,
                        count));
        piece.triangles.erase(last, piece.triangles.end());
    }
    readPaint(copy, piece, warnings);
    return piece;
}

} // namespace midair::bridge
