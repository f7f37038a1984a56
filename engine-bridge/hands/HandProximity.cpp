#include "engine-bridge/hands/HandProximity.h"

#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kAreaResolution_m = 2e-3;  ///< gives a finger's disc to about half a percent
constexpr std::uint64_t kKeptUpdates = 600; ///< meshes not measured in as many are dropped

Capsule moved(const Capsule& capsule, const Eigen::Isometry3d& motion)
{
    return {motion * capsule.a, motion * capsule.b, capsule.radius_m};
}

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
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY);
    Eigen::Vector3d high = -low;
    for (const HandCapsule& capsule : capsules)
    {
        const Eigen::Vector3d r = Eigen::Vector3d::Constant(capsule.shape.radius_m);
        low = low.cwiseMin(capsule.shape.a.cwiseMin(capsule.shape.b) - r);
        high = high.cwiseMax(capsule.shape.a.cwiseMax(capsule.shape.b) + r);
    }
    return {0.5 * (low + high), 0.5 * (high - low).norm()};
}

} // namespace

bool ProximityOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ProximityOptions: ")
        .require(std::isfinite(enter_m), "enter_m must be finite")
        .check(leave_m >= enter_m && std::isfinite(leave_m), "leave_m", leave_m, "at least enter_m")
        .check(range_m >= leave_m && range_m >= 0.0 && std::isfinite(range_m),
               "range_m",
               range_m,
               "at least leave_m and not under 0")
        .check(hold_s >= 0.0, "hold_s", hold_s, "at least 0")
        .within("alpha", alpha, 1.0, 2.0)
        .check(relative_Pa >= 0.0, "relative_Pa", relative_Pa, "at least 0")
        .passed(error);
}

HandProximity::HandProximity(const ProximityOptions& options, const haptics::Medium& medium) :
    _options(options),
    _medium(medium)
{
    std::string error;
    if (!options.isValid(&error) || !medium.isValid(&error)) throw base::InputError(error);
}

MeshDistance& HandProximity::meshOf(const HapticObject& object)
{
    CachedMesh& cached = _meshes[object.meshId];
    if (!cached.distance) cached.distance = std::make_unique<MeshDistance>(object.mesh);
    cached.lastUse = _updates;
    return *cached.distance;
}

void HandProximity::estimateForce(const HapticObject& object,
                                  const MeshDistance& mesh,
                                  HandContact& contact)
{
    contact.overlap_m2 = mesh.overlapArea(_overlapping, kAreaResolution_m);
    const HapticProperties& properties = object.properties;
    const double p =
        properties.pressureInPa ? properties.pressure : properties.pressure * _options.relative_Pa;
    contact.force_N = haptics::radiationForce(p, contact.overlap_m2, _medium, _options.alpha);
}

void HandProximity::measure(const HapticObject& object,
                            int hand,
                            const std::vector<HandCapsule>& capsules)
{
    const MeshDistance& mesh = meshOf(object);
    const Eigen::Isometry3d toMesh = object.pose.inverse();
    HandContact contact;
    contact.object = object.touchId();
    contact.hand = hand;
    contact.distance_m = INFINITY;
    _overlapping.clear();
    _bones.clear();
    for (const HandCapsule& capsule : capsules)
    {
        if (capsule.hand != hand) continue;
        const Capsule shape = moved(capsule.shape, toMesh);
        const double away = pointSegmentDistance(mesh.centre(), shape.a, shape.b) - shape.radius_m;
        _bones.push_back({away, shape, capsule.bone});
    }
    // Sorts the likely nearest bone to the front: each search is limited to the nearest distance so
    // far, so the others become short.
    std::stable_sort(_bones.begin(),
                     _bones.end(),
                     [](const Bone& a, const Bone& b) { return a.away_m < b.away_m; });
    for (const Bone& bone : _bones)
    {
        const double range = std::min(_options.range_m, contact.distance_m);
        const NearestSpot spot = mesh.nearest(bone.shape, std::max(range, 0.0));
        if (spot.triangle >= 0 && spot.distance_m < 0.0) _overlapping.push_back(bone.shape);
        if (spot.triangle < 0 || spot.distance_m >= contact.distance_m) continue;
        contact.distance_m = spot.distance_m;
        contact.bone = bone.bone;
        contact.position = object.pose * spot.onSurface;
    }
    if (contact.distance_m > _options.range_m) return;
    if (contact.distance_m < 0.0) estimateForce(object, mesh, contact);
    for (HandContact& other : _contacts)
    {
        if (other.object != contact.object || other.hand != hand) continue;
        // Parts of one instance share a contact: at the part that is nearest, with the sum of the
        // forces.
        contact.overlap_m2 += other.overlap_m2;
        contact.force_N += other.force_N;
        if (other.distance_m < contact.distance_m)
        {
            contact.distance_m = other.distance_m;
            contact.bone = other.bone;
            contact.position = other.position;
        }
        other = contact;
        return;
    }
    _contacts.push_back(contact);
}

