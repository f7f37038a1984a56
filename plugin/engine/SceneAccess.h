#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "plugin/engine/HapticEngine.h"

#include <osgMidair/Export>

#include <memory>

namespace osgMidair
{

class HapticCallback;
class HapticDevice;
class HapticScene;

/// What stands behind the installed classes, for the kit itself, its demonstration and its tests:
/// no installed header names it.
class OSGMIDAIR_EXPORT SceneAccess
{
public:
    using Result = std::shared_ptr<const midair::bridge::HologramResult>;

    static HapticEngine& engine(const HapticScene& scene);

    /// The newest field; null before the first one. From any thread.
    static Result latestResult(const HapticScene& scene);
    static Result latestResult(const HapticCallback& callback);
    static Result latestResult(const HapticDevice& device);

    /// What the array setting names; null before the scene is first collected, or where it can't be
    /// read. From any thread.
    static std::shared_ptr<const midair::haptics::TransducerArray> array(const HapticScene& scene);
    /// The air of the newest settings. From any thread.
    static midair::haptics::Medium medium(const HapticScene& scene);
};

} // namespace osgMidair
