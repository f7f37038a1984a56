#include "plugin/engine/JoinedScene.h"

#include "haptics/base/threads/Mutex.h"
#include "plugin/engine/HapticEngine.h"

#include <osg/observer_ptr>

#include <algorithm>

namespace osgMidair
{

namespace
{

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
    static JoinedEngines all;
    return all;
}

} // namespace

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
    std::vector<osg::ref_ptr<HapticEngine>> older; // die outside the lock
    {
        const midair::base::Lock lock(joinedEngines().mutex);
        const auto own = joinedEngines().find(_engine);
        if (own == joinedEngines().entries.end() || !own->viewer) return nullptr;
        for (auto entry = joinedEngines().entries.begin(); entry != own; ++entry)
        {
            osg::ref_ptr<HapticEngine> engine;
            if (entry->viewer == own->viewer && entry->alive.lock(engine)) older.push_back(engine);
        }
    }
    const auto first = std::find_if(
        older.begin(), older.end(), [this](const auto& other) { return other->suits(_engine); });
    return first == older.end() ? nullptr : *first;
}

void JoinedScene::findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const
{
    guests.clear();
    {
        const midair::base::Lock lock(joinedEngines().mutex);
        const auto own = joinedEngines().find(_engine);
        if (own == joinedEngines().entries.end() || !own->viewer) return;
        for (auto entry = std::next(own); entry != joinedEngines().entries.end(); ++entry)
        {
            osg::ref_ptr<HapticEngine> engine;
            if (entry->viewer == own->viewer && entry->alive.lock(engine)) guests.push_back(engine);
        }
    }
    guests.erase(std::remove_if(guests.begin(),
                                guests.end(),
                                [this](const auto& other)
                                { return other->host().get() != &_engine; }),
                 guests.end());
}

} // namespace osgMidair
