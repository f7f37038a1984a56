#include "plugin/engine/SceneAccess.h"

#include "plugin/engine/OwnedEngine.h"
#include "plugin/engine/SceneOwners.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticScene>

namespace osgMidair
{

HapticEngine& SceneAccess::engine(const HapticScene& scene)
{
    return *scene._engine;
}

osg::ref_ptr<HapticEngine> SceneAccess::playing(const osg::NodePath& path)
{
    for (const osg::Node* node : path)
    {
        osg::ref_ptr<HapticEngine> owner = engineOwning(*node);
        if (owner) return owner;
        if (const auto* scene = dynamic_cast<const HapticScene*>(node)) return scene->_engine;
    }
    return nullptr;
}

SceneAccess::Result SceneAccess::latestResult(const HapticScene& scene)
{
    return scene._engine->latestResult();
}

SceneAccess::Result SceneAccess::latestResult(const HapticCallback& callback)
{
    const osg::ref_ptr<HapticEngine> engine = callback._engine->get();
    return engine ? engine->latestResult() : nullptr;
}

SceneAccess::Result SceneAccess::latestResult(const HapticDevice& device)
{
    const osg::ref_ptr<HapticEngine> engine = device._engine->get();
    return engine ? engine->latestResult() : nullptr;
}

} // namespace osgMidair
