#include "engine-bridge/scene/GeometryReader.h"

#include "engine-bridge/scene/Convert.h"

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

/// Reads vertices from any of OSG's array types as doubles.
class VertexReader : public osg::ConstArrayVisitor
{
public:
    Eigen::Matrix3Xd vertices;
    bool understood = false;

    void apply(const osg::Vec2Array& a) override { read(a); }
    void apply(const osg::Vec3Array& a) override { read(a); }
    void apply(const osg::Vec4Array& a) override { read(a); }
    void apply(const osg::Vec2dArray& a) override { read(a); }
    void apply(const osg::Vec3dArray& a) override { read(a); }
    void apply(const osg::Vec4dArray& a) override { read(a); }

private:
    template<typename A>
    void read(const A& array)
    {
        constexpr int kSize = A::ElementDataType::num_components;
        vertices.resize(3, static_cast<Eigen::Index>(array.size()));
        for (std::size_t i = 0; i < array.size(); ++i)
        {
            const auto column = static_cast<Eigen::Index>(i);
            for (int k = 0; k < 3; ++k)
                vertices(k, column) = k < kSize ? static_cast<double>(array[i][k]) : 0.0;
        }
        understood = true;
    }
};

/// Collects the indices of a geometry's triangles, for osg::TriangleIndexFunctor.
struct TriangleIndices
{
    std::vector<Eigen::Vector3i> triangles;
    void operator()(unsigned int a, unsigned int b, unsigned int c)
    {
        triangles.emplace_back(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c));
    }
};

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

MeshPiece GeometryReader::read(const osg::Drawable& drawable, const PaintState& state)
{
    MeshPiece piece;
    const osg::Geometry* geometry = drawable.asGeometry();
    if (geometry)
        readGeometry(*geometry, state, piece);
    else if (std::strcmp(drawable.libraryName(), "osgText") != 0)
        readSoup(drawable, piece);
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

void GeometryReader::readGeometry(const osg::Geometry& geometry,
                                  const PaintState& state,
                                  MeshPiece& piece)
{
    checkSkinning(geometry);
    const osg::Array* array = geometry.getVertexArray();
    if (!array) return;
    VertexReader reader;
    array->accept(reader);
    if (!reader.understood)
    {
        _warnings.push_back(quoted(geometry) + " has vertices of an unknown type (" +
                            array->className() + "); it can't be felt");
        return;
    }
    piece.vertices = std::move(reader.vertices);
    osg::TriangleIndexFunctor<TriangleIndices> functor;
    geometry.accept(functor);
    piece.triangles = std::move(functor.triangles);
    const auto count = static_cast<int>(piece.vertices.cols());
    const auto last = std::remove_if(piece.triangles.begin(),
                                     piece.triangles.end(),
                                     [count](const Eigen::Vector3i& t)
                                     { return t.minCoeff() < 0 || t.maxCoeff() >= count; });
    if (last != piece.triangles.end())
    {
        _warnings.push_back(
            fmt::format("{} has indices beyond its {} vertices; those triangles are left out",
                        quoted(geometry),
                        count));
        piece.triangles.erase(last, piece.triangles.end());
    }
    readPaint(geometry, state, piece);
    _sources.emplace_back(array);
    for (const auto& primitives : geometry.getPrimitiveSetList())
        _sources.emplace_back(primitives.get());
}

void GeometryReader::readPaint(const osg::Geometry& geometry,
                               const PaintState& state,
                               MeshPiece& piece)
{
    const auto count = static_cast<std::size_t>(piece.vertices.cols());
    if (_paint.source == PaintOptions::TEXTURE) readTexture(geometry, state, piece);
    if (_paint.source != PaintOptions::VERTEX_COLORS) return;
    piece.intensity = vertexIntensities(geometry, count, _paint);
    if (piece.intensity.empty() && !piece.triangles.empty())
        _warnings.push_back(quoted(geometry) + " has no vertex colours; it is felt unpainted");
    if (geometry.getColorArray()) _sources.emplace_back(geometry.getColorArray());
}

void GeometryReader::readTexture(const osg::Geometry& geometry,
                                 const PaintState& state,
                                 MeshPiece& piece)
{
    if (piece.triangles.empty()) return;
    if (!state.texture)
    {
        _warnings.push_back(quoted(geometry) + " has no texture in unit 0; it is felt unpainted");
        return;
    }
    _sources.emplace_back(state.texture);
    if (state.matrix) _sources.emplace_back(state.matrix);
    if (geometry.getTexCoordArray(0)) _sources.emplace_back(geometry.getTexCoordArray(0));
    const auto count = static_cast<std::size_t>(piece.vertices.cols());
    piece.coordinates = textureCoordinates(geometry, count, state.matrix);
    if (piece.coordinates.cols() == 0)
    {
        _warnings.push_back(quoted(geometry) +
                            " has no texture coordinates in unit 0; it is felt unpainted");
        return;
    }
    std::string warning;
    piece.image = _images.get(*state.texture, _paint, warning);
    if (!warning.empty()) _warnings.push_back(quoted(geometry) + ": " + warning);
}

} // namespace midair::bridge
