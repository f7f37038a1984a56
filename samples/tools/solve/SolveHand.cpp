#include "samples/tools/solve/SolveHand.h"

#include "engine-bridge/hands/round/RoundHand.h"
#include "haptics/base/Units.h"

#include <Eigen/Geometry>

namespace midair::samples
{

namespace
{

constexpr double kPadGap_m = 1e-3;

// The flat hand leans by so much from upright, and in its own plane by so much towards the little
// finger's side, that the index fingertip is its lowest place.
constexpr double kLean_deg = 30.0, kAside_deg = 35.0;

} // namespace

Eigen::Vector3d openSideOf(const haptics::TransducerArray& array)
{
    const Eigen::Vector3d mean = array.normals.rowwise().mean();
    return mean.norm() > 0.5 ? mean.normalized() : Eigen::Vector3d::UnitY();
}

Eigen::Vector3d padAbove(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& up)
{
    Eigen::Index top = 0;
    (up.transpose() * points).maxCoeff(&top);
    return points.col(top) + kPadGap_m * up;
}

haptics::TriangleMesh handMesh(Eigen::Index mostTriangles)
{
    return haptics::finestRoundBody(bridge::roundHand().cones, mostTriangles);
}

Eigen::Isometry3d pointingAt(const Eigen::Vector3d& pad, const Eigen::Vector3d& up)
{
    // First aside about y, then down.
    constexpr double kDown_deg = 90.0 - kLean_deg;
    const Eigen::Quaterniond rest =
        Eigen::AngleAxisd(-base::toRadians(kDown_deg), Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(-base::toRadians(kAside_deg), Eigen::Vector3d::UnitY());
    const bridge::RoundHand hand = bridge::roundHand();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), up) * rest)
                        .toRotationMatrix();
    pose.translation() = pad + hand.indexRadius_m * up - pose.linear() * hand.indexTip;
    return pose;
}

} // namespace midair::samples
