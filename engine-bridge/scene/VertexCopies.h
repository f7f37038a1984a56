#pragma once

#include "engine-bridge/scene/GeometryCopy.h"
#include "engine-bridge/scene/SubtreeWalk.h"

#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// Moves vertices by an affine \a matrix.
Eigen::Matrix3Xd transformed(const Eigen::Matrix3Xd& vertices, const osg::Matrixd& matrix);

/// A copy and where it belongs; plain memory, for any thread.
struct PlacedCopy
{
    std::shared_ptr<const VertexCopy> copy;
    osg::Matrixd matrix;  ///< geometry -> part
    bool isMoved = false; ///< matrix is not the identity
};

/// The vertices of all \a copies, one after the other, in the part's coordinates.
Eigen::Matrix3Xd joinedVertices(const std::vector<PlacedCopy>& copies);

/// A geometry of which a mesh was read. For the thread that may read nodes.
struct VertexSource
{
    osg::ref_ptr<const osg::Geometry> geometry;
    osg::ref_ptr<const osg::Array> array; ///< kept alive, so that its address isn't reused
    PlacedCopy placed;
    std::shared_ptr<const SurfaceCopy> surface; ///< what was read with the first vertices

    /// Returns true if vertices are other than those copied though nobody called dirty(); see
    /// VertexCopy::isStill().
    bool hasMovedUnsaid(std::uint64_t turn) const;
    /// The same of indices and paint; see SurfaceCopy::isStill().
    bool hasChangedUnsaid(std::uint64_t turn) const
    {
        return surface && !surface->isStill(*geometry, turn);
    }
};

/// The geometries of a part's mesh, in the mesh's order.
struct PartSources
{
    std::vector<VertexSource> geometries;
    bool isComplete = true; ///< false: other drawables are in the mesh too

    std::vector<PlacedCopy> copies() const;
};

/// Copies the vertices of the subtree anew into \a parts, those of parts for which \a wanted is
/// true. Returns false if the subtree has other geometries, or other numbers of vertices, than
/// \a parts, which are then of no use. \a spares may be null.
bool copyVertices(osg::Node& root,
                  const ExtractOptions& options,
                  const std::vector<bool>& wanted,
                  const std::shared_ptr<SpareMemory>& spares,
                  std::vector<PartSources>& parts);

} // namespace midair::bridge
