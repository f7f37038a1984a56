#include "engine-bridge/contact/ContactTracker.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kSameContactWay = 0.5; ///< cosine; contacts that turn farther at once are new
constexpr double kSpeedFollow_s = 0.03; ///< differences of a tracker's positions jitter

double followed(double from, double to, double dt_s, double time_s)
{
    return time_s > 0.0 ? from - std::expm1(-dt_s / time_s) * (to - from) : to;
}

bool shareBone(const ContactPatch& a, const ContactPatch& b)
{
    return std::any_of(
        a.bones.begin(),
        a.bones.end(),
        [&](int bone) { return std::find(b.bones.begin(), b.bones.end(), bone) != b.bones.end(); });
}

/// An old contact and a new patch that may continue it.
struct Match
{
    double distance_m = 0.0;
    std::size_t contact = 0;
    std::size_t patch = 0;
};

} // namespace

bool ContactTrackerOptions::isValid(std::string* error) const
{
    return finder.isValid(error) && path.isValid(error) &&
           base::RangeCheck("ContactTrackerOptions: ")
               .within("restart_m", restart_m, 1e-3, 1.0)
               .within("hold_s", hold_s, 0.0, 1.0)
               .within("follow_s", follow_s, 0.0, 1.0)
               .passed(error);
}

ContactTracker::ContactTracker(const ContactTrackerOptions& options,
                               const haptics::Medium& medium) :
    _options(options),
    _medium(medium),
    _finder(options.finder)
{
    std::string error;
    if (!options.isValid(&error) || !medium.isValid(&error)) throw base::InputError(error);
}

// Objects with an invalid material are left out, with a note.
std::vector<HapticObject> ContactTracker::takeMaterials(const std::vector<HapticObject>& objects)
{
    _materials.clear();
    std::vector<HapticObject> felt;
    for (const HapticObject& object : objects)
    {
        if (object.properties.material.isValid())
        {
            _materials[object.touchId()] = object.properties.material;
            felt.push_back(object);
        }
        else
            _notes.push_back({ContactReason::MATERIAL_INVALID, 0, -1, object.touchId()});
    }
    return felt;
}

// Phases continue.
void ContactTracker::useMaterial(Contact& contact) const
{
    const auto found = _materials.find(contact.path.patch().object);
    if (found == _materials.end() || found->second == contact.material) return;
    const HapticMaterial& m = contact.material = found->second;
    ContactForceOptions force = contact.force.options();
    force.stiffness_N_m = m.stiffness_N_m;
    force.mostForce_N = m.mostForce_N;
    contact.force = ContactForce(force, _medium);
    contact.vibration.setOptions(
        {m.lowVibration, m.low_Hz, m.highVibration, m.high_Hz, m.roughness, m.texturePeriod_m});
}

void ContactTracker::clear(ContactReason reason)
{
    _contacts.clear();
    _foci.clear();
    _notes.clear();
    if (reason != ContactReason::NONE) _notes.push_back({reason, 0, -1, 0});
}

Contact ContactTracker::begun(const ContactPatch& patch, double time_s)
{
    Contact contact = {++_begun,
                       ContactPath(_options.path, patch),
                       ContactForce({}, _medium),
                       ContactVibration(),
                       HapticMaterial(),
                       ContactPaint()};
    useMaterial(contact);
    contact.paint.follow(patch.surface, patch.objectPose.inverse() * patch.centre, time_s);
    contact.wanted_m = patch.depth_m;
    contact.lastSeen_s = time_s;
    measureSpeed(contact, patch, time_s);
    return contact;
}

// Relative to the object, along its surface; measured at the middle of the contact's first bone.
void ContactTracker::measureSpeed(Contact& contact, const ContactPatch& patch, double time_s) const
{
    const Capsule& bone = patch.own.front();
    const Vector3d now = patch.objectPose.inverse() * (0.5 * (bone.a + bone.b));
    const bool isSameBone = contact.path.patch().bones.front() == patch.bones.front();
    const double dt_s = time_s - contact.anchor_s;
    if (contact.anchor && isSameBone && dt_s > 0.0)
    {
        const Vector3d normal = patch.objectPose.linear().transpose() * patch.normal;
        Vector3d velocity = (now - *contact.anchor) / dt_s;
        velocity -= velocity.dot(normal) * normal;
        contact.speed_m_s = followed(contact.speed_m_s, velocity.norm(), dt_s, kSpeedFollow_s);
    }
    if (dt_s > 0.0 || !contact.anchor)
    {
        contact.anchor = now;
        contact.anchor_s = time_s;
    }
}

void ContactTracker::touched(Contact& contact, const ContactPatch& patch, double time_s)
{
    measureSpeed(contact, patch, time_s);
    useMaterial(contact);
    contact.paint.follow(patch.surface, patch.objectPose.inverse() * patch.centre, time_s);
    if (contact.wanted_m > 0.0 || contact.depth_m > 1e-6)
        contact.path.fit(patch);
    else
    {
        // It was silent, so its foci need not move there.
        contact.path = ContactPath(_options.path, patch, contact.path.angle_rad());
        contact.age_s = 0.0;
    }
    contact.wanted_m = patch.depth_m;
    contact.lastSeen_s = time_s;
}

