#include "engine-bridge/HapticObject.h"

#include <algorithm>

namespace midair::bridge
{

bool operator==(const HapticProperties& a, const HapticProperties& b)
{
    return a.pressure == b.pressure && a.pressureInPa == b.pressureInPa &&
           a.spacing_m == b.spacing_m && a.sampling == b.sampling && a.side == b.side &&
           a.priority == b.priority && a.modulationFrequency_Hz == b.modulationFrequency_Hz &&
           a.modulationDepth == b.modulationDepth && a.render == b.render &&
           a.material == b.material;
}

bool isClipped(const std::vector<Eigen::Vector4d>& clips, const Eigen::Vector3d& place)
{
    return std::any_of(clips.begin(),
                       clips.end(),
                       [&place](const Eigen::Vector4d& plane)
                       { return plane.head<3>().dot(place) + plane[3] < 0.0; });
}

} // namespace midair::bridge
