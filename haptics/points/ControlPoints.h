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
    /// n, > 0: peak pressure, in Pa or relative (SolverOptions says which)
    Eigen::VectorXd targets;
    std::vector<int> object; ///< n or empty: index of the object each point belongs to

    int size() const { return static_cast<int>(positions.cols()); }
};

} // namespace midair::haptics
