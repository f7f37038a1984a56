#include "engine-bridge/scene/MeshCache.h"

#include "engine-bridge/scene/Convert.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr std::size_t kManyStretches = 8;
/// Minimum of bytes copied per frame and subtree, even if others have used up the frame's budget.
constexpr std::size_t kLeastSlice = 16384;
/// A subtree that changes while it is read is read at once after this many failed readings.
constexpr int kMostRestarts = 2;

constexpr std::uint64_t kSweepFrames = 60;

} // namespace

void MeshBin::put(SharedMesh mesh)
{
    const base::Lock lock(_mutex);
    _meshes.push_back(std::move(mesh));
}

void MeshBin::freeUnused()
{
    std::vector<SharedMesh> unused; // freed outside the lock
    const base::Lock lock(_mutex);
    const auto kept = std::stable_partition(
        _meshes.begin(), _meshes.end(), [](const SharedMesh& m) { return m.useCount() > 1; });
    std::move(kept, _meshes.end(), std::back_inserter(unused));
    _meshes.erase(kept, _meshes.end());
}

void MeshCache::beginFrame()
{
    ++_frame;
    const std::size_t looked = std::min(kLookWork * _looks, kFrameBytes);
    const std::size_t share = std::max(kFrameBytes - looked, kLeastBytes);
    _budget = {share, share, kSmall, 0};
    _looks = 0;
    _comparing = {0, _comparing.next, 0, kComparedBytes};
}

bool MeshCache::findMovers(Subtree& subtree)
{
    const auto& before = subtree.shape.read.still;
    const auto& now = subtree.next.still;
    const bool comparable =
        std::equal(before.begin(),
                   before.end(),
                   now.begin(),
                   now.end(),
                   [](const auto& a, const auto& b) { return a.first == b.first; });
    if (!comparable) return false;
    std::vector<const osg::Transform*>& movers = subtree.options.movers;
    const std::size_t known = movers.size();
    for (std::size_t i = 0; i < now.size(); ++i)
        if (now[i].second != before[i].second) movers.push_back(now[i].first);
    std::sort(movers.begin(), movers.end());
    movers.erase(std::unique(movers.begin(), movers.end()), movers.end());
    return movers.size() > known;
}

// Makes a part's mesh at once if the frame's budget and the reading allow it; otherwise later.
void MeshCache::makeMesh(SubtreeReading& reading, std::size_t i, const Subtree& subtree, Part& part)
{
    auto pieces = reading.takePieces(i);
    part.isEmpty = pieces.empty();
    part.bytes = reading.bytes();
    if (!subtree.shape.late)
    {
        auto mesh =
            std::make_shared<const haptics::TriangleMesh>(meshOf(pieces, reading.warnings()));
        part.isEmpty = mesh->triangles.cols() == 0;
        part.mesh = std::move(mesh);
        return;
    }
    part.mesh = SharedMesh::later(
        [pieces = std::move(pieces), late = subtree.shape.late]
        {
            std::vector<std::string> warnings;
            haptics::TriangleMesh mesh = meshOf(pieces, warnings);
            const base::Lock lock(late->mutex);
            late->all.insert(late->all.end(), warnings.begin(), warnings.end());
            late->isAny = !late->all.empty();
            return mesh;
        },
        part.bytes);
}

// Takes over the complete copy.
void MeshCache::install(Subtree& subtree, bool isWholeAtOnce, std::vector<std::string>& warnings)
{
    const std::unique_ptr<SubtreeReading> reading = std::move(subtree.reading);
    const auto isAny = [](const std::vector<bool>& flags)
    { return std::find(flags.begin(), flags.end(), true) != flags.end(); };
    const bool anyUnsaid = isAny(subtree.movedUnsaid) || isAny(subtree.changedUnsaid);
    keepShape(subtree, reading->state());
    std::vector<Part> old;
    old.swap(subtree.shape.parts);
    // New paint makes a new mesh and new ids, so that nobody keeps samples of the old one.
    if (subtree.isRepainted) old.clear();
    subtree.isRepainted = false;
    subtree.shape.read = subtree.now = reading->state();
    subtree.shape.fingerprint = subtree.shape.read.fingerprint();
    subtree.shape.vertices = reading->takeVertices();
    subtree.shape.sources = std::move(reading->sources());
    const bool isMadeNow =
        !reading->isPlain() || (isWholeAtOnce && reading->bytes() <= _budget.toMake);
    if (isMadeNow) _budget.toMake -= std::min(reading->bytes(), _budget.toMake);
    subtree.shape.late = isMadeNow ? nullptr : std::make_shared<LateWarnings>();
    ++_extractions;
    bool fresh = false;
    for (std::size_t i = 0; i < subtree.shape.read.parts.size(); ++i)
    {
        const SubtreePart& state = subtree.shape.read.parts[i];
        Part part;
        part.key = state.key;
        part.fingerprint = state.fingerprint;
        makeMesh(*reading, i, subtree, part);
        const auto same = std::find_if(
            old.begin(), old.end(), [&state](const Part& p) { return p.key == state.key; });
        const auto index = static_cast<std::size_t>(same - old.begin());
        const bool known = same != old.end() &&
                           same->fingerprint.topology == state.fingerprint.topology &&
                           !(index < subtree.changedUnsaid.size() && subtree.changedUnsaid[index]);
        part.topologyId = known ? same->topologyId : _nextId++;
        part.mirroredId = known ? same->mirroredId : _nextId++;
        // Unchanged parts keep their meshes and are not sampled again. Changes without dirty()
        // while slices were copied are unknown.
        if (known && isWholeAtOnce && same->fingerprint == state.fingerprint && !anyUnsaid)
            part.stretched.swap(same->stretched);
        fresh = fresh || !known;
        subtree.shape.parts.push_back(std::move(part));
    }
    if (!fresh) subtree.shape.late = nullptr; // reported already
    if (!fresh) return;
    const auto& said = reading->warnings();
    warnings.insert(warnings.end(), said.begin(), said.end());
}

