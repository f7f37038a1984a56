#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/hands/Hand.h"

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Options for the change between whole objects and contacts; isValid() names the first setting
/// that is out of its range.
struct RenderSharesOptions
{
    Render render = Render::OBJECT; ///< meaning of INHERIT; not INHERIT itself
    /// 0 .. 0.1; rms error of the tracker, without that of the prediction. Measured: 5 mm (palm,
    /// Leap 2), 11 mm (fingertip, Quest 2).
    double trackerError_m = 5e-3;
    double fade_s = 0.1; ///< 0 .. 10; from contacts to the whole object and back
    double hold_s = 0.1; ///< 0 .. 10; lost hands count as tracked for this time
    double hysteresis =
        1.5; ///< 1 .. 10; ratio of the error that ends contacts to the one that begins them
    double spot_m = 4e-3; ///< 0 .. 0.1; half a focus: error allowed beyond the patch

    bool isValid(std::string* error = nullptr) const;
};

/// Decides how much of each object is played as a whole, and how much by contacts.
///
/// An AUTO object is played as a whole while no hand is tracked, or while the position error of a
/// touching hand exceeds the patch: sqrt(e_track^2 + e_predicted^2 + (v t)^2) > patch radius + half
/// a focus, with the unpredicted time t from the hand's position to the sound. It changes over
/// fade_s, with hysteresis, so that tremor doesn't switch.
class RenderShares
{
public:
    /// Throws InputError for options that are not valid.
    explicit RenderShares(const RenderSharesOptions& options = {});

    /// Returns the render mode of \a object, its own or the scene's; CONTACT for one with a
    /// sensation, which is never played as a whole.
    Render renderOf(const HapticObject& object) const;
    /// Returns true if any of \a objects is not always played as a whole.
    bool concerns(const std::vector<HapticObject>& objects) const;

    /// Decides from the newest frame. \a time_s: any steady clock; \a rest_s (>= 0): from the time
    /// of the hands' positions to the sound.
    void update(const std::vector<HapticObject>& objects,
                const std::vector<Contact>& contacts,
                const HandFrame& hands,
                double time_s,
                double rest_s);
    /// Advances fades by \a dt_s (finite, >= 0).
    void advance(double dt_s);
    /// Forgets all objects.
    void clear();

    /// 0 .. 1; factors on the pressure of an object (HapticObject::touchId()) as a whole, and of
    /// its contacts: sine and cosine, so that their power is constant. Objects that were not in the
    /// last update() are whole.
    double whole(std::uint64_t object) const;
    double contacts(std::uint64_t object) const;
    /// 0 .. 1; largest whole() of all objects.
    double mostWhole() const;
    /// Returns true during a fade.
    bool isFading() const;

private:
    /// State of an object.
    struct Share
    {
        double whole = 1.0;  ///< 0 .. 1, as it fades
        double wanted = 1.0; ///< 0 or 1
        bool isUncertain = false;
        std::uint64_t seen = 0; ///< update
    };

    bool isUncertain(const Contact& contact,
                     const std::vector<HandCapsule>& bones,
                     double rest_s,
                     bool wasUncertain) const;

    RenderSharesOptions _options;
    std::unordered_map<std::uint64_t, Share> _shares;
    double _handsSeen_s = 0.0;
    bool _wereHandsSeen = false;
    std::uint64_t _updates = 0;
};

} // namespace midair::bridge
