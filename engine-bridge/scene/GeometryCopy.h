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

/// Which bytes of two memories are compared: those of every \a parts th block, from the block \a
/// turn on, so that \a parts turns compare all.
struct ComparedBlocks
{
    std::size_t size = 0;  ///< bytes of either memory
    std::size_t block = 0; ///< bytes
    std::uint64_t parts = 1;
    std::uint64_t turn = 0;
};

bool isSame(const void* a, const void* b, const ComparedBlocks& which);

/// Bytes of an application's memory, copied at once or in slices. Not changed once it is whole, so
/// any thread may read it then.
class DataCopy
{
public:
    DataCopy() = default;
    explicit DataCopy(std::size_t size) :
        _bytes(size > 0 ? new std::byte[size] : nullptr), // not cleared first
        _size(size)
    {
    }

    /// Copies up to \a most of the bytes at \a data that are not copied yet; returns how many.
    std::size_t copyMore(const void* data, std::size_t most);
    bool isWhole() const { return _copied == _size; }
    std::size_t size() const { return _size; }
    const std::byte* data() const { return _bytes.get(); }

private:
    std::shared_ptr<std::byte[]> _bytes;
    std::size_t _size = 0;
    std::size_t _copied = 0;
};

/// How the vertices of a primitive set are felt.
enum class Felt
{
    AS_TRIANGLES,
    AS_LINES_OR_POINTS,
    NOT
};

Felt feltAs(GLenum mode);

/// A primitive set, with its indices copied as they are.
class PrimitiveCopy
{
public:
    /// Copies all of \a set but the indices; those come with copyMore().
    explicit PrimitiveCopy(const osg::PrimitiveSet& set);

    /// Returns false for kinds of which only a reference is kept (several draws in one, or those
    /// that the graphics card chooses): these are for the thread that may read nodes, at once.
    bool isPlain() const { return !_other; }
    GLenum mode() const { return _mode; }
    /// Returns false if it has too few indices for anything.
    bool mayBeFelt() const;
    std::size_t bytes() const { return _indices.size(); }

    /// Returns false if \a set is not of the copied kind and size.
    bool fits(const osg::PrimitiveSet& set) const;
    /// Copies up to \a most bytes of the indices of \a set, which must fit; returns how many.
    std::size_t copyMore(const osg::PrimitiveSet& set, std::size_t most);
    bool isWhole() const { return _indices.isWhole(); }
    /// Compares the indices with \a set: up to kAtOnce of them, of more a part of that size that \a
    /// turn selects.
    bool isStill(const osg::PrimitiveSet& set, std::uint64_t turn) const;
    static constexpr std::size_t kAtOnce = 4096;

    /// Calls \a functor as the set itself does.
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
    std::vector<GLsizei> _lengths; ///< of several rows; empty: one
    DataCopy _indices;
    osg::ref_ptr<const osg::PrimitiveSet> _other; ///< the set itself, of another kind
};

/// The vertices of one geometry, copied as they are, which takes a tenth of converting them.
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
    /// Compares the vertices with \a array, which must fit: all of them up to kAtOnce, of more a
    /// part of that size, spread over the array, that \a turn selects; parts() turns compare all.
    bool isStill(const osg::Array& array, std::uint64_t turn) const;
    std::uint64_t parts() const { return (size() + kAtOnce - 1) / kAtOnce; }

    static constexpr Eigen::Index kAtOnce = 4096;

private:
    std::size_t vertexBytes() const;

    osg::Array::Type _type;
    Eigen::Index _count = 0;
    DataCopy _data;
};

/// What makes a surface of a geometry's vertices: its primitives and its paint.
struct SurfaceCopy
{
    std::vector<PrimitiveCopy> primitives;
    PaintOptions paint;
    osg::ref_ptr<osg::Array> colors;      ///< own copy; null: none, or not asked for
    osg::ref_ptr<osg::Array> coordinates; ///< own copy of those of the texture, likewise
    bool isTextured = false;
    bool isTurned = false; ///< textureMatrix is not the identity
    osg::Matrixd textureMatrix;
    std::shared_ptr<const haptics::PaintImage> image;

    /// Returns true if any primitive may be felt.
    bool mayBeFelt() const;
    /// Compares indices and paint with \a geometry, from which they were copied: a part of each as
    /// large as VertexCopy compares, selected by \a turn. Pictures and their matrices don't count.
    bool isStill(const osg::Geometry& geometry, std::uint64_t turn) const;
};

/// A geometry, copied in slices: plain memory for any thread once it is whole.
struct GeometryCopy
{
    std::string name; ///< "Geometry 'lid'", for messages
    std::shared_ptr<VertexCopy> vertices;
    std::shared_ptr<SurfaceCopy> surface;

    /// Bytes to be copied in all.
    std::size_t bytes(const osg::Geometry& geometry) const;
    /// Returns false if \a geometry, from which it is copied, has other arrays by now.
    bool fits(const osg::Geometry& geometry) const;
    /// Copies more of \a geometry, which must fit, and takes that from \a budget, a number of
    /// bytes. Returns true if it is whole.
    bool copyMore(const osg::Geometry& geometry, std::size_t& budget) const;
};

} // namespace midair::bridge
