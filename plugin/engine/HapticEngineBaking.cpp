// What a HapticEngine does for a FieldBaker, which solves its frames by itself.

#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/HapticEngine.h"

#include <chrono>
#include <thread>

namespace osgMidair
{

// Nothing that is real is opened. The pipeline that is made reads the array.
HapticEngine::Baked
HapticEngine::collectForBaking(const SceneRoot& root, unsigned int frame, double simulationTime_s)
{
    if (!_settings.isBaked) _settings.isRead = false; // without what was open
    _settings.isBaked = true;
    _player.keepClosed();
    if (isPlayedByOuterOwner()) return {};
    configure(*_given.settings);
    // Tags are looked for in each frame, so that what is found doesn't depend on the first one.
    _collector.dirtyTags();
    collect({root});
    for (int more = 0; mayPlay() && _collector.beingRead() > 0; ++more)
    {
        if (more > 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
        collect({root});
    }
    keepInnerLimits();
    fillSnapshot(frame, midair::base::steadySeconds(), simulationTime_s);
    _player.snapshot().ears.resize(3, 0);
    _player.locateHands(_places.worldToArray);
    return {&_player.snapshot(), _player.changes()};
}

} // namespace osgMidair
