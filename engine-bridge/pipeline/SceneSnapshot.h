#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/HandsAndObstacles.h"

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// The objects, hands and props of one frame, handed to the hologram thread; immutable once
/// submitted.
struct SceneSnapshot
{
    std::uint64_t frame = 0; ///< frame number; copied into HologramResult::frame
    double time_s = 0.0;     ///< steady clock, when it was collected
    std::vector<HapticObject> objects;
    HandsAndObstacles around;
};

} // namespace midair::bridge
