#include "plugin/engine/SceneAccess.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticScene>

namespace osgMidair
{

HapticEngine& SceneAccess::engine(const HapticScene& scene)
{
    return *scene._engine;
}

SceneAccess::Result SceneAccess::latestResult(const HapticScene& scene)
{
    return scene._engine->latestResult();
}

SceneAccess::Result SceneAccess::latestResult(const HapticCallback& callback)
{
    return callback._engine ? callback._engine->latestResult() : nullptr;
}

SceneAccess::Result SceneAccess::latestResult(const HapticDevice& device)
{
    return device._engine ? device._engine->latestResult() : nullptr;
}

std::shared_ptr<const midair::haptics::TransducerArray> SceneAccess::array(const HapticScene& scene)
{
    return scene._engine->array();
}

midair::haptics::Medium SceneAccess::medium(const HapticScene& scene)
{
    return scene._engine->medium();
}

} // namespace osgMidair
