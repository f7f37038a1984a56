#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"
#include "engine-bridge/hands/TouchMeshes.h"
#include "haptics/array/Medium.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// One finger of a hand near one object, in the last update.
struct HandContact
{
    std::uint64_t object = 0; ///< HapticObject::touchId()
    int hand = 0;             ///< Hand::id
    int finger = 0;           ///< HandFinger
    int bone = 0;             ///< the bone nearest to the object
    double distance_m = 0.0;  ///< skin to surface; under 0: they overlap
    /// the nearest point on the object, in the objects' frame (array)
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    bool touching = false;
    bool pushing = false;    ///< it pushes a body with this surface
    double overlap_m2 = 0.0; ///< area of the object's surface within the hand
    double force_N = 0.0;    ///< an estimate, see HandProximity
};

/// Begin, continuation or end of a touch.
struct TouchEvent
{
    enum Kind
    {
        ENTER,
        STAY,
        LEAVE
    };
    Kind kind = ENTER;
    std::uint64_t object = 0; ///< HapticObject::touchId()
    std::string path;         ///< the object's node path
    double time_s = 0.0;
    HandContact contact; ///< as measured in this update; for LEAVE the last measurement
};

/// Played points and the peak pressure at each, in the objects' frame.
struct PlayedPressure
{
    Eigen::Matrix3Xd positions;  ///< 3 x n, m
    Eigen::VectorXf pressure_Pa; ///< n; peak
};

/// Detects fingers near objects, and the begin, continuation and end of touches.
///
/// The force is an estimate, F = alpha p^2 / (2 rho c^2) A. p^2 is the mean squared pressure at the
/// played points within kFelt_m of the finger's parts in the object; 0 without such points. If the
/// played field is unknown, p is the object's wanted pressure. A is the area of its surface within
/// the finger; for lines and points (kFelt_m / 2)^2, about a focus, for each played point within
/// it. It is an upper estimate: it assumes the pressure of the points on the whole area, although
/// the field is weaker in between. If a finger pushes a body (HandFrame::presses), its skin is
/// flattened on the body (PressedSkin.h) for A only: the distance stays that of the tracked skin.
/// All data is in metres and in the objects' frame. Only one thread at a time may use an instance.
/// For a large mesh (TouchMeshes) the newest prepared one is measured, with the object's newest
/// pose: a new object is not touched for some frames, a deforming one is touched in its shape of
/// some frames ago.
class HandProximity
{
public:
    /// Hands farther than this from an object are not measured.
    static constexpr double kRange_m = 0.05;
    /// A touch begins when skin and surface overlap or the finger pushes the object, and ends when
    /// they are farther apart than this, so that tremor causes no events.
    static constexpr double kLeave_m = 4e-3;
    /// Touches of a lost hand last for this time, and so do those of a pushed body that runs away.
    static constexpr double kHold_s = 0.1;
    /// Reflection by skin: total (equation 1 of the paper).
    static constexpr double kAlpha = 2.0;

    /// Measures the distances of \a hands (in the objects' frame) to \a objects at \a time_s, which
    /// must not decrease. Touches end when the skin is farther than kLeave_m and has pushed nothing
    /// for kHold_s, when their object is gone, or when their hand is gone for longer than kHold_s.
    void update(const std::vector<HapticObject>& objects, const HandFrame& hands, double time_s);

    /// Hands within kRange_m of objects at the last update.
    const std::vector<HandContact>& contacts() const { return _contacts; }
    /// Begins and ends in the last update.
    const std::vector<TouchEvent>& events() const { return _events; }
    /// Continuing touches in the last update; without those of lost fingers.
    const std::vector<TouchEvent>& ongoing() const { return _ongoing; }

    /// Number of touching pairs of a finger and an object.
    std::size_t touches() const { return _touches.size(); }

    /// Clears the contacts and events of the last update; touches continue.
    void clear()
    {
        _contacts.clear();
        _events.clear();
        _ongoing.clear();
    }

    /// Sets the played field, for forces; null: unknown.
    void setPlayed(std::shared_ptr<const PlayedPressure> played) { _played = std::move(played); }

    /// About a wavelength: distance up to which a point's pressure is felt.
    static constexpr double kFelt_m = 8.6e-3;

private:
    static constexpr double kNever_s = -1e9;

    /// A touch that has not ended.
    struct Touch
    {
        HandContact contact;
        std::string path;
        double lastSeen_s = 0.0;
        std::uint64_t lastUpdate = 0;
        double lastPushed_s = kNever_s;
    };

    /// A bone of the hand being measured.
    struct Bone
    {
        double away_m; ///< distance of its skin from the mesh's centre
        Capsule shape; ///< mesh frame
        int bone;
    };

    void measure(const HapticObject& object,
                 const MeshDistance& mesh,
                 int hand,
                 int finger,
                 const std::vector<HandCapsule>& capsules);
    void add(const HandContact& contact);
    double pressureOf(const HapticObject& object, int& within) const;
    void estimateForce(const HapticObject& object, const MeshDistance& mesh, HandContact& contact);
    void compare(const std::vector<HapticObject>& objects, double time_s);
    void endTouches(const std::vector<HapticObject>& objects,
                    const std::vector<HandCapsule>& capsules,
                    double time_s);
    Touch* touchOf(const HandContact& contact);

    TouchMeshes _meshes;
    std::uint64_t _updates = 0;
    std::vector<Bone> _bones;
    std::vector<HandPress> _presses;   ///< objects' frame
    std::vector<Capsule> _overlapping; ///< of the finger being measured, in the mesh's frame
    std::shared_ptr<const PlayedPressure> _played; ///< null: unknown
    std::vector<HandContact> _contacts;
    std::vector<Touch> _touches;
    std::vector<TouchEvent> _events;
    std::vector<TouchEvent> _ongoing;
};

/// Returns for each of \a points (3 x n) whether it is within \a reach_m of the skin of any of \a
/// capsules.
std::vector<bool> withinReach(const Eigen::Matrix3Xd& points,
                              const std::vector<HandCapsule>& capsules,
                              double reach_m);

} // namespace midair::bridge
