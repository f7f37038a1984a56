#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Points where pressure is wanted, in the array frame; n points, all members of the same length.
struct ControlPoints
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres
    Eigen::Matrix3Xd normals;   ///< 3 x n, unit length, pointing out of the object
    /// n, >= 0: wanted peak pressure; 0: the point is left out.
    Eigen::VectorXd targets;
    /// True: targets are in Pa. False: only their ratios count, and the array plays as loud as it
    /// can while it stays accurate.
    bool absolute = false;
    std::vector<int> object; ///< n or empty: index of the object each point belongs to

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Appends \a more to \a to. Missing normals of one of them become zeros; objects are kept only if
/// both have them. `absolute` is that of the one that has points.
void append(ControlPoints& to, const ControlPoints& more);

} // namespace midair::haptics
