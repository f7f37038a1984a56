#pragma once

#include "engine-bridge/scene/MeshExtractor.h"
#include "engine-bridge/scene/SubtreeReading.h"
#include "haptics/surface/TriangleMesh.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// A subtree's triangles in scene units, one mesh per part, each in the part's own coordinates.
struct ExtractedMesh
{
    SubtreeState state;
    std::vector<haptics::TriangleMesh> parts; ///< in the order of state.parts; may be empty meshes
    std::vector<std::string> warnings;        ///< what in the subtree can't be felt, and why

    /// The part that moves with the root: the whole subtree if there are no movers.
    const haptics::TriangleMesh& mesh() const { return parts.front(); }
};

/// Extracts the triangles, lines and points of a subtree at once, and texts as the outlines of
/// their characters. Leaves out cameras, since what they show is elsewhere.
inline ExtractedMesh extractMesh(osg::Node& root, const ExtractOptions& options = {})
{
    PaintImages ownImages;
    SubtreeReading reading(root, options, options.images ? *options.images : ownImages);
    std::size_t budget = std::numeric_limits<std::size_t>::max();
    reading.copyMore(budget);
    ExtractedMesh out;
    out.state = reading.state();
    out.warnings = std::move(reading.warnings());
    for (std::size_t i = 0; i < reading.parts(); ++i)
        out.parts.push_back(meshOf(reading.takePieces(i), out.warnings));
    return out;
}

} // namespace midair::bridge
