// What a HapticEngine does for a FieldBaker, which solves its frames by itself.

#include "haptics/array/ArrayFileWatch.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/settings/PropertyChanges.h"

#include <chrono>
#include <thread>

namespace osgMidair
{

// Nothing that is real is opened. The pipeline that is made reads the array.
void HapticEngine::noteForBaking(bool isSame)
{
    if (isSame) return;
    _isOpen = true;
    ++_bakedChanges;
    const std::lock_guard<std::mutex> lock(_mutex);
    _array = std::make_shared<LoadedArray>();
    _watch = std::make_shared<midair::haptics::ArrayFileWatch>("");
    _medium = hologramOptions().medium;
}

HapticEngine::Baked
HapticEngine::collectForBaking(const SceneRoot& root, unsigned int frame, double simulationTime_s)
{
    if (!_isBaked) _configured = false; // without what was open
    _isBaked = true;
    if (standsBack()) return {};
    configure(*_given);
    // Tags are looked for in each frame, so that what is found doesn't depend on the first one.
    _collector.dirtyTags();
    collect({root});
    for (int more = 0; _settings.enabled && _collector.beingRead() > 0; ++more)
    {
        if (more > 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
        collect({root});
    }
    keepInnerLimits();
    _snapshot.frame = frame;
    _snapshot.time_s = midair::base::steadySeconds();
    _snapshot.metresPerUnit = _settings.metresPerUnit;
    _snapshot.simulationTime_s = simulationTime_s;
    _snapshot.worldToArray = _toArray;
    _snapshot.around.props.clear();
    _snapshot.ears.resize(3, 0);
    _hands.locate(simulationTime_s, _worldToArray, _snapshot.around); // obstacles
    if (_settings.enabled) _collector.addObstacles(_snapshot.around.props);
    return {&_snapshot, _bakedChanges};
}

} // namespace osgMidair
