#pragma once

#include <Eigen/Geometry>

namespace midair::base
{

// Decompositions of small matrices of finite numbers. Compiled once, because each takes seconds to
// compile.

/// Ascending eigenvalues, and their eigenvectors as columns of length 1.
template<int N>
struct SymmetricAxes
{
    Eigen::Matrix<double, N, 1> values;
    Eigen::Matrix<double, N, N> vectors;
};

/// Eigenvalues of a symmetric \a matrix; reads its lower half.
SymmetricAxes<2> symmetricAxes(const Eigen::Matrix2d& matrix);
SymmetricAxes<3> symmetricAxes(const Eigen::Matrix3d& matrix);

/// matrix = U diag(values) V^T with orthogonal U and V; values descend and are at least 0.
struct SingularParts
{
    Eigen::Matrix3d U;
    Eigen::Vector3d values;
    Eigen::Matrix3d V;
};

SingularParts singularParts(const Eigen::Matrix3d& matrix);

/// Returns the smallest rotation from direction \a from to \a to; for opposite directions any half
/// turn.
Eigen::Quaterniond turnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Returns the rigid motion, with scale if \a isScaled, that maps the columns of \a from closest to
/// those of \a to (least squares): S. Umeyama, "Least-squares estimation of transformation
/// parameters between two point patterns", IEEE Trans. PAMI 13, 1991. Both have the same number of
/// columns, at least 1.
Eigen::Matrix4d
nearestMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, bool isScaled);

} // namespace midair::base
