#include "engine-bridge/scene/GeometryCopy.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace midair::bridge
{

namespace
{

using osg::PrimitiveSet;

/// Indices that the smallest primitive of \a mode needs.
GLsizei leastIndices(GLenum mode)
{
    switch (mode)
    {
    case GL_POINTS:
        return 1;
    case GL_LINES:
    case GL_LINE_STRIP:
    case GL_LINE_LOOP:
        return 2;
    case GL_QUADS:
    case GL_QUAD_STRIP:
        return 4;
    default:
        return 3;
    }
}

/// Elements compared in a row, a few cache lines: a local change of an array is found soon.
constexpr std::size_t kBlock = 16;

/// Components of a vertex, and the size of each; 0: not a vertex type.
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

/// A private copy of \a array: any thread may read and release it.
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
    // The fingerprint detects another array, or a missing one.
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

Felt feltAs(GLenum mode)
{
    switch (mode)
    {
    case GL_POINTS:
    case GL_LINES:
    case GL_LINE_STRIP:
    case GL_LINE_LOOP:
        return Felt::AS_LINES_OR_POINTS;
    case GL_TRIANGLES:
    case GL_TRIANGLE_STRIP:
    case GL_TRIANGLE_FAN:
    case GL_QUADS:
    case GL_QUAD_STRIP:
    case GL_POLYGON:
        return Felt::AS_TRIANGLES;
    default:
        return Felt::NOT;
    }
}

PrimitiveCopy::PrimitiveCopy(const PrimitiveSet& set) : _mode(set.getMode()), _type(set.getType())
{
    switch (_type)
    {
    case PrimitiveSet::DrawArraysPrimitiveType:
        _first = static_cast<const osg::DrawArrays&>(set).getFirst();
        _count = static_cast<const osg::DrawArrays&>(set).getCount();
        break;
    case PrimitiveSet::DrawArrayLengthsPrimitiveType:
    {
        const auto& rows = static_cast<const osg::DrawArrayLengths&>(set);
        _first = rows.getFirst();
        _lengths.assign(rows.begin(), rows.end());
        break;
    }
    case PrimitiveSet::DrawElementsUBytePrimitiveType:
    case PrimitiveSet::DrawElementsUShortPrimitiveType:
    case PrimitiveSet::DrawElementsUIntPrimitiveType:
        _indices = DataCopy(set.getTotalDataSize());
        break;
    default:
        _other = &set;
    }
}

std::size_t PrimitiveCopy::indexBytes() const
{
    return _type == PrimitiveSet::DrawElementsUIntPrimitiveType     ? sizeof(GLuint)
           : _type == PrimitiveSet::DrawElementsUShortPrimitiveType ? sizeof(GLushort)
                                                                    : sizeof(GLubyte);
}

bool PrimitiveCopy::mayBeFelt() const
{
    if (feltAs(_mode) == Felt::NOT) return false;
    const GLsizei least = leastIndices(_mode);
    if (_lengths.empty()) return numIndices() >= static_cast<unsigned int>(least);
    return *std::max_element(_lengths.begin(), _lengths.end()) >= least;
}

bool PrimitiveCopy::fits(const PrimitiveSet& set) const
{
    return set.getType() == _type && set.getMode() == _mode &&
           (_other || set.getTotalDataSize() == _indices.size());
}

std::size_t PrimitiveCopy::copyMore(const PrimitiveSet& set, std::size_t most)
{
    return _indices.copyMore(set.getDataPointer(), most);
}

bool PrimitiveCopy::isStill(const PrimitiveSet& set, std::uint64_t turn) const
{
    if (!fits(set)) return false;
    switch (_type)
    {
    case PrimitiveSet::DrawArraysPrimitiveType:
        return static_cast<const osg::DrawArrays&>(set).getFirst() == _first &&
               static_cast<const osg::DrawArrays&>(set).getCount() == _count;
    case PrimitiveSet::DrawArrayLengthsPrimitiveType:
    {
        const auto& rows = static_cast<const osg::DrawArrayLengths&>(set);
        return rows.getFirst() == _first &&
               std::equal(rows.begin(), rows.end(), _lengths.begin(), _lengths.end());
    }
    default:
        // 64 indices: a few cache lines
        return isSame(_indices.data(),
                      set.getDataPointer(),
                      {_indices.size(),
                       64 * indexBytes(),
                       (_indices.size() / indexBytes() + kAtOnce - 1) / kAtOnce,
                       turn});
    }
}

void PrimitiveCopy::accept(osg::PrimitiveIndexFunctor& functor) const
{
    if (_other) return _other->accept(functor);
    const auto count = static_cast<GLsizei>(numIndices());
    GLint first = _first;
    switch (_type)
    {
    case PrimitiveSet::DrawArraysPrimitiveType:
        return functor.drawArrays(_mode, first, count);
    case PrimitiveSet::DrawArrayLengthsPrimitiveType:
        for (const GLsizei length : _lengths)
        {
            functor.drawArrays(_mode, first, length);
            // Sums beyond an int belong to indices that no geometry has.
            first = static_cast<GLint>(static_cast<GLuint>(first) + static_cast<GLuint>(length));
        }
        return;
    default:
        break;
    }
    if (count == 0) return;
    const std::byte* data = _indices.data();
    if (_type == PrimitiveSet::DrawElementsUIntPrimitiveType)
        functor.drawElements(_mode, count, reinterpret_cast<const GLuint*>(data));
    else if (_type == PrimitiveSet::DrawElementsUShortPrimitiveType)
        functor.drawElements(_mode, count, reinterpret_cast<const GLushort*>(data));
    else
        functor.drawElements(_mode, count, reinterpret_cast<const GLubyte*>(data));
}

unsigned int PrimitiveCopy::numIndices() const
{
    if (_other) return _other->getNumIndices();
    if (_type == PrimitiveSet::DrawArrayLengthsPrimitiveType)
        return static_cast<unsigned int>(std::max<std::int64_t>(
            0, std::accumulate(_lengths.begin(), _lengths.end(), std::int64_t{0})));
    if (_type == PrimitiveSet::DrawArraysPrimitiveType)
        return static_cast<unsigned int>(std::max(_count, 0));
    return static_cast<unsigned int>(_indices.size() / indexBytes());
}

unsigned int PrimitiveCopy::index(unsigned int i) const
{
    if (_other) return _other->index(i);
    const std::byte* data = _indices.data();
    switch (_type)
    {
    case PrimitiveSet::DrawElementsUIntPrimitiveType:
        return reinterpret_cast<const GLuint*>(data)[i];
    case PrimitiveSet::DrawElementsUShortPrimitiveType:
        return reinterpret_cast<const GLushort*>(data)[i];
    case PrimitiveSet::DrawElementsUBytePrimitiveType:
        return reinterpret_cast<const GLubyte*>(data)[i];
    default:
        return static_cast<unsigned int>(_first) + i;
    }
}

bool isSame(const void* a, const void* b, const ComparedBlocks& which)
{
    const std::uint64_t parts = std::max<std::uint64_t>(which.parts, 1);
    for (std::size_t at = which.block * (which.turn % parts); at < which.size;
         at += which.block * parts)
        if (std::memcmp(static_cast<const std::byte*>(a) + at,
                        static_cast<const std::byte*>(b) + at,
                        std::min(which.block, which.size - at)) != 0)
            return false;
    return true;
}

std::size_t DataCopy::copyMore(const void* data, std::size_t most)
{
    const std::size_t now = std::min(most, _size - _copied);
    if (now > 0)
        std::memcpy(_bytes.get() + _copied, static_cast<const std::byte*>(data) + _copied, now);
    _copied += now;
    return now;
}

VertexCopy::VertexCopy(const osg::Array& array) : _type(array.getType())
{
    if (vertexBytes() == 0) return;
    _count = static_cast<Eigen::Index>(array.getNumElements());
    _data = DataCopy(static_cast<std::size_t>(_count) * vertexBytes());
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
    // The fingerprint detects another number of sets.
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
