#pragma once

#include "haptics/TriangleMesh.h"

#include <osg/Node>
#include <osg/ref_ptr>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// What of a subtree becomes the mesh.
struct ExtractOptions
{
    bool intensityFromColors =
        false; ///< brightness of vertex colours (0 .. 1) becomes TriangleMesh::intensity
    unsigned int traversalMask = ~0u; ///< nodes whose mask has none of these bits are left out
    std::function<bool(const osg::Node&)> skip; ///< subtrees to leave out; empty: none
};

/// What a mesh was made from, cheap to compare every frame: array and primitive-set pointers with their modified
/// counts, the active children, the transforms in between. (dirtyBound() tells nothing of the kind.)
struct MeshFingerprint
{
    std::uint64_t topology = 0; ///< which triangles
    std::uint64_t vertices = 0; ///< where they are

    bool operator==(const MeshFingerprint& other) const
    {
        return topology == other.topology && vertices == other.vertices;
    }
    bool operator!=(const MeshFingerprint& other) const { return !(*this == other); }
};

/// Without copying or allocating anything. Reads \a root's active children, whether or not a camera sees them:
/// levels of detail count at their finest.
MeshFingerprint fingerprint(osg::Node& root, const ExtractOptions& options = {});

/// A subtree's triangles in scene units and in the frame of \a root's children, with inner transforms baked in.
struct ExtractedMesh
{
    haptics::TriangleMesh mesh;
    MeshFingerprint fingerprint;
    std::vector<std::string> warnings; ///< what of the subtree can't be felt, and why
    /// Keeps what the fingerprint points at alive, so that no new array can take an old one's address.
    std::vector<osg::ref_ptr<const osg::Referenced>> sources;
};

/// Lines and points are left out, and so are cameras (what they show is not where it is) and text.
ExtractedMesh extractMesh(osg::Node& root, const ExtractOptions& options = {});

} // namespace midair::bridge
