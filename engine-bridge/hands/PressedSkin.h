#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace midair::bridge
{

/// A push belongs to a surface nearer to its place than this; skin nearer to that surface is
/// flattened on it.
constexpr double kPressReach_m = 4e-3;

/// Returns how deep the skin of \a bone (of \a hand) is pressed into \a mesh, m; nullopt if none of
/// \a presses belongs to that bone and that surface. \a toMesh: transform from their frame to the
/// mesh's.
///
/// A physics engine keeps a pushed body just ahead of the hand, where a finger's pad would yield.
/// Therefore the depth is the one at which a pad has that force: 10 N/m, at most 2 mm
/// (ContactForceOptions).
std::optional<double> pressedDepth_m(const std::vector<HandPress>& presses,
                                     int hand,
                                     int bone,
                                     const MeshDistance& mesh,
                                     const Eigen::Isometry3d& toMesh);

/// Returns the increase of radius of a bone whose skin is \a distance_m from a surface (below 0:
/// inside) and pressed \a depth_m into it, m; 0 if the skin is too far.
double pressedOut_m(double distance_m, double depth_m);

} // namespace midair::bridge
