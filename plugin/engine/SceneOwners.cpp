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

struct Owner
{
    const osg::Node* root; ///< only compared
    OwnerKind kind;
    osg::observer_ptr<HapticEngine> engine;
};

struct Owners
{
    std::mutex mutex;
    std::vector<Owner> entries; ///< without scenes, which are found among the parents
    std::vector<const osg::Node*> seen;
};

Owners& owners()
{
    static Owners all;
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
/// kind; empty: none. owners().seen keeps nodes with several paths from being visited twice.
std::string ownerFrom(const osg::Node& node, bool isRoot, OwnerKind kind)
{
    std::vector<const osg::Node*>& seen = owners().seen;
    if (std::find(seen.begin(), seen.end(), &node) != seen.end()) return {};
    seen.push_back(&node);
    for (const Owner& entry : owners().entries)
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
    const std::lock_guard<std::mutex> lock(owners().mutex);
    owners().entries.push_back({&root, kind, &engine});
}

SceneOwner::~SceneOwner()
{
    const std::lock_guard<std::mutex> lock(owners().mutex);
    auto& entries = owners().entries;
    const auto own = std::find_if(entries.begin(),
                                  entries.end(),
                                  [this](const Owner& entry)
                                  { return entry.root == &_root && entry.kind == _kind; });
    if (own != entries.end()) entries.erase(own);
}

osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node)
{
    osg::ref_ptr<HapticEngine> found; // dies outside the lock
    const std::lock_guard<std::mutex> lock(owners().mutex);
    const Owner* best = nullptr;
    for (const Owner& entry : owners().entries)
        if (entry.root == &node && (!best || entry.kind > best->kind)) best = &entry;
    if (best) best->engine.lock(found);
    return found;
}

std::string SceneOwner::outer() const
{
    const std::lock_guard<std::mutex> lock(owners().mutex);
    owners().seen.clear();
    return ownerFrom(_root, true, _kind);
}

} // namespace osgMidair
