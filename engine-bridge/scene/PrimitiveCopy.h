#pragma once

#include "engine-bridge/scene/DataCopy.h"

#include <osg/PrimitiveSet>
#include <osg/ref_ptr>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

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
    /// Copies all of \a set but the indices; those come with copyMore(). \a spares may be null.
    PrimitiveCopy(const osg::PrimitiveSet& set, const std::shared_ptr<SpareMemory>& spares);

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

} // namespace midair::bridge
