#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"
#include "engine-bridge/sensations/SensationFrame.h"
#include "engine-bridge/sensations/SensationView.h"
#include "engine-bridge/sensations/SteadyTurn.h"
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
    /// \a object has a sensation with a pattern. \a contact: see ContactFocus. \a plays: its
    /// number of plays that was heeded already, of an object that was gone; 0: none.
    PlayingSensation(const HapticObject& object, std::uint64_t contact, int plays);

    /// Takes a frame, whose \a object is the same one and still has a pattern.
    void update(const HapticObject& object, const SensationSurroundings& around);
    /// Returns true if \a object needs another one of this class.
    bool isOther(const HapticObject& object) const;

    /// True from its begin until it has faded out after its end; false while its hand is lost, or
    /// without a frame.
    bool isPlaying() const
    {
        return (_isWanted && _tracking.isKnown && !_tracking.isStale) || _gain > 0.0;
    }
    int priority() const { return _properties.priority; }
    const HapticProperties& properties() const { return _properties; }
    /// The number of plays that was heeded: begun, and over. 0: what it began goes on.
    int heeded() const { return _isWanted ? 0 : _plays; }
    /// Returns the point of its path at the last render(), m, array frame.
    Eigen::Vector3d middle() const;

    /// Appends the foci of the field at \a now_s, \a dt_s after the last one; \a pressure_Pa: of
    /// intensity 1 without fades. \a carried: see SensationPlayer; what is faster gets an outline.
    /// Time that passes without it doesn't pass in the pattern.
    void render(double now_s,
                double dt_s,
                double pressure_Pa,
                const haptics::SensationCarried& carried,
                std::vector<ContactFocus>& foci);
    /// Returns what follows the last render() for ever, of a focus of \a pressure_Pa at intensity
    /// 1; none: it changes or fades.
    std::optional<SteadyPart> steady(double pressure_Pa) const;

    /// What wasn't played as drawn since its begin.
    struct Limited
    {
        bool isBroken = false;      ///< a number wasn't finite
        bool isOutOfRange = false;  ///< an intensity outside 0 .. 1
        double outline_Hz = 0.0;    ///< turns a second of a brush that is played as an outline
        double modulation_Hz = 0.0; ///< of an amplitude modulation that is left out
    };
    const Limited& limited() const { return _limited; }
    const haptics::DrawnBrush& brush() const { return _sample.brush; } ///< at the last render()
    const haptics::SensationSample& sample() const { return _sample; } ///< at the last render()
    double intensity() const { return _gain * _sample.intensity; }     ///< 0 .. 1, with fades
    SensationView view() const;

    static constexpr double kFadeIn_s = 0.005; ///< against a click at the begin
    static constexpr double kFadeOut_s = 0.02;
    /// A hand that is lost for longer ends its sensations; those of ALWAYS go on when it is back.
    static constexpr double kLost_s = 0.1;
    /// Without a frame for this time, what needs hands is silent.
    static constexpr double kStale_s = 0.25;

private:
    const Contact* touching(const std::vector<Contact>& contacts) const;
    void trigger(bool isTouched);
    void begin();
    double patternTime_ms(double now_s);
    void noteLimits();
    ContactFocus focus() const;
    void
    place(const HapticObject& object, const SensationSurroundings& around, const Contact* touch);
    void setValues(const HapticObject& object,
                   const SensationSurroundings& around,
                   const Contact* touch);
    bool mayPlay() const;

    /// Its place, and since when.
    struct Tracking
    {
        bool isKnown = false;
        int hand = -1;         ///< Hand::id of the hand that it is on; -1: none yet
        double seen_s = 0.0;   ///< when its frame was known last
        double framed_s = 0.0; ///< time of the last frame
        bool wasTouched = false;
        bool isStale = false; ///< it needs hands, and no frame has come for kStale_s
    };

    const std::uint64_t _object;
    const std::uint64_t _contact;
    const int _seed;
    HapticProperties _properties;
    haptics::SensationPlayer _player;
    SensationFrame _frame;
    Tracking _tracking;
    int _plays;
    bool _isWanted = false;
    std::optional<double> _begun_s; ///< none: with the next render()
    double _rendered_s = 0.0;
    double _gain = 0.0; ///< 0 .. 1, as it fades
    Limited _limited;
    haptics::SensationSample _sample;
    SensationTrail _trail;
};

} // namespace midair::bridge
