#include "engine-bridge/scene/PrimitiveCopy.h"

#include <algorithm>
#include <cstdint>
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

PrimitiveCopy::PrimitiveCopy(const PrimitiveSet& set, const std::shared_ptr<SpareMemory>& spares) :
    _mode(set.getMode()),
    _type(set.getType())
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
        _indices = DataCopy(set.getTotalDataSize(), spares);
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
            // A sum beyond an int is of indices that no geometry has.
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

} // namespace midair::bridge
