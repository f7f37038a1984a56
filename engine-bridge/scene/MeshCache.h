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

/// A part of a subtree as it is now, stretched as the scene has it and in metres.
struct CachedMesh
{
    std::uint64_t meshId = 0;     ///< new whenever anything about the mesh is
    std::uint64_t topologyId = 0; ///< new only when the triangles are: the same points can follow
    std::shared_ptr<const haptics::TriangleMesh> mesh;
    /// 0: what moves with the root; else the same number from frame to frame
    std::uint64_t part = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
};

/// Meshes by subtree and stretch, extracted once and again only when the subtree's fingerprint says
/// so.
///
/// A transform inside a subtree that is seen to move makes what is below it a part of its own from
/// then on: only its pose changes after that. Used on the thread that may read nodes. Between
/// beginFrame() and endFrame() ask for what this frame needs; what was not asked for in kKeptFrames
/// frames, and is held by nobody else, is forgotten. A frame in which no shape changed allocates
/// nothing.
class MeshCache
{
public:
    static constexpr int kKeptFrames = 600; ///< an object that blinks is not read again each time

    void beginFrame();

    /// Reads the subtree where it has changed and returns a number that is another one whenever its
    /// meshes are, or the transforms inside it: while it stays the same, so does what get() finds
    /// for the same matrix.
    std::uint64_t
    look(osg::Node& root, const ExtractOptions& options, std::vector<std::string>& warnings)
    {
        return lookAt(root, options, warnings).version;
    }

    /// The subtree's parts with their poses in \a out, which is cleared first. \a toArray maps the
    /// coordinates of \a root's children to the array, affine; its scale is baked into the meshes.
    /// Stretches that differ by under 1e-6 of their size count as the same (rounding while an
    /// object turns). Parts that can't be felt, and other warnings of an extraction, are told in \a
    /// warnings. \a options' movers and images are the cache's own affair. False, and nothing done,
    /// where \a toArray is singular, not finite or a perspective.
    bool get(osg::Node& root,
             const Eigen::Matrix4d& toArray,
             const ExtractOptions& options,
             std::vector<CachedMesh>& out,
             std::vector<std::string>& warnings);

    void endFrame();

    std::uint64_t extractions() const { return _extractions; }

private:
    struct Stretched
    {
        Eigen::Matrix3d stretch;
        std::uint64_t meshId = 0;
        std::shared_ptr<const haptics::TriangleMesh> mesh;
        std::uint64_t used = 0; ///< frame
    };
    struct Part
    {
        std::uint64_t key = 0;
        MeshFingerprint fingerprint;
        std::uint64_t topologyId = 0;
        haptics::TriangleMesh mesh;
        std::vector<Stretched> stretched;
    };
    struct Subtree
    {
        osg::ref_ptr<osg::Node> root; ///< alive, so that its address stays its own
        ExtractOptions options;       ///< with its movers
        ExtractedMesh extracted;      ///< its meshes are moved into parts
        MeshFingerprint fingerprint;
        std::vector<Part> parts; ///< as extracted.state.parts
        SubtreeState now;
        std::uint64_t version = 0;
        std::uint64_t poses = 0;                ///< of the movers, as a number
        std::uint64_t used = ~std::uint64_t(0); ///< frame
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
