#include "engine-bridge/PoseAndStretch.h"

#include "haptics/base/SmallMatrices.h"

namespace midair::bridge
{

bool decompose(const Eigen::Matrix4d& matrix, PoseAndStretch& parts)
{
    const Eigen::RowVector4d affineRow(0.0, 0.0, 0.0, 1.0);
    if (!matrix.allFinite() || !matrix.row(3).isApprox(affineRow, 1e-9)) return false;

    // A = U S V^T = (U V^T) (V S V^T): Higham, "Computing the polar decomposition", 1986.
    const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
    const base::SingularParts svd = base::singularParts(linear);
    const Eigen::Vector3d& s = svd.values;
    if (s[2] < 1e-12 || s[2] < 1e-6 * s[0]) return false;

    Eigen::Matrix3d rotation = svd.U * svd.V.transpose();
    Eigen::Matrix3d stretch = svd.V * s.asDiagonal() * svd.V.transpose();
    if (rotation.determinant() < 0.0)
    {
        // A mirror image flips all three axes, so that the pose stays continuous while the object
        // turns.
        rotation = -rotation;
        stretch = -stretch;
    }
    parts.pose = Eigen::Isometry3d::Identity();
    parts.pose.linear() = rotation;
    parts.pose.translation() = matrix.topRightCorner<3, 1>();
    parts.stretch = stretch;
    return true;
}

} // namespace midair::bridge
