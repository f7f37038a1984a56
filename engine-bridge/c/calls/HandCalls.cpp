// midair_set_hands() and related calls: hands in, contacts and touches out.
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/c/inside/OwnSource.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/sensations/SensationTexts.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

/// Converts a hand of the application; fails for an invalid one, naming its number \a index.
bridge::Hand handOf(const midair_hand& given, std::size_t index)
{
    const auto refuse = [&](const std::string& what)
    { fail(MIDAIR_INVALID, fmt::format("hand {}: {}", index, what)); };
    bridge::Hand hand;
    hand.id = given.id;
    hand.age_s = given.age_s;
    if (!(given.age_s >= 0.0 && given.age_s <= 1e6))
        refuse(fmt::format("age_s is {:g}; it must be 0 .. 1e6", given.age_s));
    for (std::size_t j = 0; j < MIDAIR_JOINTS; ++j)
    {
        const midair_joint& from = given.joints[j];
        bridge::HandJoint& to = hand.joints[j];
        const auto finite = [](const double* numbers, int count) {
            return std::all_of(numbers, numbers + count, [](double x) { return std::isfinite(x); });
        };
        to.positionValid = from.position_valid != 0;
        to.orientationValid = from.orientation_valid != 0;
        if (to.positionValid && (!finite(from.position, 3) || !(from.radius_m > 0.0) ||
                                 !(from.radius_m <= bridge::kThickestJoint_m)))
            refuse(
                fmt::format("joint {} is valid, at ({:g}, {:g}, {:g}) m with a radius of {:g} m; "
                            "it must be finite, the radius above 0 and at most 0.1",
                            j,
                            from.position[0],
                            from.position[1],
                            from.position[2],
                            from.radius_m));
        const double length = Eigen::Vector4d::Map(from.orientation).norm();
        if (to.orientationValid && !(std::abs(length - 1.0) < 1e-3))
            refuse(fmt::format(
                "joint {} has a valid orientation of length {:g}; it must be 1", j, length));
        if (to.positionValid)
        {
            to.position = Eigen::Vector3d::Map(from.position);
            to.radius_m = from.radius_m;
        }
        if (to.orientationValid)
            to.orientation =
                Eigen::Quaterniond(Eigen::Vector4d(Eigen::Vector4d::Map(from.orientation)));
    }
    return hand;
}

/// Converts a hand of the scene.
midair_hand handForC(const bridge::Hand& from)
{
    midair_hand hand{};
    hand.id = from.id;
    hand.age_s = from.age_s;
    for (std::size_t j = 0; j < MIDAIR_JOINTS; ++j)
    {
        const bridge::HandJoint& joint = from.joints[j];
        midair_joint& to = hand.joints[j];
        Eigen::Vector3d::Map(to.position) = joint.position;
        Eigen::Vector4d::Map(to.orientation) = joint.orientation.coeffs();
        to.radius_m = joint.radius_m;
        to.position_valid = joint.positionValid ? 1 : 0;
        to.orientation_valid = joint.orientationValid ? 1 : 0;
    }
    return hand;
}

/// A hand source of the application.
class OwnHands : public bridge::HandSource
{
public:
    OwnHands(const midair_hand_source& source, const std::string& options) :
        _source(source, options)
    {
    }

    bool frameAt(double time_s, bridge::HandFrame& frame) override
    {
        frame.hands.clear();
        int32_t count = -1;
        {
            const CallbackScope inside;
            _hands.assign(kMostHands, midair_hand{});
            count =
                _source.callbacks().hands(_source.instance(), time_s, _hands.data(), _hands.size());
        }
        if (count > static_cast<int32_t>(_hands.size()))
            throw std::runtime_error(
                fmt::format("{} hands, where there is room for {}", count, _hands.size()));
        for (int32_t i = 0; i < count; ++i)
            frame.hands.push_back(
                handOf(_hands[static_cast<std::size_t>(i)], static_cast<std::size_t>(i)));
        return count > 0;
    }
    std::string status() const override { return "a hand source of the application"; }

private:
    static constexpr std::size_t kMostHands = 8;

    const OwnSource<midair_hand_source> _source;
    std::vector<midair_hand> _hands;
};

} // namespace

midair_status midair_register_hands(const char* name, const midair_hand_source* source)
{
    return called(
        [&]
        {
            const std::string registered = textGiven(name, "name", 256);
            const midair_hand_source& all = given(source, "source");
            requireSize(all);
            if (!all.open || !all.hands) fail(MIDAIR_INVALID, "open or hands is NULL");
            std::string error;
            const auto open = [copy = all](const std::string& options)
            { return std::make_shared<OwnHands>(copy, options); };
            if (!bridge::registerHands(registered, open, error)) fail(MIDAIR_REFUSED, error);
        });
}

midair_status midair_set_hands(midair_scene* scene, const midair_hand* hands, size_t count)
{
    return called(
        [&]
        {
            constexpr std::size_t kMostHands = 64;
            const auto of = sceneOf(scene);
            of->hands->clear(); // so that no old hands remain after an error
            if (count > kMostHands)
                fail(MIDAIR_INVALID,
                     fmt::format("count is {}; it must be 0 .. {}", count, kMostHands));
            if (count > 0) given(hands, "hands");
            bridge::HandFrame frame;
            frame.time_s = base::steadySeconds();
            for (std::size_t i = 0; i < count; ++i)
                frame.hands.push_back(handOf(hands[i], i));
            of->hands->set(frame);
        });
}

