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

/// A part of a subtree in this frame: its mesh in metres, scaled as in the scene, and its pose.
struct CachedMesh
{
    std::uint64_t meshId = 0;     ///< changes with the mesh
    std::uint64_t topologyId = 0; ///< changes only with the triangles; otherwise samples can follow
    SharedMesh mesh;
    /// 0: the part that moves with the root; others keep their number
    std::uint64_t part = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
};

/// Collects dropped meshes of a cache, until the maker of the next one frees the unused ones:
/// returning megabytes to the system takes longer than a frame should wait. Any thread.
class MeshBin
{
public:
    void put(SharedMesh mesh);
    void freeUnused();

private:
    base::Mutex _mutex;
    std::vector<SharedMesh> _meshes MIDAIR_GUARDED_BY(_mutex);
};

/// Caches meshes by subtree and stretch; reads a subtree again only when its fingerprint changed.
///
/// Copies a large subtree in slices, kFrameBytes in total per frame; the first user of the mesh
/// does the rest. Until the copy is complete, the subtree keeps its earlier meshes (none if it is
/// new). Small subtrees are copied at once; new ones use the frame's budget, and once isFull() the
/// caller leaves more new ones to later frames. If only vertices change, they are copied at once.
/// It also compares vertices, indices and paint with the copies, to detect changes without dirty():
/// up to VertexCopy::kAtOnce in each frame, a rotating part of larger arrays, and kComparedBytes of
/// all subtrees in total, in turn.
/// kComparedBytes, of more in turn, too.
class MeshCache
{
public:
    static constexpr int kKeptFrames = 600; ///< so that a blinking object isn't read each time
    /// Budget per frame for slices, and for new subtrees, in bytes that take as long: together 2 ms
    /// of a slow core. Looking at subtrees also uses it, except for kLeastBytes.
    static constexpr std::size_t kFrameBytes = 5 * (std::size_t(1) << 16);
    static constexpr std::size_t kLeastBytes = kFrameBytes / 8;
    /// Reserved for small new subtrees while large ones are read.
    static constexpr std::size_t kBesideLarge = kFrameBytes / 4;
    static constexpr int kMostUnfinished = 8;          ///< limit of large subtrees being copied
    static constexpr std::size_t kSubtreeWork = 12288; ///< cost of a new subtree besides its bytes
    static constexpr std::size_t kLookWork = 512;      ///< cost of looking at a subtree
    static constexpr std::size_t kComparedBytes = std::size_t(1) << 20; ///< per frame
    /// Largest subtree that is copied at once; this many bytes of small ones are also made into
    /// meshes at once per frame, so that parts that can't be rendered are reported at once.
    static constexpr std::size_t kSmall = std::size_t(1) << 17;

    /// Number of kept shapes of a subtree that alternates, as below an osg::Sequence; larger ones
    /// are read again.
    static constexpr std::size_t kKeptShapes = 16;
    static constexpr std::size_t kKeptBytes = std::size_t(1) << 22;

    /// \a inSlices: false copies every subtree at once.
    explicit MeshCache(bool inSlices = true) : _inSlices(inSlices) {}

    void beginFrame();

    /// Reads the subtree again if it has changed. Returns a number that changes with its meshes and
    /// inner transforms; while it is equal, get() gives the same result for the same matrix.
    std::uint64_t
    look(osg::Node& root, const ExtractOptions& options, std::vector<std::string>& warnings)
    {
        return lookAt(root, options, warnings).version;
    }

    /// Stores the subtree's parts with their poses in \a out, which is cleared first. The affine \a
    /// toArray maps the coordinates of \a root's children to the array; its scale is baked into the
    /// meshes. Stretches that differ by less than 1e-6 of their size count as equal (rounding while
    /// an object turns). Adds parts that can't be rendered and other warnings to \a warnings.
    /// Ignores \a options' movers and images. Returns false, with \a out empty, if \a toArray is
    /// singular, not finite or a perspective.
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

