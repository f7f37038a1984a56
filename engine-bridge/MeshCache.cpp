#include "engine-bridge/MeshCache.h"

#include "engine-bridge/Convert.h"
#include "engine-bridge/GeometryReader.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{
constexpr std::size_t kManyStretches = 8;
}

void MeshCache::beginFrame()
{
    for (auto& [root, subtree] : _subtrees)
    {
        subtree.checked = false;
        ++subtree.unusedFrames;
        for (Part& part : subtree.parts)
            for (Stretched& s : part.stretched)
                ++s.unusedFrames;
    }
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
        // What has not changed keeps its meshes, and is not sampled again.
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
    subtree.checked = true;
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
        if (subtree.now.fingerprint() == subtree.fingerprint) return;
        findMovers(subtree);
    }
    // Other paint is another shape for all that is remembered of the old one.
    if (repainted) subtree.parts.clear();
    subtree.root = &root;
    extract(subtree, warnings);
}

const MeshCache::Stretched& MeshCache::stretchedTo(Part& part, const Eigen::Matrix3d& stretch)
{
    auto same = [&stretch](const Stretched& s) { return s.stretch.isApprox(stretch, 1e-6); };
    auto found = std::find_if(part.stretched.begin(), part.stretched.end(), same);
    if (found == part.stretched.end())
    {
        // While an object is being scaled every frame brings a stretch that never comes back.
        if (part.stretched.size() >= kManyStretches) forgetUnused(part, 1);
        auto mesh = std::make_shared<haptics::TriangleMesh>(part.mesh);
        mesh->vertices = stretch * mesh->vertices;
        part.stretched.push_back({stretch, _nextId++, mesh, 0});
        found = std::prev(part.stretched.end());
    }
    found->unusedFrames = 0;
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
    Subtree& subtree = _subtrees[&root];
    subtree.unusedFrames = 0;
    if (!subtree.checked) refresh(subtree, root, options, warnings);
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
    bool forgotten = false;
    for (auto subtree = _subtrees.begin(); subtree != _subtrees.end();)
    {
        for (Part& part : subtree->second.parts)
            forgetUnused(part, kKeptFrames);
        const bool unused = subtree->second.unusedFrames > kKeptFrames;
        forgotten = forgotten || unused;
        subtree = unused ? _subtrees.erase(subtree) : std::next(subtree);
    }
    if (forgotten) _images.forgetUnused();
}

void MeshCache::forgetUnused(Part& part, int frames)
{
    auto old = [frames](const Stretched& s) { return s.unusedFrames > frames; };
    auto& all = part.stretched;
    all.erase(std::remove_if(all.begin(), all.end(), old), all.end());
}

} // namespace midair::bridge
