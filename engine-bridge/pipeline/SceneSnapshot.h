#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/HandsAndObstacles.h"

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// All that should be felt in one frame, handed to the hologram thread; immutable once submitted.
struct SceneSnapshot
{
    std::uint64_t frame = 0;
    double time_s = 0.0; ///< steady clock when collected
    std::vector<HapticObject> objects;
    HandsAndObstacles around;
};

} // namespace midair::bridge
