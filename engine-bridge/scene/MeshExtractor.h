#pragma once

#include "engine-bridge/scene/SubtreeWalk.h"
#include "haptics/surface/TriangleMesh.h"

#include <osg/Matrixd>
#include <osg/Node>

#include <cstdint>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Hashes that are equal as long as extraction gives the same mesh; cheap enough for every frame.
/// They cover array and primitive-set pointers with their modified counts, the active children, and
/// the transforms in between except movers. (dirtyBound() doesn't reveal such changes.)
struct MeshFingerprint
{
    std::uint64_t topology = 0; ///< of the triangles
    std::uint64_t vertices = 0; ///< of the vertices
    std::uint64_t paint = 0;    ///< of the paint

    bool operator==(const MeshFingerprint& other) const
    {
        return topology == other.topology && vertices == other.vertices && paint == other.paint;
    }
    bool operator!=(const MeshFingerprint& other) const { return !(*this == other); }
};

/// A part of a subtree that moves rigidly.
struct SubtreePart
{
    std::uint64_t key = 0; ///< identifies the path to its mover; 0: moves with the root
    MeshFingerprint fingerprint;
    osg::Matrixd toRoot; ///< its coordinates -> those of the root's children
};

/// The parts of a subtree and its transforms at one time.
struct SubtreeState
{
    std::vector<SubtreePart> parts; ///< at least the root's
    /// Transforms that are not movers, in the order of the walk, with their matrices.
    std::vector<std::pair<const osg::Transform*, osg::Matrixd>> still;

    /// The fingerprint of all parts together.
    MeshFingerprint fingerprint() const;
    /// A hash of the matrices of all parts.
    std::uint64_t poses() const;
};

/// Reads the state of a subtree into \a state without copying geometry; allocates only while \a
/// state grows. Walks \a root's active children, whether or not a camera sees them; uses the finest
/// level of detail.
void inspect(osg::Node& root, const ExtractOptions& options, SubtreeState& state);

/// The fingerprint of a subtree by inspect().
MeshFingerprint fingerprint(osg::Node& root, const ExtractOptions& options = {});

} // namespace midair::bridge
