#include "engine-bridge/hands/HandProximity.h"

#include "engine-bridge/hands/PressedSkin.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kAreaResolution_m = 2e-3; ///< error of a finger's disc: about half a percent

const HapticObject* find(const std::vector<HapticObject>& objects, std::uint64_t id)
{
    for (const HapticObject& object : objects)
        if (object.touchId() == id) return &object;
    return nullptr;
}

/// A sphere.
struct Ball
{
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double radius_m = 0.0;
};

Ball ballRound(const std::vector<HandCapsule>& capsules)
{
    Eigen::AlignedBox3d box;
    for (const HandCapsule& capsule : capsules)
        for (const Eigen::Vector3d& end : {capsule.shape.a, capsule.shape.b})
            box.extend(Eigen::AlignedBox3d(end.array() - capsule.shape.radius_m,
                                           end.array() + capsule.shape.radius_m));
    return {box.center(), 0.5 * box.sizes().norm()};
}

} // namespace

// Returns the object's peak pressure felt by the finger; \a within: number of played points within
// it.
double HandProximity::pressureOf(const HapticObject& object, int& within) const
{
    within = 0;
    const HapticProperties& properties = object.properties;
    if (!_played) return properties.pressureInPa ? properties.pressure : 0.0;
    const Eigen::Isometry3d toMesh = object.pose.inverse();
    std::vector<const Capsule*> parts;
    for (const Capsule& part : _overlapping)
        parts.push_back(&part);
    double sum = 0.0;
    int count = 0;
    for (Eigen::Index i = 0; i < _played->positions.cols(); ++i)
    {
        const Eigen::Vector3d point = toMesh * _played->positions.col(i);
        const double away = skinDistance(parts, point);
        if (!(away <= kFelt_m)) continue;
        sum += std::pow(static_cast<double>(_played->pressure_Pa[i]), 2);
        ++count;
        if (away <= 0.0) ++within;
    }
    return count > 0 ? std::sqrt(sum / count) : 0.0;
}

void HandProximity::estimateForce(const HapticObject& object,
                                  const MeshDistance& mesh,
                                  HandContact& contact)
{
    contact.overlap_m2 = mesh.overlapArea(_overlapping, kAreaResolution_m);
    int within = 0;
    const double p = pressureOf(object, within);
    // Lines and points have no area of their own.
    if (!(contact.overlap_m2 > 0.0)) contact.overlap_m2 = within * 0.25 * kFelt_m * kFelt_m;
    contact.force_N = haptics::radiationForce(p, contact.overlap_m2, haptics::Medium(), kAlpha);
}

void HandProximity::measure(const HapticObject& object,
                            const MeshDistance& mesh,
                            int hand,
                            int finger,
                            const std::vector<HandCapsule>& capsules)
{
    const Eigen::Isometry3d toMesh = object.pose.inverse();
    HandContact contact;
    contact.object = object.touchId();
    contact.hand = hand;
    contact.finger = finger;
    contact.distance_m = INFINITY;
    _overlapping.clear();
    _bones.clear();
    for (const HandCapsule& capsule : capsules)
    {
        if (capsule.hand != hand || fingerOf(capsule.bone) != finger) continue;
        const Capsule shape = moved(capsule.shape, toMesh);
        const double away = pointSegmentDistance(mesh.centre(), shape.a, shape.b) - shape.radius_m;
        _bones.push_back({away, shape, capsule.bone});
    }
    // Sorts the probably nearest bone to the front: each search is limited to the shortest distance
    // so far, so the others become short.
    std::stable_sort(_bones.begin(),
                     _bones.end(),
                     [](const Bone& a, const Bone& b) { return a.away_m < b.away_m; });
    for (const Bone& bone : _bones)
    {
        const std::optional<double> depth_m =
            pressedDepth_m(_presses, hand, bone.bone, mesh, toMesh);
        const double range = std::min(kRange_m, contact.distance_m);
        const NearestSpot spot =
            mesh.nearest(bone.shape, std::max(range, depth_m ? kPressReach_m : 0.0));
        if (spot.triangle >= 0 && isClipped(object.clips, object.pose * spot.onSurface)) continue;
        contact.pushing = contact.pushing || depth_m;
        const double out_m = depth_m ? pressedOut_m(spot.distance_m, *depth_m) : 0.0;
        if (spot.triangle >= 0 && spot.distance_m < out_m)
            _overlapping.push_back({bone.shape.a, bone.shape.b, bone.shape.radius_m + out_m});
        if (spot.triangle < 0 || spot.distance_m >= contact.distance_m) continue;
        contact.distance_m = spot.distance_m;
        contact.bone = bone.bone;
        contact.position = object.pose * spot.onSurface;
    }
    if (contact.distance_m > kRange_m) return;
    if (!_overlapping.empty()) estimateForce(object, mesh, contact);
    add(contact);
}

