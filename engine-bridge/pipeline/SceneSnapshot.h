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
    /// of the frame; copied into HologramResult::simulationTime_s
    double simulationTime_s = 0.0;
    /// affine, from the scene's world, in its units, to the array; copied into the result
    Eigen::Matrix4d worldToArray = Eigen::Matrix4d::Identity();
    std::vector<HapticObject> objects;
    HandsAndObstacles around;
    HandFrame hands;          ///< array frame; for contacts
    double handsLate_s = 0.0; ///< from the time of these places to the sound; 0: they are predicted
    /// 3 x k, m, array frame: the ears of a head that is known to be there
    Eigen::Matrix3Xd ears = Eigen::Matrix3Xd(3, 0);
    double metresPerUnit = 1.0; ///< of the scene, for messages; the objects are in metres
};

} // namespace midair::bridge
