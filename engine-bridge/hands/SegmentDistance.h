#pragma once

#include <Eigen/Core>

namespace midair::bridge
{

/// Two places and the distance between them.
struct ClosestPair
{
    Eigen::Vector3d onSegment;
    Eigen::Vector3d onOther;
    double distance = 0.0; ///< metres
};

/// Segment a-b against segment c-d (Ericson, Real-Time Collision Detection, 5.1.9); points are
/// segments without length.
ClosestPair closestSegments(const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c,
                            const Eigen::Vector3d& d);

/// Segment a-b against the triangle p, q, r, its inside included; 0 where they cross. Flat
/// triangles count as their edges.
ClosestPair closestSegmentTriangle(const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& p,
                                   const Eigen::Vector3d& q,
                                   const Eigen::Vector3d& r);

/// Distance of \a point from segment a-b.
double pointSegmentDistance(const Eigen::Vector3d& point,
                            const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b);

} // namespace midair::bridge
