#include "plugin/engine/SceneOwners.h"

#include "plugin/engine/HapticEngine.h"

#include <osgMidair/HapticScene>

#include <osg/observer_ptr>

#include <algorithm>
#include <mutex>
#include <vector>

namespace osgMidair
{

namespace
{

struct Entry
{
    const osg::Node* root; ///< only compared
    OwnerKind kind;
    osg::observer_ptr<HapticEngine> engine;
};

struct Registry
{
    std::mutex mutex;
    std::vector<Entry> entries; ///< without scenes, which are found among the parents
    std::vector<const osg::Node*> seen;
};

Registry& registry()
{
    static Registry all;
    return all;
}

std::string nameOf(OwnerKind kind)
{
    return kind == OwnerKind::DEVICE ? "a viewer's --device" : "a node with a HapticCallback";
}

std::string nameOf(const HapticScene& scene)
{
    return scene.getName().empty() ? "another HapticScene"
                                   : "the HapticScene \"" + scene.getName() + "\"";
}

/// Returns the name of an owner above \a node, or at it if that owner takes precedence over \a
/// kind; empty: none. registry().seen keeps nodes with several paths from being visited twice.
std::string ownerFrom(const osg::Node& node, bool isRoot, OwnerKind kind)
{
    std::vector<const osg::Node*>& seen = registry().seen;
    if (std::find(seen.begin(), seen.end(), &node) != seen.end()) return {};
    seen.push_back(&node);
    for (const Entry& entry : registry().entries)
        if (entry.root == &node && (!isRoot || entry.kind > kind)) return nameOf(entry.kind);
    const auto* scene = isRoot ? nullptr : dynamic_cast<const HapticScene*>(&node);
    if (scene) return nameOf(*scene);
    for (unsigned int i = 0; i < node.getNumParents(); ++i)
    {
        std::string owner = ownerFrom(*node.getParent(i), false, kind);
        if (!owner.empty()) return owner;
    }
    return {};
}

} // namespace

SceneOwner::SceneOwner(const osg::Node& root, OwnerKind kind, HapticEngine& engine) :
    _root(root),
    _kind(kind)
{
    if (kind == OwnerKind::SCENE) return;
    const std::lock_guard<std::mutex> lock(registry().mutex);
    registry().entries.push_back({&root, kind, &engine});
}

SceneOwner::~SceneOwner()
{
    const std::lock_guard<std::mutex> lock(registry().mutex);
    auto& entries = registry().entries;
    const auto own = std::find_if(entries.begin(),
                                  entries.end(),
                                  [this](const Entry& entry)
                                  { return entry.root == &_root && entry.kind == _kind; });
    if (own != entries.end()) entries.erase(own);
}

osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node)
{
    osg::ref_ptr<HapticEngine> found; // dies outside the lock
    const std::lock_guard<std::mutex> lock(registry().mutex);
    const Entry* best = nullptr;
    for (const Entry& entry : registry().entries)
        if (entry.root == &node && (!best || entry.kind > best->kind)) best = &entry;
    if (best) best->engine.lock(found);
    return found;
}

std::string SceneOwner::outer() const
{
    const std::lock_guard<std::mutex> lock(registry().mutex);
    registry().seen.clear();
    return ownerFrom(_root, true, _kind);
}

} // namespace osgMidair
