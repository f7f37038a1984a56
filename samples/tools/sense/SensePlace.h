#pragma once

#include <Eigen/Core>

namespace midair::samples
{

/// Returns the matrix that places a pattern for an array whose transducers are at \a positions (a
/// column each, m) and emit along \a normals: that of the point which AdapTics puts 200 mm in front
/// of the array. Where all emit to one side, z is their mean direction, and the point is 200 mm in
/// front of their middle; z turns to it by the shortest way. Around other arrays it is the origin,
/// unturned.
Eigen::Matrix4d patternPlace(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& normals);

/// Height of that point above the pattern's own origin in a pattern of the Designer.
constexpr double kPatternHeight_m = 0.2;

} // namespace midair::samples