    /// Returns true if this frame's budget is used up, or many large subtrees are being copied:
    /// other new ones have to wait.
    bool isFull() const { return _budget.forNew == 0 || _budget.unfinished >= kMostUnfinished; }
    /// Subtracts \a work, in bytes that take as long to copy, from the frame's budget.
    void spend(std::size_t work)
    {
        _budget.toCopy -= std::min(work, _budget.toCopy);
        _budget.forNew -= std::min(work, _budget.forNew);
    }

    /// The same for work that comes first; leaves kLeastBytes.
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
    /// A part of a subtree and its meshes.
    struct Part
    {
        std::uint64_t key = 0;
        MeshFingerprint fingerprint;
        std::uint64_t topologyId = 0;
        std::uint64_t mirroredId = 0; ///< topologyId of its mirror images
        SharedMesh mesh;              ///< as read
        bool isEmpty = false;         ///< nothing of it can be rendered
        std::size_t bytes = 0;        ///< copied for its subtree
        /// newer vertices for that mesh; null: its own
        std::shared_ptr<const std::vector<PlacedCopy>> moved;
        std::vector<Stretched> stretched;
    };
    /// Warnings found when a mesh is made.
    struct LateWarnings
    {
        base::Mutex mutex;
        std::vector<std::string> all MIDAIR_GUARDED_BY(mutex);
        std::atomic<bool> isAny{false};
    };
    /// Data read from a subtree.
    struct Shape
    {
        SubtreeState read;                 ///< when the parts were
        MeshFingerprint fingerprint;       ///< of that
        std::vector<Part> parts;           ///< in the order of read.parts
        std::vector<PartSources> vertices; ///< of the parts, in the same order
        /// Keeps the objects in the fingerprints alive, so that no new array gets an old one's
        /// address.
        std::vector<osg::ref_ptr<const osg::Referenced>> sources;
        std::shared_ptr<LateWarnings> late; ///< null: all was made at once
    };
    /// An earlier shape of a subtree.
    struct KeptShape
    {
        Shape shape;
        std::uint64_t used = 0; ///< last frame of its use
    };
    /// A subtree as last read, and its present state.
    struct Subtree
    {
        osg::ref_ptr<osg::Node> root; ///< kept alive, so that its address isn't reused
        ExtractOptions options;       ///< with its movers
        Shape shape;
        std::vector<KeptShape> kept;
        /// for each part: its vertices changed without dirty()
        std::vector<bool> movedUnsaid;
        /// the same for its indices or paint
        std::vector<bool> changedUnsaid;
        SubtreeState now;                        ///< state of the parts
        SubtreeState next;                       ///< state in this frame
        std::unique_ptr<SubtreeReading> reading; ///< null: all is copied
        bool isRepainted = false;                ///< the running reading has other paint
        int restarts = 0;            ///< consecutive readings that a change made useless
        std::uint64_t restarted = 0; ///< frame of the last one
        std::uint64_t version = 0;
        std::uint64_t poses = 0;                ///< SubtreeState::poses()
        std::uint64_t turn = 0;                 ///< number of comparisons with its copies
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

    /// Bytes left in this frame.
    struct Budget
    {
        std::size_t toCopy = 0; ///< in slices
        std::size_t forNew = 0; ///< at once, of new subtrees
        std::size_t toMake = 0; ///< meshes of, at once
        int unfinished = 0;     ///< subtrees with only a part of their slices copied
    };
    /// Selects the subtrees compared with their copies, continuing where the last frame's budget
    /// ended.
    struct Comparing
    {
        std::size_t place = 0; ///< index of the next one in this frame
        std::size_t from = 0;  ///< first one compared in this frame
        std::size_t next = 0;  ///< first one of the next frame
        std::size_t left = 0;  ///< bytes
    };

    std::unordered_map<const osg::Node*, Subtree> _subtrees;
    const Subtree* _last = nullptr; ///< the last one looked at
    PaintImages _images;
    const bool _inSlices;
    const std::shared_ptr<MeshBin> _bin = std::make_shared<MeshBin>();
    Comparing _comparing;
    Budget _budget;
    std::size_t _looks = 0; ///< subtrees looked at in this frame
    std::uint64_t _frame = 0;
    std::uint64_t _nextId = 1;
    std::uint64_t _extractions = 0;
};

} // namespace midair::bridge