HandProximity::Touch* HandProximity::touchOf(std::uint64_t object, int hand)
{
    for (Touch& touch : _touches)
        if (touch.contact.object == object && touch.contact.hand == hand) return &touch;
    return nullptr;
}

void HandProximity::compare(const std::vector<HapticObject>& objects, double time_s)
{
    for (HandContact& contact : _contacts)
    {
        Touch* touch = touchOf(contact.object, contact.hand);
        contact.touching =
            touch ? contact.distance_m <= _options.leave_m : contact.distance_m < _options.enter_m;
        if (!contact.touching) continue;
        if (!touch)
        {
            const HapticObject* object = find(objects, contact.object);
            const std::string path = object ? object->path : std::string();
            _touches.push_back({contact, path, time_s, _updates});
            _events.push_back({TouchEvent::ENTER, contact.object, path, time_s, contact});
            continue;
        }
        touch->contact = contact;
        touch->lastSeen_s = time_s;
        touch->lastUpdate = _updates;
    }
}

void HandProximity::endTouches(const std::vector<HapticObject>& objects,
                               const HandFrame& hands,
                               double time_s)
{
    const auto ended = [&](const Touch& touch)
    {
        if (touch.lastUpdate == _updates) return false;
        if (!find(objects, touch.contact.object)) return true;
        const bool known =
            std::any_of(hands.hands.begin(),
                        hands.hands.end(),
                        [&](const Hand& hand) { return hand.id == touch.contact.hand; });
        return known || time_s - touch.lastSeen_s > _options.hold_s;
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

void HandProximity::forgetMeshes()
{
    for (auto it = _meshes.begin(); it != _meshes.end();)
        it = it->second.lastUse + kKeptUpdates < _updates ? _meshes.erase(it) : std::next(it);
}

void HandProximity::update(const std::vector<HapticObject>& objects,
                           const HandFrame& hands,
                           double time_s)
{
    ++_updates;
    _contacts.clear();
    _events.clear();
    const std::vector<HandCapsule> capsules = handCapsules(hands);
    // A hand without any tracked bone counts as lost.
    HandFrame known;
    for (const Hand& hand : hands.hands)
        if (std::any_of(capsules.begin(),
                        capsules.end(),
                        [&](const HandCapsule& c) { return c.hand == hand.id; }))
            known.hands.push_back(hand);
    const Ball ball = ballRound(capsules);
    for (const HapticObject& object : objects)
    {
        if (capsules.empty()) break;
        if (!object.mesh || object.mesh->triangles.cols() == 0) continue;
        // Tests the bounds first, so that the hierarchy of a mesh out of range is not built.
        const MeshDistance& mesh = meshOf(object);
        const double gap =
            (object.pose * mesh.centre() - ball.centre).norm() - mesh.radius_m() - ball.radius_m;
        if (gap > _options.range_m) continue;
        for (const Hand& hand : known.hands)
            measure(object, hand.id, capsules);
    }
    compare(objects, time_s);
    endTouches(objects, known, time_s);
    forgetMeshes();
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
