#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace midair::bridge
{

/// A push counts for the surface that is nearer to its place than this, and skin that is nearer to
/// that surface is pressed flat on it.
constexpr double kPressReach_m = 4e-3;

/// Returns how deep the skin of \a bone (of \a hand) is pressed into \a mesh, m; nullopt if none of
/// \a presses is of that bone and on that surface. \a toMesh: transform from their frame to the
/// mesh's.
///
/// A physics engine keeps a body that is pushed just ahead of the hand, where a finger's pad would
/// give way. So the depth is that at which a pad has the force: 10 N/m, at most 2 mm
/// (ContactForceOptions).
std::optional<double> pressedDepth_m(const std::vector<HandPress>& presses,
                                     int hand,
                                     int bone,
                                     const MeshDistance& mesh,
                                     const Eigen::Isometry3d& toMesh);

/// Returns what has to be added to the radius of a bone whose skin is \a distance_m from a surface
/// (under 0: in it) and pressed \a depth_m into it, m; 0 where the skin is too far.
double pressedOut_m(double distance_m, double depth_m);

} // namespace midair::bridge
