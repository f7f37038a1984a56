#pragma once

#include "engine-bridge/SharedMesh.h"
#include "engine-bridge/scene/MeshExtractor.h"
#include "engine-bridge/scene/SubtreeReading.h"
#include "haptics/base/threads/Mutex.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cstddef>
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
    SharedMesh mesh;
    /// 0: the part that moves with the root; others keep their number from frame to frame
    std::uint64_t part = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
};

/// Takes meshes that a cache has dropped, until whoever makes the next one frees those that nobody
/// uses: giving megabytes back to the system takes longer than a frame should wait. Any thread.
class MeshBin
{
public:
    void put(SharedMesh mesh);
    void freeUnused();

private:
    base::Mutex _mutex;
    std::vector<SharedMesh> _meshes MIDAIR_GUARDED_BY(_mutex);
};

/// Caches meshes by subtree and stretch; reads a subtree again only when its fingerprint has
/// changed.
///
/// It copies a large subtree in slices, kFrameBytes of all in a frame, and leaves the rest to
/// whoever looks at the mesh first. Until all is copied, the subtree keeps the meshes that it had,
/// none if it is new. A small subtree is copied at once; new ones take what they cost from the
/// frame's share, and once isFull() whoever has more new ones leaves them to later frames.
/// Where only vertices change, it copies them at once as they are. It also compares vertices,
/// indices and paint with the copies, for those that change without dirty(): up to
/// VertexCopy::kAtOnce in each frame, of larger arrays as many in turn, and of all subtrees
/// kComparedBytes, of more in turn, too.
class MeshCache
{
public:
    static constexpr int kKeptFrames = 600; ///< so that a blinking object isn't read each time
    /// Copied in slices a frame, and what new subtrees cost besides, in bytes that take as long: 2
    /// ms of a slow core together. What is looked at in a frame takes of it, too, but kLeastBytes.
    static constexpr std::size_t kFrameBytes = 5 * (std::size_t(1) << 16);
    static constexpr std::size_t kLeastBytes = kFrameBytes / 8;
    /// Left for small new ones where large ones are read.
    static constexpr std::size_t kBesideLarge = kFrameBytes / 4;
    static constexpr int kMostUnfinished = 8;          ///< large ones under way at a time
    static constexpr std::size_t kSubtreeWork = 12288; ///< of a new subtree, besides its bytes
    static constexpr std::size_t kLookWork = 512;      ///< of a subtree that is looked at
    static constexpr std::size_t kComparedBytes = std::size_t(1) << 20; ///< a frame
    /// A subtree with at most as many bytes is copied at once; as many bytes of small ones are made
    /// meshes at once in a frame, so that what can't be felt of them is told at once.
    static constexpr std::size_t kSmall = std::size_t(1) << 17;

    /// Shapes of a subtree that has one after the other, as below an osg::Sequence; larger ones are
    /// read anew.
    static constexpr std::size_t kKeptShapes = 16;
    static constexpr std::size_t kKeptBytes = std::size_t(1) << 22;

    /// \a inSlices: false copies every subtree at once.
    explicit MeshCache(bool inSlices = true) : _inSlices(inSlices) {}

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

    /// Returns true if the subtree has new meshes that are not copied yet.
    bool isBeingRead(const osg::Node& root) const
    {
        if (_last && _last->root == &root) return _last->reading != nullptr;
        const auto found = _subtrees.find(&root);
        return found != _subtrees.end() && found->second.reading;
    }

    /// Returns true if this frame's share is used up, or many large ones are under way: what else
    /// is new has to wait.
    bool isFull() const { return _budget.forNew == 0 || _budget.unfinished >= kMostUnfinished; }
    /// Takes \a work, in bytes that take as long to copy, from the frame's share.
    void spend(std::size_t work)
    {
        _budget.toCopy -= std::min(work, _budget.toCopy);
        _budget.forNew -= std::min(work, _budget.forNew);
    }

    /// The same of work that comes first, which leaves kLeastBytes.
    void spendBefore(std::size_t work)
    {
        spend(std::min(work, std::max(_budget.forNew, kLeastBytes) - kLeastBytes));
    }

    void endFrame();

