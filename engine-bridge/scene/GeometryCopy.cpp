#include "engine-bridge/scene/GeometryCopy.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

/// Elements that are compared in a row, a few cache lines: what changes in one place of an array is
/// soon met.
constexpr std::size_t kBlock = 16;

/// Components of a vertex, and the size of each; 0: no type of vertices.
struct Layout
{
    int components = 0;
    bool isDouble = false;
};

Layout layoutOf(osg::Array::Type type)
{
    switch (type)
    {
    case osg::Array::Vec2ArrayType:
        return {2, false};
    case osg::Array::Vec3ArrayType:
        return {3, false};
    case osg::Array::Vec4ArrayType:
        return {4, false};
    case osg::Array::Vec2dArrayType:
        return {2, true};
    case osg::Array::Vec3dArrayType:
        return {3, true};
    case osg::Array::Vec4dArrayType:
        return {4, true};
    default:
        return {};
    }
}

template<class Number>
Eigen::Matrix3Xd widened(const std::byte* bytes, int components, Eigen::Index count)
{
    const Eigen::Map<const Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>> stored(
        reinterpret_cast<const Number*>(bytes), components, count);
    const int kept = std::min(components, 3);
    Eigen::Matrix3Xd vertices(3, count);
    vertices.topRows(kept) = stored.topRows(kept).template cast<double>();
    vertices.bottomRows(3 - kept).setZero();
    return vertices;
}

/// A copy of \a array that is nobody else's: any thread may read it and let go of it.
osg::ref_ptr<osg::Array> ownCopy(const osg::Array& array)
{
    osg::ref_ptr<osg::Array> own = osg::clone(&array, osg::CopyOp::DEEP_COPY_ARRAYS);
    if (!own) return own;
    own->setUserDataContainer(nullptr);
    own->setModifiedCallback(nullptr);
    return own;
}

const osg::Array* colorsOf(const osg::Geometry& geometry, const SurfaceCopy& surface)
{
    return surface.paint.source == PaintOptions::VERTEX_COLORS ? geometry.getColorArray() : nullptr;
}

const osg::Array* coordinatesOf(const osg::Geometry& geometry, const SurfaceCopy& surface)
{
    return surface.isTextured ? geometry.getTexCoordArray(0) : nullptr;
}

std::size_t bytesOf(const osg::Array* array)
{
    return array ? array->getTotalDataSize() : 0;
}

bool isStillPaint(const osg::Array* own, const osg::Array* array, std::uint64_t turn)
{
    // Another array, or none, shows in the fingerprint.
    if (!own || !array) return true;
    if (own->getType() != array->getType() || own->getBinding() != array->getBinding() ||
        bytesOf(own) != bytesOf(array))
        return false;
    const auto count = static_cast<std::uint64_t>(own->getNumElements());
    constexpr auto kAtOnce = static_cast<std::uint64_t>(VertexCopy::kAtOnce);
    return isSame(
        own->getDataPointer(),
        array->getDataPointer(),
        {bytesOf(own), kBlock * own->getElementSize(), (count + kAtOnce - 1) / kAtOnce, turn});
}

} // namespace

VertexCopy::VertexCopy(const osg::Array& array, const std::shared_ptr<SpareMemory>& spares) :
    _type(array.getType())
{
    if (vertexBytes() == 0) return;
    _count = static_cast<Eigen::Index>(array.getNumElements());
    _data = DataCopy(static_cast<std::size_t>(_count) * vertexBytes(), spares);
}

bool VertexCopy::fits(const osg::Array& array) const
{
    return array.getType() == _type && static_cast<Eigen::Index>(array.getNumElements()) == _count;
}

std::size_t VertexCopy::vertexBytes() const
{
    const Layout layout = layoutOf(_type);
    return static_cast<std::size_t>(layout.components) *
           (layout.isDouble ? sizeof(double) : sizeof(float));
}

Eigen::Matrix3Xd VertexCopy::vertices() const
{
    const Layout layout = layoutOf(_type);
    if (_count == 0) return Eigen::Matrix3Xd(3, 0);
    return layout.isDouble ? widened<double>(_data.data(), layout.components, _count)
                           : widened<float>(_data.data(), layout.components, _count);
}

bool VertexCopy::isStill(const osg::Array& array, std::uint64_t turn) const
{
    return isSame(_data.data(),
                  array.getDataPointer(),
                  {_data.size(), kBlock * vertexBytes(), parts(), turn});
}

bool SurfaceCopy::mayBeFelt() const
{
    return std::any_of(primitives.begin(),
                       primitives.end(),
                       [](const PrimitiveCopy& one) { return one.mayBeFelt(); });
}

bool SurfaceCopy::isStill(const osg::Geometry& geometry, std::uint64_t turn) const
{
    // Another number of sets shows in the fingerprint.
    const auto& sets = geometry.getPrimitiveSetList();
    for (std::size_t i = 0; i < std::min(sets.size(), primitives.size()); ++i)
        if (!primitives[i].isStill(*sets[i], turn)) return false;
    return isStillPaint(colors, colorsOf(geometry, *this), turn) &&
           isStillPaint(coordinates, coordinatesOf(geometry, *this), turn);
}

std::size_t GeometryCopy::bytes(const osg::Geometry& geometry) const
{
    std::size_t all = vertices->bytes() + bytesOf(colorsOf(geometry, *surface)) +
                      bytesOf(coordinatesOf(geometry, *surface));
    for (const PrimitiveCopy& one : surface->primitives)
        all += one.bytes();
    return all;
}

bool GeometryCopy::fits(const osg::Geometry& geometry) const
{
    const auto& sets = geometry.getPrimitiveSetList();
    return geometry.getVertexArray() && vertices->fits(*geometry.getVertexArray()) &&
           std::equal(sets.begin(),
                      sets.end(),
                      surface->primitives.begin(),
                      surface->primitives.end(),
                      [](const auto& set, const PrimitiveCopy& one) { return one.fits(*set); });
}

bool GeometryCopy::copyMore(const osg::Geometry& geometry, std::size_t& budget) const
{
    const auto paint = [&](osg::ref_ptr<osg::Array>& own, const osg::Array* array)
    {
        if (own || !array || budget == 0) return own || !array;
        own = ownCopy(*array);
        budget -= std::min(bytesOf(array), budget);
        return true;
    };
    if (!paint(surface->colors, colorsOf(geometry, *surface)) ||
        !paint(surface->coordinates, coordinatesOf(geometry, *surface)))
        return false;
    const auto& sets = geometry.getPrimitiveSetList();
    for (std::size_t i = 0; i < sets.size(); ++i)
    {
        PrimitiveCopy& one = surface->primitives[i];
        budget -= one.copyMore(*sets[i], budget);
        if (!one.isWhole()) return false;
    }
    budget -= vertices->copyMore(*geometry.getVertexArray(), budget);
    return vertices->isWhole();
}

} // namespace midair::bridge