// Continues or starts reading. Returns true when all is read.
bool MeshCache::read(Subtree& subtree, std::vector<std::string>& warnings)
{
    if (subtree.reading)
    {
        const MeshFingerprint then = subtree.reading->state().fingerprint();
        const MeshFingerprint now = subtree.next.fingerprint();
        if (then.topology != now.topology || then.paint != now.paint || subtree.reading->isStale())
        {
            subtree.reading = nullptr;
            ++subtree.restarts;
            subtree.restarted = _frame;
        }
    }
    if (_frame - subtree.restarted > kKeptFrames) subtree.restarts = 0;
    const bool begins = !subtree.reading;
    if (begins)
        subtree.reading = std::make_unique<SubtreeReading>(*subtree.root, subtree.options, _images);
    SubtreeReading& reading = *subtree.reading;
    const bool isSmall = !_inSlices || reading.bytes() <= kSmall;
    const bool isAtOnce = isSmall || !reading.isPlain() || subtree.restarts > kMostRestarts;
    std::size_t budget =
        isAtOnce ? std::numeric_limits<std::size_t>::max() : std::max(_budget.toCopy, kLeastSlice);
    const std::size_t before = budget;
    const bool isWhole = reading.copyMore(budget);
    if (!isAtOnce)
    {
        _budget.toCopy -= std::min(before - budget, _budget.toCopy);
        _budget.forNew = std::min(_budget.forNew, std::max(_budget.toCopy, kBesideLarge));
        if (!isWhole) ++_budget.unfinished;
    }
    else if (subtree.shape.parts.empty())
        spend(before - budget);
    if (isWhole) install(subtree, begins, warnings);
    return isWhole;
}

// Takes the subtree's bytes from the frame's comparison budget, if it is its turn. Large arrays are
// compared in parts.
bool MeshCache::mayCompare(const Subtree& subtree)
{
    const std::size_t place = _comparing.place++;
    if (place < _comparing.from || _comparing.left == 0 || subtree.shape.parts.empty())
        return false;
    const std::size_t bytes = std::min(subtree.shape.parts.front().bytes, kSmall);
    _comparing.left -= std::min(bytes, _comparing.left);
    if (_comparing.left == 0) _comparing.next = place + 1;
    return true;
}

// Returns true if vertices, indices or paint of a part changed without dirty().
bool MeshCache::lookForUnsaid(Subtree& subtree)
{
    const std::vector<PartSources>& parts = subtree.shape.vertices;
    subtree.movedUnsaid.assign(parts.size(), false);
    subtree.changedUnsaid.assign(parts.size(), false);
    if (!mayCompare(subtree)) return false;
    const std::uint64_t turn = subtree.turn++;
    bool any = false;
    for (std::size_t i = 0; i < parts.size(); ++i)
    {
        const auto& geometries = parts[i].geometries;
        const auto isAny = [&](bool (VertexSource::*changed)(std::uint64_t) const)
        {
            return std::any_of(geometries.begin(),
                               geometries.end(),
                               [&](const VertexSource& source) { return (source.*changed)(turn); });
        };
        subtree.changedUnsaid[i] = isAny(&VertexSource::hasChangedUnsaid);
        subtree.movedUnsaid[i] = parts[i].isComplete && isAny(&VertexSource::hasMovedUnsaid);
        any = any || subtree.movedUnsaid[i] || subtree.changedUnsaid[i];
    }
    return any;
}

