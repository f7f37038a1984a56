#pragma once

#include <Eigen/Geometry>

namespace midair::base
{

// Decompositions of small matrices of finite numbers, compiled once: each takes seconds.

/// Eigenvalues, ascending, and the eigenvectors to them, which are columns of length 1.
template<int N>
struct SymmetricAxes
{
    Eigen::Matrix<double, N, 1> values;
    Eigen::Matrix<double, N, N> vectors;
};

/// Of a symmetric \a matrix, of which the lower half is read.
SymmetricAxes<2> symmetricAxes(const Eigen::Matrix2d& matrix);
SymmetricAxes<3> symmetricAxes(const Eigen::Matrix3d& matrix);

/// matrix = U diag(values) V^T with orthogonal U and V; values descend and are none below 0.
struct SingularParts
{
    Eigen::Matrix3d U;
    Eigen::Vector3d values;
    Eigen::Matrix3d V;
};

SingularParts singularParts(const Eigen::Matrix3d& matrix);

/// The least turn of the direction \a from into \a to; of opposite ones one of the half turns.
Eigen::Quaterniond turnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The motion, with \a isScaled a scale too, that brings \a from nearest to \a to, column by column
/// (least squares): S. Umeyama, "Least-squares estimation of transformation parameters between two
/// point patterns", IEEE Trans. PAMI 13, 1991. Both have the same number of columns, at least 1.
Eigen::Matrix4d
nearestMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, bool isScaled);

} // namespace midair::base
