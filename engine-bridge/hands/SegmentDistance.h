#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::bridge
{

struct Capsule;

/// The nearest points of two shapes and their distance.
struct ClosestPair
{
    Eigen::Vector3d onSegment;
    Eigen::Vector3d onOther;
    double distance = 0.0; ///< metres
};

/// The nearest points of segments a-b and c-d (Ericson, Real-Time Collision Detection, 5.1.9);
/// segments may have length 0.
ClosestPair closestSegments(const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c,
                            const Eigen::Vector3d& d);

/// Returns the nearest points of segment a-b and triangle p, q, r, including its inside; distance 0
/// if they cross. For triangles without area only the edges count.
ClosestPair closestSegmentTriangle(const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& p,
                                   const Eigen::Vector3d& q,
                                   const Eigen::Vector3d& r);

/// Distance of a place from segment a-b, and its gradient there. As this distance is convex, that
/// of any place x is at least distance + slope . (x - place).
struct AxisDistance
{
    AxisDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& place);

    double distance;
    Eigen::Vector3d slope; ///< of unit length; zero on the segment
};

/// Distance of \a point from segment a-b.
double pointSegmentDistance(const Eigen::Vector3d& point,
                            const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b);

bool contains(const Capsule& capsule, const Eigen::Vector3d& point);

/// Distance of \a point from the skin of the union; under 0: inside.
double skinDistance(const std::vector<const Capsule*>& capsules, const Eigen::Vector3d& point);

} // namespace midair::bridge