    std::uint64_t extractions() const { return _extractions; }

private:
    /// A part's mesh with one stretch applied.
    struct Stretched
    {
        Eigen::Matrix3d stretch;
        std::uint64_t meshId = 0;
        SharedMesh mesh;
        std::uint64_t used = 0; ///< frame of the last use
    };
    /// A part of a subtree with its meshes.
    struct Part
    {
        std::uint64_t key = 0;
        MeshFingerprint fingerprint;
        std::uint64_t topologyId = 0;
        std::uint64_t mirroredId = 0; ///< topologyId of its mirror images
        SharedMesh mesh;              ///< as it was read
        bool isEmpty = false;         ///< nothing of it can be felt
        std::size_t bytes = 0;        ///< copied of the subtree that it is a part of
        /// newer vertices for that mesh; null: its own
        std::shared_ptr<const std::vector<PlacedCopy>> moved;
        std::vector<Stretched> stretched;
    };
    /// What is found out where a mesh is made.
    struct LateWarnings
    {
        base::Mutex mutex;
        std::vector<std::string> all MIDAIR_GUARDED_BY(mutex);
        std::atomic<bool> isAny{false};
    };
    /// What was read of a subtree.
    struct Shape
    {
        SubtreeState read;                 ///< when the parts were
        MeshFingerprint fingerprint;       ///< of that
        std::vector<Part> parts;           ///< in the order of read.parts
        std::vector<PartSources> vertices; ///< of the parts, likewise
        /// Keeps the objects in the fingerprints alive, so that no new array gets an old one's
        /// address.
        std::vector<osg::ref_ptr<const osg::Referenced>> sources;
        std::shared_ptr<LateWarnings> late; ///< null: all was made at once
    };
    /// A shape that a subtree had before.
    struct KeptShape
    {
        Shape shape;
        std::uint64_t used = 0; ///< last frame of its use
    };
    /// A subtree as it was read last, and its present state.
    struct Subtree
    {
        osg::ref_ptr<osg::Node> root; ///< kept alive, so that its address isn't reused
        ExtractOptions options;       ///< with its movers
        Shape shape;
        std::vector<KeptShape> kept;
        /// for each part: its vertices were changed without dirty()
        std::vector<bool> movedUnsaid;
        /// the same of its indices or paint
        std::vector<bool> changedUnsaid;
        SubtreeState now;                        ///< of the parts
        SubtreeState next;                       ///< in this frame
        std::unique_ptr<SubtreeReading> reading; ///< null: all is copied
        bool isRepainted = false;                ///< what is being read has other paint
        int restarts = 0; ///< readings that a change made of no use, and no success since
        std::uint64_t restarted = 0; ///< frame of the last
        std::uint64_t version = 0;
        std::uint64_t poses = 0;                ///< SubtreeState::poses()
        std::uint64_t turn = 0;                 ///< how often it was compared with its copies
        std::uint64_t used = ~std::uint64_t(0); ///< frame of the last use
    };

    Subtree&
    lookAt(osg::Node& root, const ExtractOptions& options, std::vector<std::string>& warnings);
    void refresh(Subtree& subtree,
                 osg::Node& root,
                 const ExtractOptions& options,
                 std::vector<std::string>& warnings);
    bool read(Subtree& subtree, std::vector<std::string>& warnings);
    void install(Subtree& subtree, bool isWholeAtOnce, std::vector<std::string>& warnings);
    void makeMesh(SubtreeReading& reading, std::size_t i, const Subtree& subtree, Part& part);
    const Stretched& stretchedTo(Part& part, const Eigen::Matrix3d& stretch);

    static bool findMovers(Subtree& subtree);
    bool mayCompare(const Subtree& subtree);
    bool lookForUnsaid(Subtree& subtree);
    bool follow(Subtree& subtree);
    void drop(Part& part) const;
    void keepShape(Subtree& subtree, const SubtreeState& next) const;
    bool recallShape(Subtree& subtree) const;
    void forgetShapes(Subtree& subtree) const;
    static void takeLateWarnings(Subtree& subtree, std::vector<std::string>& warnings);
    void forgetUnused(Part& part, std::uint64_t frames) const;

    /// Bytes that are left in this frame.
    struct Budget
    {
        std::size_t toCopy = 0; ///< in slices
        std::size_t forNew = 0; ///< at once, of what is new
        std::size_t toMake = 0; ///< meshes of, at once
        int unfinished = 0;     ///< subtrees of which a slice was copied, and not the last
    };
    /// Which subtrees are compared with their copies: from where the last frame had compared its
    /// share.
    struct Comparing
    {
        std::size_t place = 0; ///< of the next one in this frame
        std::size_t from = 0;  ///< the first that is compared in this frame
        std::size_t next = 0;  ///< the first of the next frame
        std::size_t left = 0;  ///< bytes
    };

    std::unordered_map<const osg::Node*, Subtree> _subtrees;
    const Subtree* _last = nullptr; ///< that was looked at
    PaintImages _images;
    const bool _inSlices;
    const std::shared_ptr<MeshBin> _bin = std::make_shared<MeshBin>();
    Comparing _comparing;
    Budget _budget;
    std::size_t _looks = 0; ///< subtrees that were looked at in this frame
    std::uint64_t _frame = 0;
    std::uint64_t _nextId = 1;
    std::uint64_t _extractions = 0;
};

} // namespace midair::bridge
