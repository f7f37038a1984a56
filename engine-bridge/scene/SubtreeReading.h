#pragma once

#include "engine-bridge/scene/GeometryCopy.h"
#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/scene/MeshExtractor.h"
#include "engine-bridge/scene/SubtreeWalk.h"
#include "haptics/surface/TriangleMesh.h"

#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/Node>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Moves vertices by an affine \a matrix.
Eigen::Matrix3Xd transformed(const Eigen::Matrix3Xd& vertices, const osg::Matrixd& matrix);

/// A copy with its transform; plain memory, for any thread.
struct PlacedCopy
{
    std::shared_ptr<const VertexCopy> copy;
    osg::Matrixd matrix;  ///< geometry -> part
    bool isMoved = false; ///< matrix is not the identity
};

/// Returns the vertices of all \a copies in order, in the part's coordinates.
Eigen::Matrix3Xd joinedVertices(const std::vector<PlacedCopy>& copies);

/// A geometry from which a mesh was read. For the thread that may read nodes.
struct VertexSource
{
    osg::ref_ptr<const osg::Geometry> geometry;
    osg::ref_ptr<const osg::Array> array; ///< kept alive, so that its address isn't reused
    PlacedCopy placed;
    std::shared_ptr<const SurfaceCopy> surface; ///< data read with the first vertices

    /// Returns true if vertices changed without dirty(); see VertexCopy::isStill().
    bool hasMovedUnsaid(std::uint64_t turn) const;
    /// The same for indices and paint; see SurfaceCopy::isStill().
    bool hasChangedUnsaid(std::uint64_t turn) const
    {
        return surface && !surface->isStill(*geometry, turn);
    }
};

/// The geometries of a part's mesh, in the mesh's order.
struct PartSources
{
    std::vector<VertexSource> geometries;
    bool isComplete = true; ///< false: the mesh contains other drawables, too

    std::vector<PlacedCopy> copies() const;
};

/// Copies the subtree's vertices again into those \a parts for which \a wanted is true. Returns
/// false if the subtree has other geometries, or other numbers of vertices, than \a parts, which
/// are then useless.
bool copyVertices(osg::Node& root,
                  const ExtractOptions& options,
                  const std::vector<bool>& wanted,
                  std::vector<PartSources>& parts);

/// A drawable's copy, or its data if read at once, with its transform.
struct PlacedPiece
{
    GeometryCopy copy;
    MeshPiece read;       ///< for a drawable other than a geometry
    osg::Matrixd matrix;  ///< drawable -> part
    bool isMoved = false; ///< matrix is not the identity
};

/// Makes the mesh of a completely copied part; adds parts that can't be rendered to \a warnings.
/// Any thread, unless a piece has primitives that are not plain (PrimitiveCopy).
haptics::TriangleMesh meshOf(const std::vector<PlacedPiece>& pieces,
                             std::vector<std::string>& warnings);

/// Reads a subtree in slices: first copies, from which any thread may make the meshes. For the
/// thread that may read nodes.
class SubtreeReading
{
public:
    /// Collects what has to be copied. \a images must outlive it.
    SubtreeReading(osg::Node& root, const ExtractOptions& options, PaintImages& images);

    /// State at the beginning.
    const SubtreeState& state() const { return _state; }
    std::size_t bytes() const { return _bytes; } ///< total number of bytes to copy
    /// Returns false if only this thread can make the meshes of some parts.
    bool isPlain() const { return _isPlain; }

    /// Copies more, and subtracts the bytes from \a budget. Returns true when complete.
    bool copyMore(std::size_t& budget);
    /// Returns true if sources that aren't copied yet have other arrays now, so that they can't be.
    bool isStale() const;

    std::size_t parts() const { return _pieces.size(); } ///< as in state()
    /// Moves out the pieces of the part \a i. Call takeVertices() first.
    std::vector<PlacedPiece> takePieces(std::size_t i) { return std::move(_pieces[i]); }
    std::vector<std::string>& warnings() { return _warnings; }
    /// The geometries of each part, in the order of the pieces.
    std::vector<PartSources> takeVertices();
    std::vector<osg::ref_ptr<const osg::Referenced>>& sources() { return _sources; }

private:
    class Walk;

    SubtreeState _state;
    std::vector<std::vector<PlacedPiece>> _pieces; ///< by part
    /// by part: the geometries of the pieces; null for others
    std::vector<std::vector<osg::ref_ptr<const osg::Geometry>>> _geometries;
    std::vector<std::string> _warnings;
    std::vector<osg::ref_ptr<const osg::Referenced>> _sources;
    std::size_t _bytes = 0;
    bool _isPlain = true;
    std::size_t _part = 0; ///< being copied
    std::size_t _piece = 0;
};

} // namespace midair::bridge
