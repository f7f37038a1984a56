#pragma once

#include "engine-bridge/scene/PaintReader.h"
#include "haptics/surface/SurfacePaint.h"

#include <osg/Array>
#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/PrimitiveSet>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Selects the bytes compared between two memories: every \a parts th block, starting at block \a
/// turn, so that \a parts turns compare all.
struct ComparedBlocks
{
    std::size_t size = 0;  ///< bytes of either memory
    std::size_t block = 0; ///< bytes
    std::uint64_t parts = 1;
    std::uint64_t turn = 0;
};

bool isSame(const void* a, const void* b, const ComparedBlocks& which);

/// Copies an application's memory, at once or in slices. Immutable once complete; then any thread
/// may read it.
class DataCopy
{
public:
    DataCopy() = default;
    explicit DataCopy(std::size_t size) :
        _bytes(size > 0 ? new std::byte[size] : nullptr), // not cleared first
        _size(size)
    {
    }

    /// Copies up to \a most of the bytes at \a data that aren't copied yet; returns their number.
    std::size_t copyMore(const void* data, std::size_t most);
    bool isWhole() const { return _copied == _size; }
    std::size_t size() const { return _size; }
    const std::byte* data() const { return _bytes.get(); }

private:
    std::shared_ptr<std::byte[]> _bytes;
    std::size_t _size = 0;
    std::size_t _copied = 0;
};

/// How the vertices of a primitive set are rendered.
enum class Felt
{
    AS_TRIANGLES,
    AS_LINES_OR_POINTS,
    NOT
};

Felt feltAs(GLenum mode);

/// A primitive set with a verbatim copy of its indices.
class PrimitiveCopy
{
public:
    /// Copies \a set except for the indices, which copyMore() copies.
    explicit PrimitiveCopy(const osg::PrimitiveSet& set);

    /// Returns false for kinds of which only a reference is kept (multi-draws, or draws chosen by
    /// the graphics card): these must be used at once by the thread that may read nodes.
    bool isPlain() const { return !_other; }
    GLenum mode() const { return _mode; }
    /// Returns false if it has too few indices for any primitive.
    bool mayBeFelt() const;
    std::size_t bytes() const { return _indices.size(); }

    /// Returns false if \a set is not of the copied kind and size.
    bool fits(const osg::PrimitiveSet& set) const;
    /// Copies up to \a most bytes of the indices of \a set, which must fit; returns how many.
    std::size_t copyMore(const osg::PrimitiveSet& set, std::size_t most);
    bool isWhole() const { return _indices.isWhole(); }
    /// Compares the indices with \a set: all if there are up to kAtOnce, otherwise a part of that
    /// size selected by \a turn.
    bool isStill(const osg::PrimitiveSet& set, std::uint64_t turn) const;
    static constexpr std::size_t kAtOnce = 4096;

    /// Calls \a functor like the set itself.
    void accept(osg::PrimitiveIndexFunctor& functor) const;
    /// Lines and points: calls \a add(begin, end) for each strip, loop or list of indices.
    template<class Add>
    void eachRun(const Add& add) const
    {
        unsigned int begin = 0;
        if (_lengths.empty()) return add(begin, numIndices());
        for (const GLsizei length : _lengths)
        {
            if (length <= 0) continue;
            add(begin, begin + static_cast<unsigned int>(length));
            begin += static_cast<unsigned int>(length);
        }
    }
    unsigned int numIndices() const;
    unsigned int index(unsigned int i) const;

private:
    std::size_t indexBytes() const;

    GLenum _mode = 0;
    osg::PrimitiveSet::Type _type = osg::PrimitiveSet::PrimitiveType;
    GLint _first = 0;              ///< without indices
    GLsizei _count = 0;            ///< without indices: number of vertices in a row
    std::vector<GLsizei> _lengths; ///< of several rows; empty: one row
    DataCopy _indices;
    osg::ref_ptr<const osg::PrimitiveSet> _other; ///< the set itself, if of another kind
};

/// A verbatim copy of the vertices of one geometry, which takes a tenth of the time of converting
/// them.
class VertexCopy
{
public:
    /// Takes the type and number of \a array's vertices; copyMore() copies them.
    explicit VertexCopy(const osg::Array& array);

    bool isKnown() const { return vertexBytes() > 0; } ///< false: not a type of vertices
    Eigen::Index size() const { return _count; }
    std::size_t bytes() const { return _data.size(); }
    /// Returns false if \a array is not of the copied type and size.
    bool fits(const osg::Array& array) const;
    /// Copies up to \a most bytes of \a array, which must fit; returns how many.
    std::size_t copyMore(const osg::Array& array, std::size_t most)
    {
        return _data.copyMore(array.getDataPointer(), most);
    }
    bool isWhole() const { return _data.isWhole(); }
    /// The vertices in the geometry's own coordinates.
    Eigen::Matrix3Xd vertices() const;
    /// Compares the vertices with \a array, which must fit: all if there are up to kAtOnce,
    /// otherwise a part of that size, spread over the array, selected by \a turn; parts() turns
    /// compare all.
    bool isStill(const osg::Array& array, std::uint64_t turn) const;
    std::uint64_t parts() const { return (size() + kAtOnce - 1) / kAtOnce; }

    static constexpr Eigen::Index kAtOnce = 4096;

private:
    std::size_t vertexBytes() const;

    osg::Array::Type _type;
    Eigen::Index _count = 0;
    DataCopy _data;
};

/// Input of a geometry's surface besides its vertices: its primitives and its paint.
struct SurfaceCopy
{
    std::vector<PrimitiveCopy> primitives;
    PaintOptions paint;
    osg::ref_ptr<osg::Array> colors;      ///< own copy; null: none, or not requested
    osg::ref_ptr<osg::Array> coordinates; ///< own copy of those of the texture, likewise
    bool isTextured = false;
    bool isTurned = false; ///< textureMatrix is not the identity
    osg::Matrixd textureMatrix;
    std::shared_ptr<const haptics::PaintImage> image;

    /// Returns true if any primitive may be rendered.
    bool mayBeFelt() const;
    /// Compares indices and paint with the source \a geometry: a part of each as large as
    /// VertexCopy compares, selected by \a turn. Ignores pictures and their matrices.
    bool isStill(const osg::Geometry& geometry, std::uint64_t turn) const;
};

/// A geometry, copied in slices: plain memory for any thread once complete.
struct GeometryCopy
{
    std::string name; ///< "Geometry 'lid'", for messages
    std::shared_ptr<VertexCopy> vertices;
    std::shared_ptr<SurfaceCopy> surface;

    /// Total number of bytes to copy.
    std::size_t bytes(const osg::Geometry& geometry) const;
    /// Returns false if the source \a geometry has other arrays now.
    bool fits(const osg::Geometry& geometry) const;
    /// Copies more of \a geometry, which must fit, and subtracts the bytes from \a budget. Returns
    /// true when complete.
    bool copyMore(const osg::Geometry& geometry, std::size_t& budget) const;
};

} // namespace midair::bridge
