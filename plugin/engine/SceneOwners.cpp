#include "plugin/engine/SceneOwners.h"

#include "haptics/base/threads/Mutex.h"
#include "plugin/engine/HapticEngine.h"

#include <osgMidair/HapticScene>

#include <osg/observer_ptr>

#include <algorithm>
#include <set>

namespace osgMidair
{

namespace
{

struct Owner
{
    const SceneOwner* owner; ///< only compared, like the next
    const osg::Node* root;
    OwnerKind kind;
    bool isLed;
    osg::observer_ptr<HapticEngine> engine;
};

struct Owners
{
    midair::base::Mutex mutex;
    /// those without scenes, which are found among the parents
    std::vector<Owner> entries MIDAIR_GUARDED_BY(mutex);
    std::vector<const osg::Node*> seen MIDAIR_GUARDED_BY(mutex);
};

// Never destroyed, because scenes may end during the process's exit; likewise the next two.
Owners& owners()
{
    static auto* const all = new Owners;
    return *all;
}

struct Places
{
    midair::base::Mutex mutex;
    std::set<const PlayingPlace*> taken MIDAIR_GUARDED_BY(mutex);
    std::set<const PlayingPlace*> waiting MIDAIR_GUARDED_BY(mutex);
};

Places& places()
{
    static auto* const all = new Places;
    return *all;
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

/// Returns the name of an owner above \a node, or of one at it that takes precedence over \a kind;
/// empty: none. owners().seen prevents visiting nodes with several paths twice.
std::string ownerFrom(const osg::Node& node, bool isRoot, OwnerKind kind)
    MIDAIR_REQUIRES(owners().mutex)
{
    std::vector<const osg::Node*>& seen = owners().seen;
    if (std::find(seen.begin(), seen.end(), &node) != seen.end()) return {};
    seen.push_back(&node);
    for (const Owner& entry : owners().entries)
        if (entry.isLed && entry.root == &node && (!isRoot || entry.kind > kind))
            return nameOf(entry.kind);
    const auto* scene = isRoot ? nullptr : dynamic_cast<const HapticScene*>(&node);
    if (scene) return nameOf(*scene);
    for (unsigned int i = 0; i < node.getNumParents(); ++i)
    {
        std::string owner = ownerFrom(*node.getParent(i), false, kind);
        if (!owner.empty()) return owner;
    }
    return {};
}

/// A joined engine and the viewer that shows its scene.
struct JoinedEngine
{
    const HapticEngine* engine; ///< only compared
    osg::observer_ptr<HapticEngine> alive;
    const osgViewer::ViewerBase* viewer = nullptr; ///< only compared
};

/// All joined engines, the oldest first.
struct JoinedEngines
{
    midair::base::Mutex mutex;
    std::vector<JoinedEngine> entries MIDAIR_GUARDED_BY(mutex);

    std::vector<JoinedEngine>::iterator find(const HapticEngine& engine) MIDAIR_REQUIRES(mutex)
    {
        return std::find_if(entries.begin(),
                            entries.end(),
                            [&engine](const JoinedEngine& entry)
                            { return entry.engine == &engine; });
    }
};

JoinedEngines& joinedEngines()
{
    static auto* const all = new JoinedEngines;
    return *all;
}

/// Returns the joined engines shown by the viewer of \a engine that joined before it, or after it.
std::vector<osg::ref_ptr<HapticEngine>> shownBeside(const HapticEngine& engine, bool isBefore)
{
    std::vector<osg::ref_ptr<HapticEngine>> found; // released outside the lock
    const midair::base::Lock lock(joinedEngines().mutex);
    std::vector<JoinedEngine>& all = joinedEngines().entries;
    const auto own = joinedEngines().find(engine);
    if (own == all.end() || !own->viewer) return found;
    for (auto entry = isBefore ? all.begin() : std::next(own);
         entry != (isBefore ? own : all.end());
         ++entry)
    {
        osg::ref_ptr<HapticEngine> other;
        if (entry->viewer == own->viewer && entry->alive.lock(other)) found.push_back(other);
    }
    return found;
}

} // namespace

SceneOwner::SceneOwner(const osg::Node& root, OwnerKind kind, HapticEngine& engine) :
    _root(root),
    _kind(kind)
{
    if (kind == OwnerKind::SCENE) return;
    const midair::base::Lock lock(owners().mutex);
    owners().entries.push_back({this, &root, kind, true, &engine});
}

SceneOwner::~SceneOwner()
{
    const midair::base::Lock lock(owners().mutex);
    auto& entries = owners().entries;
    entries.erase(std::remove_if(entries.begin(),
                                 entries.end(),
                                 [this](const Owner& entry) { return entry.owner == this; }),
                  entries.end());
}

void SceneOwner::setLed(bool isLed)
{
    const midair::base::Lock lock(owners().mutex);
    for (Owner& entry : owners().entries)
        if (entry.owner == this) entry.isLed = isLed;
}

osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node)
{
    osg::ref_ptr<HapticEngine> found; // released outside the lock
    const midair::base::Lock lock(owners().mutex);
    const Owner* best = nullptr;
    for (const Owner& entry : owners().entries)
        if (entry.isLed && entry.root == &node && (!best || entry.kind > best->kind)) best = &entry;
    if (best) best->engine.lock(found);
    return found;
}

std::string SceneOwner::outer() const
{
    const midair::base::Lock lock(owners().mutex);
    owners().seen.clear();
    return ownerFrom(_root, true, _kind);
}

bool PlayingPlace::take()
{
    const midair::base::Lock lock(places().mutex);
    const bool has = places().taken.count(this) > 0 || places().taken.size() < kMost;
    (has ? places().taken : places().waiting).insert(this);
    if (has) places().waiting.erase(this);
    return has;
}

void PlayingPlace::leave()
{
    const midair::base::Lock lock(places().mutex);
    places().taken.erase(this);
    places().waiting.erase(this);
}

bool PlayingPlace::isWanted()
{
    const midair::base::Lock lock(places().mutex);
    return !places().waiting.empty() && places().taken.size() >= kMost;
}

JoinedScene::JoinedScene(HapticEngine& engine) : _engine(engine) {}

JoinedScene::~JoinedScene()
{
    setJoined(false);
}

void JoinedScene::setJoined(bool joined)
{
    const midair::base::Lock lock(joinedEngines().mutex);
    const auto own = joinedEngines().find(_engine);
    const bool isThere = own != joinedEngines().entries.end();
    if (joined && !isThere) joinedEngines().entries.push_back({&_engine, &_engine});
    if (!joined && isThere) joinedEngines().entries.erase(own);
}

bool JoinedScene::isJoined() const
{
    const midair::base::Lock lock(joinedEngines().mutex);
    return joinedEngines().find(_engine) != joinedEngines().entries.end();
}

void JoinedScene::follow(const osgViewer::ViewerBase& viewer)
{
    const midair::base::Lock lock(joinedEngines().mutex);
    const auto own = joinedEngines().find(_engine);
    if (own != joinedEngines().entries.end()) own->viewer = &viewer;
}

osg::ref_ptr<HapticEngine> JoinedScene::host() const
{
    for (const osg::ref_ptr<HapticEngine>& older : shownBeside(_engine, true))
        if (older->suits(_engine)) return older;
    return nullptr;
}

void JoinedScene::findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const
{
    guests = shownBeside(_engine, false);
    guests.erase(std::remove_if(guests.begin(),
                                guests.end(),
                                [this](const auto& other)
                                { return other->host().get() != &_engine; }),
                 guests.end());
}

} // namespace osgMidair