// Parts of one instance share a contact: at the nearest part, with the sum of the forces.
void HandProximity::add(const HandContact& contact)
{
    for (HandContact& other : _contacts)
    {
        if (other.object != contact.object || other.hand != contact.hand ||
            other.finger != contact.finger)
            continue;
        const HandContact before = other;
        if (contact.distance_m <= before.distance_m) other = contact;
        other.overlap_m2 = before.overlap_m2 + contact.overlap_m2;
        other.force_N = before.force_N + contact.force_N;
        other.pushing = before.pushing || contact.pushing;
        return;
    }
    _contacts.push_back(contact);
}

HandProximity::Touch* HandProximity::touchOf(const HandContact& contact)
{
    for (Touch& touch : _touches)
        if (touch.contact.object == contact.object && touch.contact.hand == contact.hand &&
            touch.contact.finger == contact.finger)
            return &touch;
    return nullptr;
}

void HandProximity::compare(const std::vector<HapticObject>& objects, double time_s)
{
    for (HandContact& contact : _contacts)
    {
        Touch* touch = touchOf(contact);
        contact.touching = contact.pushing || (touch ? contact.distance_m <= kLeave_m ||
                                                           time_s - touch->lastPushed_s <= kHold_s
                                                     : contact.distance_m < 0.0);
        if (!contact.touching) continue;
        const double pushed_s = contact.pushing ? time_s : touch ? touch->lastPushed_s : kNever_s;
        if (!touch)
        {
            const HapticObject* object = find(objects, contact.object);
            const std::string path = object ? object->path : std::string();
            _touches.push_back({contact, path, time_s, _updates, pushed_s});
            _events.push_back({TouchEvent::ENTER, contact.object, path, time_s, contact});
            continue;
        }
        touch->contact = contact;
        touch->lastSeen_s = time_s;
        touch->lastUpdate = _updates;
        touch->lastPushed_s = pushed_s;
        _ongoing.push_back({TouchEvent::STAY, contact.object, touch->path, time_s, contact});
    }
}

void HandProximity::endTouches(const std::vector<HapticObject>& objects,
                               const std::vector<HandCapsule>& capsules,
                               double time_s)
{
    const auto ended = [&](const Touch& touch)
    {
        if (touch.lastUpdate == _updates) return false;
        if (!find(objects, touch.contact.object)) return true;
        // A finger without tracked bones counts as lost.
        const bool known = std::any_of(capsules.begin(),
                                       capsules.end(),
                                       [&](const HandCapsule& capsule) {
                                           return capsule.hand == touch.contact.hand &&
                                                  fingerOf(capsule.bone) == touch.contact.finger;
                                       });
        return known || time_s - touch.lastSeen_s > kHold_s;
    };
    for (const Touch& touch : _touches)
    {
        if (!ended(touch)) continue;
        _events.push_back(
            {TouchEvent::LEAVE, touch.contact.object, touch.path, time_s, touch.contact});
        _events.back().contact.touching = false;
    }
    _touches.erase(std::remove_if(_touches.begin(), _touches.end(), ended), _touches.end());
}

void HandProximity::update(const std::vector<HapticObject>& objects,
                           const HandFrame& hands,
                           double time_s)
{
    ++_updates;
    clear();
    _meshes.beginUpdate();
    _presses = hands.presses;
    const std::vector<HandCapsule> capsules = handCapsules(hands);
    const Ball ball = ballRound(capsules);
    for (const HapticObject& object : objects)
    {
        if (capsules.empty()) break;
        if (!object.mesh) continue;
        const std::shared_ptr<const MeshDistance> mesh = _meshes.get(object);
        if (!mesh) continue;
        const double gap =
            (object.pose * mesh->centre() - ball.centre).norm() - mesh->radius_m() - ball.radius_m;
        if (gap > kRange_m) continue;
        for (const Hand& hand : hands.hands)
            for (int finger = 0; finger < HAND_FINGERS; ++finger)
                measure(object, *mesh, hand.id, finger, capsules);
    }
    compare(objects, time_s);
    endTouches(objects, capsules, time_s);
    _meshes.endUpdate();
}

std::vector<bool> withinReach(const Eigen::Matrix3Xd& points,
                              const std::vector<HandCapsule>& capsules,
                              double reach_m)
{
    std::vector<bool> within(static_cast<std::size_t>(points.cols()), false);
    if (capsules.empty()) return within;
    const Ball ball = ballRound(capsules);
    const double farthest = ball.radius_m + reach_m;
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        const Eigen::Vector3d point = points.col(l);
        if (!((point - ball.centre).squaredNorm() <= farthest * farthest)) continue;
        within[static_cast<std::size_t>(l)] =
            std::any_of(capsules.begin(),
                        capsules.end(),
                        [&](const HandCapsule& capsule)
                        {
                            return pointSegmentDistance(point, capsule.shape.a, capsule.shape.b) <=
                                   capsule.shape.radius_m + reach_m;
                        });
    }
    return within;
}

} // namespace midair::bridge