// Matches the nearest pairs first; remaining patches start new contacts.
std::vector<Contact> ContactTracker::matched(std::vector<ContactPatch>& patches, double time_s)
{
    std::vector<Match> matches;
    for (std::size_t i = 0; i < _contacts.size(); ++i)
        for (std::size_t j = 0; j < patches.size(); ++j)
        {
            const ContactPatch& before = _contacts[i].path.patch();
            const double distance = (before.centre - patches[j].centre).norm();
            if (before.hand == patches[j].hand && before.object == patches[j].object &&
                before.normal.dot(patches[j].normal) >= kSameContactWay &&
                distance <= _options.restart_m)
                matches.push_back({distance, i, j});
        }
    std::stable_sort(matches.begin(),
                     matches.end(),
                     [](const Match& a, const Match& b) { return a.distance_m < b.distance_m; });
    std::vector<bool> isOld(_contacts.size()), isTaken(patches.size());
    std::vector<Contact> kept;
    for (const Match& match : matches)
    {
        if (isOld[match.contact] || isTaken[match.patch]) continue;
        isOld[match.contact] = isTaken[match.patch] = true;
        touched(_contacts[match.contact], patches[match.patch], time_s);
        kept.push_back(std::move(_contacts[match.contact]));
    }
    std::vector<Contact> left;
    for (std::size_t i = 0; i < _contacts.size(); ++i)
        if (!isOld[i]) left.push_back(std::move(_contacts[i]));
    for (std::size_t j = 0; j < patches.size(); ++j)
    {
        if (isTaken[j]) continue;
        const auto jumped = std::find_if(left.begin(),
                                         left.end(),
                                         [&](const Contact& contact)
                                         {
                                             const ContactPatch& before = contact.path.patch();
                                             return before.hand == patches[j].hand &&
                                                    before.object == patches[j].object &&
                                                    shareBone(before, patches[j]);
                                         });
        if (jumped != left.end())
        {
            _notes.push_back({ContactReason::HAND_JUMPED,
                              patches[j].hand,
                              patches[j].bones.front(),
                              patches[j].object});
            left.erase(jumped);
        }
        kept.push_back(begun(patches[j], time_s));
    }
    _contacts = std::move(left);
    return kept;
}

// For a contact without a patch.
bool ContactTracker::stays(Contact& contact, const HandFrame& hands, double time_s) const
{
    const ContactPatch& patch = contact.path.patch();
    for (const NearBone& near : _finder.nearby())
        if (near.hand == patch.hand && near.object == patch.object &&
            std::find(patch.bones.begin(), patch.bones.end(), near.bone) != patch.bones.end())
        {
            contact.wanted_m = 0.0;
            contact.lastSeen_s = time_s;
            return true;
        }
    for (const ContactNote& note : _notes)
        if (note.object == patch.object || (note.object == 0 && note.hand == patch.hand))
            return false;
    const std::vector<HandCapsule> known = handCapsules(hands);
    const bool isKnown =
        std::any_of(known.begin(),
                    known.end(),
                    [&](const HandCapsule& capsule) { return capsule.hand == patch.hand; });
    return !isKnown && time_s - contact.lastSeen_s <= _options.hold_s;
}

bool ContactTracker::update(const std::vector<HapticObject>& objects,
                            const HandFrame& hands,
                            double time_s)
{
    if (!std::isfinite(time_s) || (_time_s && time_s < *_time_s))
    {
        clear(ContactReason::TIME_NOT_FINITE);
        return false;
    }
    _time_s = time_s;
    _notes.clear();
    _finder.update(takeMaterials(objects), hands);
    _notes.insert(_notes.end(), _finder.notes().begin(), _finder.notes().end());
    std::vector<ContactPatch> patches;
    for (const ContactPatch& patch : _finder.patches())
        if (!patch.isExit) patches.push_back(patch);
    std::vector<Contact> kept = matched(patches, time_s);
    for (Contact& contact : _contacts)
        if (stays(contact, hands, time_s)) kept.push_back(std::move(contact));
    _contacts = std::move(kept);
    std::sort(_contacts.begin(),
              _contacts.end(),
              [](const Contact& a, const Contact& b) { return a.id < b.id; });
    return true;
}

bool ContactTracker::advance(double dt_s)
{
    if (!(dt_s >= 0.0) || !std::isfinite(dt_s))
    {
        clear(ContactReason::TIME_NOT_FINITE);
        return false;
    }
    _foci.clear();
    for (Contact& contact : _contacts)
    {
        const HapticMaterial& material = contact.material;
        const double radius_m = material.radius_m > 0.0
                                    ? material.radius_m + material.radiusGrowth * contact.depth_m
                                    : 0.0;
        contact.path.soften(radius_m, material.rateGrowth_Hz_m * contact.depth_m);
        contact.path.advance(dt_s);
        contact.paint.advance(dt_s);
        contact.vibration.advance(dt_s, contact.speed_m_s);
        contact.age_s += dt_s;
        contact.depth_m = followed(contact.depth_m, contact.wanted_m, dt_s, _options.follow_s);
        const std::vector<PathFocus>& path = contact.path.foci();
        double shares = 0.0;
        for (const PathFocus& focus : path)
            shares += focus.weight * focus.weight;
        const double pressure_Pa =
            contact.vibration.factor() * contact.paint.intensity() *
            contact.force.pressure_Pa(contact.depth_m, std::max(shares, 1.0), contact.age_s);
        for (std::size_t j = 0; j < path.size(); ++j)
        {
            const double own_Pa = path[j].weight * pressure_Pa;
            if (own_Pa > 0.0 && path[j].position.allFinite())
                _foci.push_back({path[j].position,
                                 own_Pa,
                                 contact.id,
                                 static_cast<int>(j),
                                 contact.path.patch().object,
                                 contact.path.patch().centre,
                                 contact.path.patch().normal});
        }
    }
    return true;
}

} // namespace midair::bridge
