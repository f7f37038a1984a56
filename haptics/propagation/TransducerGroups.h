#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// An order of an array's transducers in which every \a size in a row stand close together, as the
/// propagation matrix wants them: the first of them at multiples of \a size form compact groups
/// (k-d tree). Index: place in the order; value: transducer.
std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size);

} // namespace midair::haptics
