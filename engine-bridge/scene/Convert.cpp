#include "engine-bridge/scene/Convert.h"

namespace midair::bridge
{

Eigen::Matrix4d toEigen(const osg::Matrixd& matrix)
{
    // OSG stores row by row; Eigen reads this column by column, which gives the transpose.
    return Eigen::Map<const Eigen::Matrix4d>(matrix.ptr());
}

osg::Matrixd toOsg(const Eigen::Matrix4d& matrix)
{
    return osg::Matrixd(matrix.data());
}

} // namespace midair::bridge
