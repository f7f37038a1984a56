#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactFinder.h"
#include "engine-bridge/contact/ContactForce.h"
#include "engine-bridge/contact/ContactPath.h"
#include "engine-bridge/hands/Hand.h"
#include "haptics/array/Medium.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Options for tracking contacts; isValid() names the first setting that is out of its range.
struct ContactTrackerOptions
{
    ContactFinderOptions finder; ///< contacts end at its leave_m
    ContactPathOptions path;
    /// 1e-3 .. 1; a contact that moves farther than this between two frames of hands starts again
    /// at the new place; nothing is played in between
    double restart_m = 0.03;
    double hold_s = 0.1;    ///< 0 .. 1; contacts of a lost hand stay for this time
    double follow_s = 0.01; ///< 0 .. 1; time constant of the played depth, against hum

    bool isValid(std::string* error = nullptr) const;
};

/// One focus of one contact at one moment.
struct ContactFocus
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< m, array frame
    double pressure_Pa = 0.0;                           ///< peak, > 0
    std::uint64_t contact = 0;                          ///< Contact::id
    int index = 0;                                      ///< within this contact
    std::uint64_t object = 0;                           ///< HapticObject::touchId()
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< of its patch
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of its patch, out of the object
    double share = 1.0; ///< 0 .. 1; of its pressure that it is solved for, to keep below caps
};

/// One place where a hand touches, from the begin to the end of the touch.
struct Contact
{
    std::uint64_t id = 0; ///< never reused
    ContactPath path;
    ContactForce force;
    ContactVibration vibration;
    HapticMaterial material; ///< of its object, as of the newest frame
    ContactPaint paint;
    double depth_m = 0.0;    ///< as played: follows wanted_m
    double wanted_m = 0.0;   ///< as of the newest frame; 0: near, but not touching
    double age_s = 0.0;      ///< since it touched last
    double speed_m_s = 0.0;  ///< of the finger along the object, smoothed
    double lastSeen_s = 0.0; ///< when the tracker last saw its hand
    /// of the finger in the object's frame, in the newest frame: for measuring its speed
    std::optional<Eigen::Vector3d> anchor = std::nullopt;
    double anchor_s = 0.0;
};

/// Tracks contacts over time: update() takes hands and objects at their rate, advance() makes foci
/// at the rate of fields.
///
/// A contact begins where skin and surface overlap and ends leave_m apart, so that tremor causes no
/// events. In between it is silent, but its angle and vibration continue. Invalid input makes no
/// contact; notes() give the reasons.
class ContactTracker
{
public:
    /// Throws InputError for options or a medium that are not valid.
    explicit ContactTracker(const ContactTrackerOptions& options = {},
                            const haptics::Medium& medium = {});

    /// Takes a frame of hands. Each object feels as its material defines; an object with an invalid
    /// material is silent, with a note. \a time_s must not decrease. Returns false and ends all
    /// contacts for times that aren't finite or decrease.
    bool update(const std::vector<HapticObject>& objects, const HandFrame& hands, double time_s);

    /// Advances by \a dt_s, the time between two fields. Returns false and ends all contacts if it
    /// isn't finite or is below 0.
    bool advance(double dt_s);

    void end() { clear(ContactReason::NONE); } ///< ends all contacts

    const std::vector<ContactFocus>& foci() const { return _foci; } ///< at the last advance()
    const std::vector<Contact>& contacts() const { return _contacts; }
    const std::vector<ContactNote>& notes() const { return _notes; } ///< of the last update()

private:
    std::vector<HapticObject> takeMaterials(const std::vector<HapticObject>& objects);
    void useMaterial(Contact& contact) const;
    Contact begun(const ContactPatch& patch, double time_s);
    void touched(Contact& contact, const ContactPatch& patch, double time_s);
    void measureSpeed(Contact& contact, const ContactPatch& patch, double time_s) const;
    std::vector<Contact> matched(std::vector<ContactPatch>& patches, double time_s);
    bool stays(Contact& contact, const HandFrame& hands, double time_s) const;
    void clear(ContactReason reason);

    ContactTrackerOptions _options;
    haptics::Medium _medium;
    ContactFinder _finder;
    std::unordered_map<std::uint64_t, HapticMaterial> _materials; ///< by HapticObject::touchId()
    std::vector<Contact> _contacts;
    std::vector<ContactFocus> _foci;
    std::vector<ContactNote> _notes;
    std::uint64_t _begun = 0;
    std::optional<double> _time_s; ///< of the last update
};

} // namespace midair::bridge
