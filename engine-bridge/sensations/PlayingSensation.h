#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"
#include "engine-bridge/sensations/SensationFrame.h"
#include "engine-bridge/sensations/SensationView.h"
#include "haptics/sensation/SensationPlayer.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace midair::bridge
{

/// What a frame of the scene says about a sensation's surroundings.
struct SensationSurroundings
{
    const HandFrame& hands;
    const std::vector<Contact>& contacts;
    std::shared_ptr<const MeshDistance> surface; ///< of the object; null: none, or not yet
    double time_s = 0.0;                         ///< steady clock
};

/// One object's sensation while the object exists: begins and ends by its trigger, follows its
/// frame, and is sampled field by field.
class PlayingSensation
{
public:
    /// \a object has a sensation with a pattern. \a contact: see ContactFocus.
    PlayingSensation(const HapticObject& object, std::uint64_t contact);

    /// Takes a frame, whose \a object is the same one and still has a pattern.
    void update(const HapticObject& object, const SensationSurroundings& around);
    /// Returns true if \a object needs another one of this class.
    bool isOther(const HapticObject& object) const
    {
        return object.properties.sensation.seed != _seed;
    }

    /// True from its begin until it has faded out after its end; false while its hand is lost.
    bool isPlaying() const { return (_isWanted && _tracking.isKnown) || _gain > 0.0; }
    int priority() const { return _properties.priority; }
    std::uint64_t object() const { return _object; }
    const HapticProperties& properties() const { return _properties; }
    /// Returns the origin of its frame, m, array frame.
    Eigen::Vector3d origin() const { return _frame.toArray.translation(); }

    /// Appends the foci of the field at \a now_s, \a dt_s after the last one; \a most_Pa: of
    /// intensity 1 without fades. \a rate_Hz: of fields; slow ones get outlines (SensationPlayer).
    void render(
        double now_s, double dt_s, double most_Pa, double rate_Hz, std::vector<ContactFocus>& foci);
    /// Returns the sample of the last render().
    const haptics::SensationSample& sample() const { return _sample; }
    double intensity() const { return _gain * _sample.intensity; } ///< 0 .. 1, with fades
    SensationView view() const;

    static constexpr double kFadeIn_s = 0.005; ///< against a click at the begin
    static constexpr double kFadeOut_s = 0.02;
    static constexpr double kLost_s = 0.1; ///< a hand that is lost for longer ends its sensations
    /// Without a frame for this time, what needs hands is silent.
    static constexpr double kStale_s = 0.25;

private:
    const Contact* touching(const std::vector<Contact>& contacts) const;
    void trigger(bool isTouched, double now_s);
    void begin(double now_s);
    void
    place(const HapticObject& object, const SensationSurroundings& around, const Contact* touch);
    void setValues(const HapticObject& object,
                   const SensationSurroundings& around,
                   const Contact* touch);
    bool mayPlay(double now_s) const;

    /// Its place, and since when.
    struct Tracking
    {
        bool isKnown = false;
        int hand = -1;         ///< Hand::id of the hand that it is on; -1: none yet
        double seen_s = 0.0;   ///< when its frame was known last
        double framed_s = 0.0; ///< time of the last frame
        bool wasTouched = false;
    };

    const std::uint64_t _object;
    const std::uint64_t _contact;
    const int _seed;
    HapticProperties _properties;
    haptics::SensationPlayer _player;
    SensationFrame _frame;
    Tracking _tracking;
    int _plays = 0;
    bool _isWanted = false;
    double _begun_s = 0.0;
    double _gain = 0.0; ///< 0 .. 1, as it fades
    haptics::SensationSample _sample;
    SensationTrail _trail;
};

} // namespace midair::bridge
