#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

namespace midair::haptics
{

/// Splits a polygon of \a corners (3 x n, n >= 3) into n - 2 triangles of its corners, counted from
/// 0 and wound as they are. One that isn't flat is seen along its mean normal. \a crosses: it
/// crosses itself, so that its triangles overlap.
std::vector<std::array<int, 3>> triangulated(const Eigen::Matrix3Xd& corners, bool& crosses);

} // namespace midair::haptics
