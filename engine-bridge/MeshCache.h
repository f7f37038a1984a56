#pragma once

#include "engine-bridge/MeshExtractor.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// A subtree's mesh as it is now, stretched and in metres.
struct CachedMesh
{
    std::uint64_t meshId = 0;     ///< new whenever anything about the mesh is
    std::uint64_t topologyId = 0; ///< new only when the triangles are: the same points can follow
    std::shared_ptr<const haptics::TriangleMesh> mesh;
};

/// Meshes by subtree and stretch, extracted once and again only when the subtree's fingerprint says so.
///
/// Used on the thread that may read nodes. Between beginFrame() and endFrame() ask for what this frame needs; what was not
/// asked for in kKeptFrames frames is forgotten. A frame in which no shape changed allocates nothing.
class MeshCache
{
public:
    static constexpr int kKeptFrames = 600; ///< an object that blinks is not read again each time

    void beginFrame();

    /// \a stretch maps the subtree's units to metres, scale baked in. Stretches that differ by under 1e-6 of their size
    /// count as the same (rounding while an object turns). Warnings of an extraction are added to \a warnings.
    CachedMesh get(osg::Node& root,
                   const Eigen::Matrix3d& stretch,
                   const ExtractOptions& options,
                   std::vector<std::string>& warnings);

    void endFrame();

    std::uint64_t extractions() const { return _extractions; }

private:
    struct Stretched
    {
        Eigen::Matrix3d stretch;
        CachedMesh cached;
        int unusedFrames = 0;
    };
    struct Subtree
    {
        osg::ref_ptr<osg::Node> root; ///< alive, so that its address stays its own
        bool intensityFromColors = false;
        ExtractedMesh extracted;
        std::uint64_t topologyId = 0;
        bool checked = false; ///< fingerprint taken this frame
        std::vector<Stretched> stretched;
    };

    void refresh(Subtree& subtree,
                 osg::Node& root,
                 const ExtractOptions& options,
                 std::vector<std::string>& warnings);

    static void forgetUnused(Subtree& subtree, int frames);

    std::unordered_map<const osg::Node*, Subtree> _subtrees;
    std::uint64_t _nextId = 1;
    std::uint64_t _extractions = 0;
};

} // namespace midair::bridge
