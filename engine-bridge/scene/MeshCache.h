#pragma once

#include "engine-bridge/scene/MeshExtractor.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// A part of a subtree at this frame: its mesh in metres, scaled as in the scene, and its pose.
struct CachedMesh
{
    std::uint64_t meshId = 0;     ///< changes whenever the mesh changes
    std::uint64_t topologyId = 0; ///< changes only with the triangles; else samples can follow
    std::shared_ptr<const haptics::TriangleMesh> mesh;
    /// 0: the part that moves with the root; others keep their number from frame to frame
    std::uint64_t part = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
};

/// Caches meshes by subtree and stretch; extracts a subtree again only when its fingerprint has
/// changed.
///
/// Once a transform inside a subtree moves, the subtree below it becomes a part of its own, of
/// which only the pose changes from then on. To be used on the thread that may read nodes. Call
/// get() or look() between beginFrame() and endFrame(); meshes that were not asked for in
/// kKeptFrames frames, and that nothing else refers to, are dropped. A frame in which no shape
/// changed allocates nothing.
class MeshCache
{
public:
    static constexpr int kKeptFrames = 600; ///< so that a blinking object isn't read each time

    void beginFrame();

    /// Reads the subtree again if it has changed. Returns a number that changes with its meshes and
    /// with the transforms inside it; while it is the same, get() gives the same result for the
    /// same matrix.
    std::uint64_t
    look(osg::Node& root, const ExtractOptions& options, std::vector<std::string>& warnings)
    {
        return lookAt(root, options, warnings).version;
    }

    /// Puts the subtree's parts with their poses into \a out, which is cleared first. The affine
    /// \a toArray maps the coordinates of \a root's children to the array; its scale is baked into
    /// the meshes. Stretches that differ by under 1e-6 of their size count as the same (rounding
    /// while an object turns). Parts that can't be felt, and other warnings of an extraction, are
    /// added to \a warnings. Ignores \a options' movers and images. Returns false, with \a out
    /// empty, if \a toArray is singular, not finite or a perspective.
    bool get(osg::Node& root,
             const Eigen::Matrix4d& toArray,
             const ExtractOptions& options,
             std::vector<CachedMesh>& out,
             std::vector<std::string>& warnings);

    void endFrame();

    std::uint64_t extractions() const { return _extractions; }

private:
    /// A part's mesh with one stretch applied.
    struct Stretched
    {
        Eigen::Matrix3d stretch;
        std::uint64_t meshId = 0;
        std::shared_ptr<const haptics::TriangleMesh> mesh;
        std::uint64_t used = 0; ///< frame of the last use
    };
    /// A part of a subtree with its meshes.
    struct Part
    {
        std::uint64_t key = 0;
        MeshFingerprint fingerprint;
        std::uint64_t topologyId = 0;
        haptics::TriangleMesh mesh;
        std::vector<Stretched> stretched;
    };
    /// A subtree as it was extracted last, and its present state.
    struct Subtree
    {
        osg::ref_ptr<osg::Node> root; ///< kept alive, so that its address isn't reused
        ExtractOptions options;       ///< with its movers
        ExtractedMesh extracted;      ///< its meshes are moved into parts
        MeshFingerprint fingerprint;
        std::vector<Part> parts; ///< in the order of extracted.state.parts
        SubtreeState now;
        std::uint64_t version = 0;
        std::uint64_t poses = 0;                ///< SubtreeState::poses()
        std::uint64_t used = ~std::uint64_t(0); ///< frame of the last use
    };

    Subtree&
    lookAt(osg::Node& root, const ExtractOptions& options, std::vector<std::string>& warnings);
    void refresh(Subtree& subtree,
                 osg::Node& root,
                 const ExtractOptions& options,
                 std::vector<std::string>& warnings);
    void extract(Subtree& subtree, std::vector<std::string>& warnings);
    const Stretched& stretchedTo(Part& part, const Eigen::Matrix3d& stretch);

    static bool findMovers(Subtree& subtree);
    void forgetUnused(Part& part, std::uint64_t frames) const;

    std::unordered_map<const osg::Node*, Subtree> _subtrees;
    PaintImages _images;
    std::uint64_t _frame = 0;
    std::uint64_t _nextId = 1;
    std::uint64_t _extractions = 0;
};

} // namespace midair::bridge
