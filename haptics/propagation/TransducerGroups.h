#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Returns an order of an array's transducers for the propagation matrix, in which each \a size
/// consecutive ones, counted from a multiple of \a size, form a compact group (k-d tree). Index:
/// position in the order; value: transducer.
std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size);

/// An order in which some places are empty, so that no group spans a gap.
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

/// Returns \a order with empty places in it where a group would else not be compact.
PackedOrder packed(const Eigen::Matrix3Xd& positions,
                   const std::vector<int>& order,
                   int size,
                   double largest_m);

} // namespace midair::haptics
