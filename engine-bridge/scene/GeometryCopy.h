#pragma once

#include "engine-bridge/scene/DataCopy.h"
#include "engine-bridge/scene/PaintReader.h"
#include "engine-bridge/scene/PrimitiveCopy.h"
#include "haptics/surface/SurfacePaint.h"

#include <osg/Array>
#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The vertices of one geometry, copied as they are, which takes a tenth of converting them.
class VertexCopy
{
public:
    /// Takes the type and number of \a array's vertices; copyMore() copies them. \a spares may be
    /// null.
    explicit VertexCopy(const osg::Array& array,
                        const std::shared_ptr<SpareMemory>& spares = nullptr);

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
