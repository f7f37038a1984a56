#include "engine-bridge/scene/MeshCache.h"

#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/GeometryReader.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

constexpr std::size_t kManyStretches = 8;
constexpr std::uint64_t kSweepFrames = 60;
} // namespace

void MeshCache::beginFrame()
{
    ++_frame;
}

bool MeshCache::findMovers(Subtree& subtree)
{
    const auto& before = subtree.extracted.state.still;
    const auto& now = subtree.now.still;
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

void MeshCache::extract(Subtree& subtree, std::vector<std::string>& warnings)
{
    std::vector<Part> old;
    old.swap(subtree.parts);
    subtree.extracted = extractMesh(*subtree.root, subtree.options);
    subtree.fingerprint = subtree.extracted.state.fingerprint();
    subtree.now = subtree.extracted.state;
    ++_extractions;
    bool fresh = false;
    for (std::size_t i = 0; i < subtree.extracted.parts.size(); ++i)
    {
        const SubtreePart& state = subtree.extracted.state.parts[i];
        Part part;
        part.key = state.key;
        part.fingerprint = state.fingerprint;
        part.mesh = std::move(subtree.extracted.parts[i]);
        const auto same = std::find_if(
            old.begin(), old.end(), [&state](const Part& p) { return p.key == state.key; });
        const bool known =
            same != old.end() && same->fingerprint.topology == state.fingerprint.topology;
        part.topologyId = known ? same->topologyId : _nextId++;
        // Parts that have not changed keep their meshes and are not sampled again.
        if (known && same->fingerprint == state.fingerprint) part.stretched.swap(same->stretched);
        fresh = fresh || !known;
        subtree.parts.push_back(std::move(part));
    }
    subtree.extracted.parts.clear();
    if (!fresh) return;
    const auto& said = subtree.extracted.warnings;
    warnings.insert(warnings.end(), said.begin(), said.end());
}

void MeshCache::refresh(Subtree& subtree,
                        osg::Node& root,
                        const ExtractOptions& options,
                        std::vector<std::string>& warnings)
{
    const bool fresh = !subtree.root;
    const bool repainted = !fresh && !(subtree.options.paint == options.paint);
    if (fresh || repainted)
    {
        const std::vector<const osg::Transform*> movers = subtree.options.movers;
        subtree.options = options;
        subtree.options.movers = movers;
        subtree.options.images = &_images;
    }
    if (!fresh && !repainted)
    {
        inspect(root, subtree.options, subtree.now);
        if (subtree.now.fingerprint() == subtree.fingerprint)
        {
            const std::uint64_t poses = subtree.now.poses();
            if (poses != subtree.poses) subtree.version = _nextId++;
            subtree.poses = poses;
            return;
        }
        findMovers(subtree);
    }
    // New paint makes a new mesh and new ids, so that no one keeps samples of the old one.
    if (repainted) subtree.parts.clear();
    subtree.root = &root;
    extract(subtree, warnings);
    subtree.poses = subtree.now.poses();
    subtree.version = _nextId++;
}

MeshCache::Subtree& MeshCache::lookAt(osg::Node& root,
                                      const ExtractOptions& options,
                                      std::vector<std::string>& warnings)
{
    Subtree& subtree = _subtrees[&root];
    if (subtree.used != _frame) refresh(subtree, root, options, warnings);
    subtree.used = _frame;
    return subtree;
}

const MeshCache::Stretched& MeshCache::stretchedTo(Part& part, const Eigen::Matrix3d& stretch)
{
    auto same = [&stretch](const Stretched& s) { return s.stretch.isApprox(stretch, 1e-6); };
    auto found = std::find_if(part.stretched.begin(), part.stretched.end(), same);
    if (found == part.stretched.end())
    {
        // While an object is being scaled, every frame brings a new stretch that doesn't come back.
        if (part.stretched.size() >= kManyStretches) forgetUnused(part, 1);
        auto mesh = std::make_shared<haptics::TriangleMesh>(part.mesh);
        mesh->vertices = stretch * mesh->vertices;
        part.stretched.push_back({stretch, _nextId++, mesh, _frame});
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
    for (std::size_t i = 0; i < subtree.parts.size(); ++i)
    {
        Part& part = subtree.parts[i];
        if (part.mesh.triangles.cols() == 0) continue;
        PoseAndStretch placed = ofRoot;
        if (i > 0 && !decompose(toArray * toEigen(subtree.now.parts[i].toRoot), placed))
        {
            warnings.emplace_back(
                "the matrix of a transform inside it is singular, not finite or a perspective; "
                "what is below that can't be felt");
            continue;
        }
        const Stretched& stretched = stretchedTo(part, placed.stretch);
        out.push_back({stretched.meshId, part.topologyId, stretched.mesh, part.key, placed.pose});
    }
    return true;
}

void MeshCache::endFrame()
{
    if (_frame % kSweepFrames != 0) return;
    bool forgotten = false;
    for (auto subtree = _subtrees.begin(); subtree != _subtrees.end();)
    {
        for (Part& part : subtree->second.parts)
        {
            // A caller for whom look() stays the same holds the mesh without asking again.
            for (Stretched& s : part.stretched)
                if (s.mesh.use_count() > 1) s.used = _frame;
            forgetUnused(part, kKeptFrames);
        }
        const bool unused = _frame - subtree->second.used > kKeptFrames;
        forgotten = forgotten || unused;
        subtree = unused ? _subtrees.erase(subtree) : std::next(subtree);
    }
    if (forgotten) _images.forgetUnused();
}

void MeshCache::forgetUnused(Part& part, std::uint64_t frames) const
{
    auto old = [&](const Stretched& s)
    { return _frame - s.used > frames && s.mesh.use_count() == 1; };
    auto& all = part.stretched;
    all.erase(std::remove_if(all.begin(), all.end(), old), all.end());
}

} // namespace midair::bridge
