#include "engine-bridge/hands/PressedSkin.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

constexpr double kPad_N_m = 10.0;
constexpr double kPadDepth_m = 2e-3;

} // namespace

std::optional<double> pressedDepth_m(const std::vector<HandPress>& presses,
                                     int hand,
                                     int bone,
                                     const MeshDistance& mesh,
                                     const Eigen::Isometry3d& toMesh)
{
    std::optional<double> depth_m;
    for (const HandPress& press : presses)
    {
        if (press.hand != hand || press.bone != bone) continue;
        const Eigen::Vector3d place = toMesh * press.place;
        if (mesh.nearest({place, place, 0.0}, kPressReach_m).triangle < 0) continue;
        depth_m = std::min(depth_m.value_or(0.0) + press.force_N / kPad_N_m, kPadDepth_m);
    }
    return depth_m;
}

double pressedOut_m(double distance_m, double depth_m)
{
    return distance_m <= kPressReach_m ? std::max(distance_m + depth_m, 0.0) : 0.0;
}

} // namespace midair::bridge
