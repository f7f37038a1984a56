#pragma once

#include "engine-bridge/scene/SubtreeWalk.h"
#include "haptics/surface/TriangleMesh.h"

#include <osg/Matrixd>
#include <osg/Node>
#include <osg/ref_ptr>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Tells whether a mesh would come out the same; cheap enough to compare every frame. It covers
/// array and primitive-set pointers with their modified counts, the active children, and the
/// transforms in between but for movers. (dirtyBound() tells nothing of the kind.)
struct MeshFingerprint
{
    std::uint64_t topology = 0; ///< which triangles
    std::uint64_t vertices = 0; ///< where they are, and how they are painted

    bool operator==(const MeshFingerprint& other) const
    {
        return topology == other.topology && vertices == other.vertices;
    }
    bool operator!=(const MeshFingerprint& other) const { return !(*this == other); }
};

/// A part of a subtree that moves as one.
struct SubtreePart
{
    std::uint64_t key = 0; ///< 0: what moves with the root; else of the movers on the way
    MeshFingerprint fingerprint;
    osg::Matrixd toRoot; ///< its coordinates -> those of the root's children
};

/// A subtree as it is now.
struct SubtreeState
{
    std::vector<SubtreePart> parts; ///< at least that of the root
    /// Transforms that are no movers, in the order of the walk, with their matrices.
    std::vector<std::pair<const osg::Transform*, osg::Matrixd>> still;

    /// Of all parts together.
    MeshFingerprint fingerprint() const;
    /// Where the movers have brought their parts, as a number.
    std::uint64_t poses() const;
};

/// Reads the state of a subtree without copying any of it; allocates only while \a state grows.
/// Walks \a root's active children, whether or not a camera sees them; levels of detail count at
/// their finest.
void inspect(osg::Node& root, const ExtractOptions& options, SubtreeState& state);

/// inspect() for one look.
MeshFingerprint fingerprint(osg::Node& root, const ExtractOptions& options = {});

/// A subtree's triangles in scene units, a mesh a part, each in the part's own coordinates.
struct ExtractedMesh
{
    SubtreeState state;
    std::vector<haptics::TriangleMesh> parts; ///< as state.parts; may be empty meshes
    std::vector<std::string> warnings;        ///< what of the subtree can't be felt, and why
    /// Keeps what the fingerprints point at alive, so that no new array can take an old one's
    /// address.
    std::vector<osg::ref_ptr<const osg::Referenced>> sources;

    /// What moves with the root: all of it where there are no movers.
    const haptics::TriangleMesh& mesh() const { return parts.front(); }
};

/// Extracts the triangles of a subtree. Lines and points are left out, and so are cameras (what
/// they show is not where it is) and text.
ExtractedMesh extractMesh(osg::Node& root, const ExtractOptions& options = {});

} // namespace midair::bridge
