#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/text/MessageLog.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/scene/SceneCollector.h"

#include <osgMidair/HapticMessage>

#include <algorithm>
#include <memory>
#include <vector>

namespace osgMidair
{

/// Converts \a message to its public form.
inline HapticMessage toPublic(const midair::base::Message& message)
{
    // The origin is a node found by a SceneCollector.
    const auto* felt = static_cast<const FeltNode*>(message.origin.get());
    return {static_cast<HapticMessage::Severity>(message.severity()),
            midair::base::kindOf(message.code).name,
            message.path,
            message.text,
            message.count,
            message.isActive,
            message.since_s,
            message.until_s,
            felt ? felt->node : osg::observer_ptr<osg::Node>()};
}

/// Returns the active messages in \a told.
inline std::vector<HapticMessage> activeOf(std::vector<HapticMessage> told)
{
    const auto isOver = [](const HapticMessage& message) { return !message.isActive; };
    told.erase(std::remove_if(told.begin(), told.end(), isOver), told.end());
    return told;
}

class HapticCallback;
class HapticDevice;
class HapticScene;

/// Access to the implementation behind the installed classes, for the kit itself and its tests. No
/// installed header names these types.
class SceneAccess
{
public:
    using Result = std::shared_ptr<const midair::bridge::HologramResult>;

    static HapticEngine& engine(const HapticScene& scene);

    /// Returns the engine that plays the end of \a path, which begins at the root of the scene
    /// graph: that of the outermost device, callback or HapticScene on it; null if there is none.
    static osg::ref_ptr<HapticEngine> playing(const osg::NodePath& path);

    /// Returns the newest field; null before the first one. From any thread.
    static Result latestResult(const HapticScene& scene);
    static Result latestResult(const HapticCallback& callback);
    static Result latestResult(const HapticDevice& device);
};

} // namespace osgMidair