// Drops the meshes of a part, large ones into the bin.
void MeshCache::drop(Part& part) const
{
    for (Stretched& s : part.stretched)
        if (part.bytes > kSmall) _bin->put(std::move(s.mesh));
    part.stretched.clear();
}

// Copies vertices if nothing else has changed. Returns false otherwise.
bool MeshCache::follow(Subtree& subtree)
{
    const std::vector<SubtreePart>& next = subtree.next.parts;
    if (next.size() != subtree.shape.parts.size()) return false;
    std::vector<bool> moved(next.size());
    for (std::size_t i = 0; i < next.size(); ++i)
    {
        const MeshFingerprint& before = subtree.shape.parts[i].fingerprint;
        if (next[i].key != subtree.shape.parts[i].key ||
            next[i].fingerprint.paint != before.paint ||
            next[i].fingerprint.topology != before.topology || subtree.changedUnsaid[i])
            return false;
        moved[i] = subtree.movedUnsaid[i] || next[i].fingerprint.vertices != before.vertices;
    }
    if (!copyVertices(*subtree.root, subtree.options, moved, subtree.shape.vertices)) return false;
    for (std::size_t i = 0; i < next.size(); ++i)
    {
        Part& part = subtree.shape.parts[i];
        if (!moved[i]) continue;
        part.fingerprint = next[i].fingerprint;
        part.moved =
            std::make_shared<const std::vector<PlacedCopy>>(subtree.shape.vertices[i].copies());
        drop(part);
    }
    subtree.now = subtree.next;
    subtree.shape.read = subtree.next;
    subtree.shape.fingerprint = subtree.next.fingerprint();
    ++_extractions;
    return true;
}

void MeshCache::takeLateWarnings(Subtree& subtree, std::vector<std::string>& warnings)
{
    if (!subtree.shape.late || !subtree.shape.late->isAny) return;
    const base::Lock lock(subtree.shape.late->mutex);
    warnings.insert(warnings.end(), subtree.shape.late->all.begin(), subtree.shape.late->all.end());
    subtree.shape.late->all.clear();
    subtree.shape.late->isAny = false;
}

void MeshCache::refresh(Subtree& subtree,
                        osg::Node& root,
                        const ExtractOptions& options,
                        std::vector<std::string>& warnings)
{
    takeLateWarnings(subtree, warnings);
    const bool fresh = !subtree.root;
    const bool repainted = !fresh && !(subtree.options.paint == options.paint);
    if (fresh) spend(kSubtreeWork);
    if (fresh || repainted)
    {
        const std::vector<const osg::Transform*> movers = subtree.options.movers;
        subtree.options = options;
        subtree.options.movers = movers;
        subtree.options.images = &_images;
        subtree.root = &root;
        subtree.reading = nullptr;
        subtree.kept.clear();
        subtree.isRepainted = true;
        subtree.version = _nextId++;
        if (read(subtree, warnings)) subtree.poses = subtree.now.poses();
        return;
    }
    inspect(root, subtree.options, subtree.next);
    if (subtree.reading)
    {
        if (!read(subtree, warnings)) return;
        subtree.version = _nextId++;
    }
    // The source of the slices may have moved meanwhile.
    const bool unsaid = lookForUnsaid(subtree);
    if (!unsaid && subtree.next.fingerprint() == subtree.shape.fingerprint)
    {
        std::swap(subtree.now, subtree.next);
        const std::uint64_t poses = subtree.now.poses();
        if (poses != subtree.poses) subtree.version = _nextId++;
        subtree.poses = poses;
        return;
    }
    if (recallShape(subtree) || (!findMovers(subtree) && follow(subtree)))
    {
        subtree.poses = subtree.now.poses();
        subtree.version = _nextId++;
        return;
    }
    if (!read(subtree, warnings)) return;
    subtree.poses = subtree.now.poses();
    subtree.version = _nextId++;
}

MeshCache::Subtree& MeshCache::lookAt(osg::Node& root,
                                      const ExtractOptions& options,
                                      std::vector<std::string>& warnings)
{
    Subtree& subtree = _subtrees[&root];
    _last = &subtree;
    if (subtree.used == _frame) return subtree;
    ++_looks;
    refresh(subtree, root, options, warnings);
    subtree.used = _frame;
    return subtree;
}

