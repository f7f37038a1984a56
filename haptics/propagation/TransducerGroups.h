#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Returns an order of an array's transducers for the propagation matrix, in which each aligned run
/// of \a size transducers is a compact group (k-d tree). Index: position in the order; value:
/// transducer.
std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size);

/// An order with empty places, so that no group spans a gap.
struct PackedOrder
{
    std::vector<int> order;     ///< an empty place repeats a transducer of its group
    std::vector<char> isFiller; ///< 1: the place is empty
};

/// Returns true if each \a size consecutive transducers of \a order are within \a largest_m of the
/// middle of their bounding box.
bool isCompact(const Eigen::Matrix3Xd& positions,
               const std::vector<int>& order,
               int size,
               double largest_m);

/// Returns \a order with empty places inserted where a group would otherwise not be compact.
PackedOrder packed(const Eigen::Matrix3Xd& positions,
                   const std::vector<int>& order,
                   int size,
                   double largest_m);

} // namespace midair::haptics
