#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Returns an order of an array's transducers for the propagation matrix, in which each \a size
/// consecutive ones, counted from a multiple of \a size, form a compact group (k-d tree). Index:
/// position in the order; value: transducer.
std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size);

} // namespace midair::haptics
