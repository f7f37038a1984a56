#include "samples/tools/sense/SensePlace.h"

#include <Eigen/Geometry>

namespace midair::samples
{

namespace
{

constexpr double kOneSided = 0.5; // length of the mean of all directions

} // namespace

Eigen::Matrix4d patternPlace(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& normals)
{
    Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
    if (positions.cols() == 0 || normals.cols() == 0) return place;
    const Eigen::Vector3d mean = normals.colwise().normalized().rowwise().mean();
    if (!(mean.norm() >= kOneSided)) return place;
    const Eigen::Vector3d z = mean.normalized();
    place.topLeftCorner<3, 3>() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), z).toRotationMatrix();
    const Eigen::Vector3d middle_m =
        0.5 * (positions.rowwise().minCoeff() + positions.rowwise().maxCoeff());
    place.topRightCorner<3, 1>() = middle_m + kPatternHeight_m * z;
    return place;
}

} // namespace midair::samples
