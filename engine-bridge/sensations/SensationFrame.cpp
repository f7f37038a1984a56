#include "engine-bridge/sensations/SensationFrame.h"

#include <utility>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kFarthestSurface_m = 10.0; // nothing that is felt is farther

/// Returns the outer normal of a triangle; +z for one without area.
Vector3d normalOf(const haptics::TriangleMesh& mesh, int triangle)
{
    const auto corner = [&](int k)
    { return Vector3d(mesh.vertices.col(mesh.triangles(k, triangle))); };
    const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    return normal.norm() > 0.0 ? normal.normalized() : Vector3d::UnitZ();
}

} // namespace

Vector3d SensationFrame::at(const Vector3d& pattern_m) const
{
    Vector3d place = toArray * pattern_m;
    if (!surface) return place;
    const Vector3d flat = toArray * Vector3d(pattern_m.x(), pattern_m.y(), 0.0);
    const Vector3d inMesh = surfacePose.inverse() * flat;
    const NearestSpot spot = surface->nearest({inMesh, inMesh, 0.0}, kFarthestSurface_m);
    if (spot.triangle < 0) return place;
    return surfacePose * spot.onSurface + pattern_m.z() * normal();
}

std::optional<SensationFrame> frameOfHand(const HandFrame& hands, int joint, int& hand)
{
    for (const Hand& one : hands.hands)
    {
        const HandJoint& at = one.joints[static_cast<std::size_t>(joint)];
        const bool isKnown = at.positionValid && at.orientationValid && at.position.allFinite() &&
                             at.orientation.coeffs().allFinite();
        if ((hand >= 0 && one.id != hand) || !isKnown) continue;
        hand = one.id;
        // OpenXR: -z along the fingers, +y out of the back of the hand.
        const Eigen::Matrix3d axes = at.orientation.normalized().toRotationMatrix();
        const bool isLeft = one.id % 2 == 0;
        SensationFrame frame;
        frame.toArray.linear().col(0) = isLeft ? Vector3d(axes.col(0)) : Vector3d(-axes.col(0));
        frame.toArray.linear().col(1) = -axes.col(2);
        frame.toArray.linear().col(2) = -axes.col(1);
        frame.toArray.translation() = at.position + at.radius_m * frame.normal();
        return frame;
    }
    return std::nullopt;
}

namespace
{

SensationFrame frameAt(const Eigen::Isometry3d& pose,
                       std::shared_ptr<const MeshDistance> surface,
                       const Vector3d& place,
                       const Vector3d& normal)
{
    Vector3d along = pose.linear().col(0);
    along -= along.dot(normal) * normal;
    constexpr double kAcross = 1e-3;
    if (along.norm() < kAcross) along = pose.linear().col(1).cross(normal);
    along.normalize();
    SensationFrame frame;
    frame.toArray.linear().col(0) = along;
    frame.toArray.linear().col(1) = normal.cross(along);
    frame.toArray.linear().col(2) = normal;
    frame.toArray.translation() = place;
    frame.surface = std::move(surface);
    frame.surfacePose = pose;
    return frame;
}

} // namespace

SensationFrame frameOnSurface(const ContactPatch& touch)
{
    return frameAt(touch.objectPose, touch.surface, touch.centre, touch.normal);
}

SensationFrame frameUnderOrigin(const HapticObject& object,
                                std::shared_ptr<const MeshDistance> surface)
{
    const Vector3d origin = Vector3d::Zero();
    NearestSpot spot;
    if (surface) spot = surface->nearest({origin, origin, 0.0}, kFarthestSurface_m);
    if (spot.triangle < 0)
    {
        SensationFrame frame;
        frame.toArray = object.pose;
        return frame;
    }
    const Vector3d normal = normalOf(surface->mesh(), spot.triangle);
    return frameAt(object.pose,
                   std::move(surface),
                   object.pose * spot.onSurface,
                   object.pose.linear() * normal);
}

} // namespace midair::bridge