const MeshCache::Stretched& MeshCache::stretchedTo(Part& part, const Eigen::Matrix3d& stretch)
{
    auto same = [&stretch](const Stretched& s) { return s.stretch.isApprox(stretch, 1e-6); };
    auto found = std::find_if(part.stretched.begin(), part.stretched.end(), same);
    if (found == part.stretched.end())
    {
        // While an object is being scaled, every frame brings a new stretch that doesn't recur.
        if (part.stretched.size() >= kManyStretches) forgetUnused(part, 1);
        auto make = [mesh = part.mesh, moved = part.moved, stretch, bin = _bin]
        {
            bin->freeUnused();
            haptics::TriangleMesh made = *mesh;
            if (moved) made.vertices = joinedVertices(*moved);
            made.vertices = stretch * made.vertices;
            // A mirror image reverses the order of corners: its faces still point outwards.
            if (stretch.determinant() < 0.0) made.triangles.row(1).swap(made.triangles.row(2));
            return made;
        };
        part.stretched.push_back(
            {stretch, _nextId++, SharedMesh::later(std::move(make), part.bytes), _frame});
        found = std::prev(part.stretched.end());
    }
    found->used = _frame;
    return *found;
}

bool MeshCache::get(osg::Node& root,
                    const Eigen::Matrix4d& toArray,
                    const ExtractOptions& options,
                    std::vector<CachedMesh>& out,
                    std::vector<std::string>& warnings)
{
    out.clear();
    PoseAndStretch ofRoot;
    if (!decompose(toArray, ofRoot)) return false;
    Subtree& subtree = lookAt(root, options, warnings);
    for (std::size_t i = 0; i < subtree.shape.parts.size(); ++i)
    {
        Part& part = subtree.shape.parts[i];
        if (part.isEmpty) continue;
        PoseAndStretch placed = ofRoot;
        if (i > 0 && !decompose(toArray * toEigen(subtree.now.parts[i].toRoot), placed))
        {
            warnings.emplace_back("the matrix of a transform inside it is singular, not finite or "
                                  "a perspective; its children can't be felt");
            continue;
        }
        const Stretched& stretched = stretchedTo(part, placed.stretch);
        const bool isMirrored = placed.stretch.determinant() < 0.0;
        out.push_back({stretched.meshId,
                       isMirrored ? part.mirroredId : part.topologyId,
                       stretched.mesh,
                       part.key,
                       placed.pose});
    }
    return true;
}

// Lifetime of meshes. Earlier shapes of a subtree that may return, such as the children of an
// osg::Sequence, keep their meshes and therefore their samples.

// Stores the subtree's shape before it becomes \a next.
void MeshCache::keepShape(Subtree& subtree, const SubtreeState& next) const
{
    const std::vector<Part>& parts = subtree.shape.parts;
    if (parts.empty() || subtree.isRepainted || parts.front().bytes > kKeptBytes ||
        subtree.shape.fingerprint.topology == next.fingerprint().topology)
        return;
    if (subtree.kept.size() >= kKeptShapes)
        subtree.kept.erase(std::min_element(subtree.kept.begin(),
                                            subtree.kept.end(),
                                            [](const KeptShape& a, const KeptShape& b)
                                            { return a.used < b.used; }));
    subtree.kept.push_back({subtree.shape, _frame});
}

// Returns true if the subtree has an earlier shape again, and restores it.
bool MeshCache::recallShape(Subtree& subtree) const
{
    const MeshFingerprint now = subtree.next.fingerprint();
    const auto same =
        std::find_if(subtree.kept.begin(),
                     subtree.kept.end(),
                     [&now](const KeptShape& kept) { return kept.shape.fingerprint == now; });
    if (same == subtree.kept.end()) return false;
    std::swap(same->shape, subtree.shape);
    same->used = _frame;
    subtree.now = subtree.next;
    return true;
}

void MeshCache::forgetShapes(Subtree& subtree) const
{
    const auto isOld = [this](const KeptShape& kept) { return _frame - kept.used > kKeptFrames; };
    subtree.kept.erase(std::remove_if(subtree.kept.begin(), subtree.kept.end(), isOld),
                       subtree.kept.end());
}

void MeshCache::endFrame()
{
    if (_frame % kSweepFrames != 0) return;
    _bin->freeUnused();
    bool forgotten = false;
    for (auto subtree = _subtrees.begin(); subtree != _subtrees.end();)
    {
        for (Part& part : subtree->second.shape.parts)
        {
            // A caller for whom look() stays the same keeps the mesh without another call.
            for (Stretched& s : part.stretched)
                if (s.mesh.useCount() > 1) s.used = _frame;
            forgetUnused(part, kKeptFrames);
        }
        forgetShapes(subtree->second);
        const bool unused = _frame - subtree->second.used > kKeptFrames;
        forgotten = forgotten || unused;
        subtree = unused ? _subtrees.erase(subtree) : std::next(subtree);
    }
    _last = nullptr;
    if (forgotten) _images.forgetUnused();
}

void MeshCache::forgetUnused(Part& part, std::uint64_t frames) const
{
    auto old = [&](const Stretched& s)
    { return _frame - s.used > frames && s.mesh.useCount() == 1; };
    auto& all = part.stretched;
    all.erase(std::remove_if(all.begin(), all.end(), old), all.end());
}

} // namespace midair::bridge
