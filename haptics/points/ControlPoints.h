#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Where pressure is wanted, in the array frame; n points, all members of the same length.
struct ControlPoints
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres
    Eigen::Matrix3Xd normals;   ///< 3 x n, unit length, out of the object
    /// n, >= 0: the peak pressure that is wanted; 0: the point is left out.
    Eigen::VectorXd targets;
    /// True: targets are in Pa. False: only their ratios count, and the array plays as loud as it
    /// accurately can.
    bool absolute = false;
    std::vector<int> object; ///< n or empty: index of the object each point belongs to

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Puts \a more behind \a to. Normals that one of them lacks are zeros; objects are kept where both
/// tell them. Whether targets are in Pa is told by the one that has points.
void append(ControlPoints& to, const ControlPoints& more);

} // namespace midair::haptics