midair_status midair_open_hands(midair_scene* scene, const char* source)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string uri = textGiven(source, "source", 4096);
            if (const std::string why = bridge::unknownHands(uri); !why.empty())
                fail(MIDAIR_UNKNOWN, why);
            const std::shared_ptr<bridge::HandSource> opened = bridge::openHands(uri);
            std::shared_ptr<bridge::HandSource> before; // destroyed without the mutex
            const base::Lock lock(of->mutex);
            if (of->isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
            before = of->player.hands().active();
            of->player.setHandSource(opened ? opened : of->hands);
        });
}

midair_status
midair_make_hand(int32_t id, const double tip[3], const double orientation[4], midair_hand* hand)
{
    return called(
        [&]
        {
            requireFinite(&given(tip, "tip"), 3, "tip");
            requireFinite(&given(orientation, "orientation"), 4, "orientation");
            const Eigen::Quaterniond turn(Eigen::Vector4d(Eigen::Vector4d::Map(orientation)));
            if (!(std::abs(turn.norm() - 1.0) < 1e-3))
                fail(MIDAIR_INVALID,
                     fmt::format("orientation has the length {:g}; it must be 1", turn.norm()));
            given(hand, "hand") =
                handForC(bridge::openHandWithIndexTipAt(id, Eigen::Vector3d::Map(tip), turn));
        });
}

midair_status
midair_last_hands(midair_scene* scene, midair_hand* hands, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            return copyAll(of->player.hands().frame().hands, hands, capacity, count, handForC);
        });
}

namespace
{

midair_contact contactOf(const bridge::ContactView& view)
{
    midair_contact contact{};
    contact.id = view.id;
    contact.object = view.patch.object;
    contact.hand = view.patch.hand;
    contact.foci = static_cast<uint32_t>(view.foci.cols());
    Eigen::Vector3d::Map(contact.centre) = view.patch.centre;
    Eigen::Vector3d::Map(contact.normal) = view.patch.normal;
    contact.depth_m = view.patch.depth_m;
    contact.area_m2 = view.patch.area_m2;
    contact.semi_major_m = view.patch.semiMajor_m;
    contact.semi_minor_m = view.patch.semiMinor_m;
    contact.speed_m_s = view.speed_m_s;
    contact.pressure_Pa = view.pressure_Pa.size() > 0 ? view.pressure_Pa[0] : 0.0;
    contact.share = view.share;
    return contact;
}

midair_sensation sensationOf(const bridge::SensationView& view)
{
    midair_sensation sensation{};
    sensation.object = view.object;
    sensation.playing = view.isPlaying ? 1 : 0;
    sensation.stopped = view.isStopped ? 1 : 0;
    sensation.pattern_time_ms = view.patternTime_ms;
    Eigen::Vector3d::Map(sensation.position) = view.place;
    sensation.intensity = view.intensity;
    sensation.pressure_Pa = view.pressure_Pa;
    return sensation;
}

midair_touch touchOf(const bridge::HandContact& near)
{
    midair_touch touch{};
    touch.object = near.object;
    touch.hand = near.hand;
    touch.finger = near.finger;
    touch.touching = near.touching ? 1 : 0;
    Eigen::Vector3d::Map(touch.position) = near.position;
    touch.distance_m = near.distance_m;
    touch.force_N = near.force_N;
    return touch;
}

} // namespace

midair_status
midair_contacts(midair_scene* scene, midair_contact* contacts, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const auto newest = of->device.empty() ? nullptr : of->player.latestResult();
            const std::vector<bridge::ContactView> all = newest && newest->touched
                                                             ? newest->touched->contacts
                                                             : std::vector<bridge::ContactView>();
            return copyAll(all, contacts, capacity, count, contactOf);
        });
}

midair_status
midair_sensations(midair_scene* scene, midair_sensation* sensations, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const auto newest = of->device.empty() ? nullptr : of->player.latestResult();
            const std::vector<bridge::SensationView> all =
                newest && newest->touched ? newest->touched->sensations
                                          : std::vector<bridge::SensationView>();
            return copyAll(all, sensations, capacity, count, sensationOf);
        });
}

midair_status midair_sensation_play(midair_scene* scene, midair_object object, int32_t plays)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            SceneObject& one = objectOf(*of, object);
            if (!one.felt.sensation.isMeant) fail(MIDAIR_INVALID, "the object has no sensation");
            if (one.properties.trigger != ObjectSettings::PROGRAM)
                fail(MIDAIR_INVALID, "the object's trigger isn't program");
            one.plays = plays ? bridge::nextPlays(one.plays, one.properties.plays)
                              : std::max(one.plays, one.properties.plays);
            one.properties.plays = one.felt.sensation.plays = plays ? one.plays : 0;
        });
}

midair_status
midair_touches(midair_scene* scene, midair_touch* touches, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            // It may have been muted or lost since the update.
            const bool sounds = of->player.reading().state == bridge::ArrayState::PLAYING;
            return copyAll(of->player.hands().proximity().contacts(),
                           touches,
                           capacity,
                           count,
                           [sounds](const bridge::HandContact& near)
                           {
                               midair_touch touch = touchOf(near);
                               if (!sounds) touch.force_N = 0.0;
                               return touch;
                           });
        });
}
