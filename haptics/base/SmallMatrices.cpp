#include "haptics/base/SmallMatrices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace midair::base
{

SymmetricAxes<2> symmetricAxes(const Eigen::Matrix2d& matrix)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(matrix);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricAxes<3> symmetricAxes(const Eigen::Matrix3d& matrix)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

SingularParts singularParts(const Eigen::Matrix3d& matrix)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::Quaterniond turnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::Matrix4d
nearestMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, bool isScaled)
{
    return Eigen::umeyama(from, to, isScaled);
}

} // namespace midair::base
