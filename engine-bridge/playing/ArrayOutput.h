#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/playing/ArrayReading.h"
#include "engine-bridge/playing/DeviceOpener.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "engine-bridge/playing/PlayedDrives.h"
#include "engine-bridge/playing/PlayedShare.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSequence.h"

#include <osgMidair/ArrayState>

#include <Eigen/Core>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Sends a scene's fields to a device: holds a single field, plays several in turn, silences the
/// array, and resends what the device lost.
///
/// Only one thread at a time may call its members, except those that are for any thread.
class ArrayOutput
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;

    /// Has \a open called on a thread of its own, and waits for it at most
    /// DeviceOpener::kPatience_s. If it throws, or takes longer, that is a message and there is no
    /// device yet: fields are then decoded as a device with default levels would play them. \a
    /// dead: transducers that are never driven, whatever a field says. \a retry_s: pause before \a
    /// open is called again, and then again with growing pauses; 0: never.
    ArrayOutput(const Open& open,
                base::MessageLog& messages,
                std::vector<int> dead = {},
                double retry_s = 0.0);
    ~ArrayOutput(); ///< silences the device

    ArrayOutput(const ArrayOutput&) = delete;
    ArrayOutput& operator=(const ArrayOutput&) = delete;

    /// Returns false if the device could not be opened.
    bool isOpen() const { return _device != nullptr; }

    /// To be called at intervals while there is no device. Returns true if it could be opened by
    /// now: it is silent, and isOpen() from now on.
    bool tryAgain();

    /// The ability of the device; the default DriveAbility if there is no device.
    device::DriveAbility ability() const;

    /// Plays \a sequence (K >= 1 fields of \a transducers activations) from now on. If the device
    /// refuses a field, that is a message and the device is silenced; attend() sends the field
    /// again once a lost or muted device is ready. Throws std::runtime_error, and goes on playing
    /// the last field, for activations that are not finite or of another number; throws
    /// base::Stopped without sending if \a stop was requested, since the thread that requested it
    /// may have silenced the device.
    void play(const haptics::FieldSequence& sequence, int transducers, const base::StopToken& stop);

    /// Why the array is to be silent.
    enum class Silence
    {
        WANTED, ///< there is nothing to play: isPlaying() returns true
        FAILED  ///< the field could not be computed: isPlaying() returns false, so that it is tried
                ///< again
    };
    void silence(Silence why);
    /// Silences the array. May be called from any thread; a play() under way may still send its
    /// field afterwards, unless a stop was requested before.
    void silenceNow();

    /// Caps the amplitude of all that is played from now on, see ArrayDevice::setAmplitudeCap(). If
    /// the device can't, it is silenced, and stays so until it has a cap that it can keep. Any
    /// thread.
    void setAmplitudeCap(double amplitude);
    double amplitudeCap() const { return _cap; } ///< any thread
    /// Lowers the cap to \a amplitude if it is higher. Any thread.
    void lowerAmplitudeCap(double amplitude);

    /// Silences the array at once and sends nothing until setMuted(false); the next attend() then
    /// plays what play() was given last. Any thread.
    void setMuted(bool muted);

    /// Returns true if the array plays what it was given last, or is silent as WANTED. After play()
    /// it is also true if there is no device.
    /// False once another thread's silenceNow() has cut it off, or the device itself (a hold, a
    /// quieter field that wasn't confirmed).
    bool isPlaying() const { return _playing && !_isCutOff && !isCutShort(); }

    /// Returns true if what play() was given last is no silence. Any thread.
    bool sounds() const { return _sounds && _cap > 0.0; }

    /// The sign of life of whoever leads (a frame of a scene): a device with a hold falls silent
    /// without. What is sent here is none. Comes it again after that, attend() plays the field
    /// again. Making this object counts as one. Never waits. Any thread.
    void keepAlive();
    void noteSign(double at_s); ///< the same for an earlier one, see ArrayDevice

    /// Returns true if the device's hold has silenced it and no sign of life came since. Any
    /// thread.
    bool isHoldOver() const;

    /// What attend() found and did.
    enum class Attention
    {
        NOTHING, ///< nothing was lost
        RESENT,  ///< the device had lost the field, or was muted, and took it again
        REFUSED  ///< the device lost the field and doesn't take it
    };
    /// To be called at intervals: resends a held field that the device has lost (unplugged and
    /// back, silenced by its watchdog, a lost packet). Throws base::Stopped as play() does.
    Attention attend(const base::StopToken& stop);

    /// What the device would play of \a signal, as activations (m).
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    /// The fields of the last play() as the device should play them (quantised); none after
    /// silence().
    std::vector<Eigen::VectorXcf> planned() const;
    /// The fields as the device plays them: for a single held field ArrayDevice::played() once it
    /// is no longer pending, else planned().
    std::vector<Eigen::VectorXcf> played() const;

    std::string status() const; ///< any thread
    /// What the device has done with its fields; nothing without a device. Any thread.
    ArrayFields fields() const { return reading().fields; }
    /// What the array does now. To be asked at each field, since it is judged by the last ones.
    ArrayState state();
    /// Keeps \a state, as it was judged, for reading().
    void judge(ArrayState state);
    /// The judged state as far as the device still agrees, and its fields, by one report of it: it
    /// is lost at once, and plays once it has played more than when it was judged to be silent. Any
    /// thread.
    ArrayReading reading() const;
    /// What a simulated device has played in the last \a duration_s (0 .. 0.1). Any thread.
    PlayedDrives playedOfLate(double duration_s) const;
    /// Says what is wrong if the array has just come into \a state.
    void tell(ArrayState state);
    /// Says, once until it ends, that the device couldn't be silenced, and what its driver has
    /// against it though it plays. To be called at intervals. Returns true if it has said anything.
    bool tellOfDriver();

private:
    /// A state, and how many fields had been played then.
    struct Judgement
    {
        ArrayState state = ArrayState::OPENING;
        std::uint64_t played = 0;
    };

    void usePlayer(bool wanted);
    bool sendHeld(const base::StopToken& stop);
    bool startPlayer(const base::StopToken& stop);
    bool isCutShort() const;
    bool isBlocked() const { return _muted || _uncapped; }
    void keepCap(double amplitude);
    bool takeDevice();
    base::Message refusal(const device::DeviceReport& report) const;
    void tellRefusal(const device::DeviceReport& report);
    std::string openError() const;

    base::MessageLog& _messages;
    const std::vector<int> _dead;
    // Guards sending to the device and to the player, and creating and destroying the player.
    std::mutex _sending;
    std::unique_ptr<device::ArrayDevice> _device;
    // Sends to the device while fields change with time; null else. Destroyed before the device.
    std::unique_ptr<FieldPlayer> _player;
    std::atomic<device::ArrayDevice*> _opened{nullptr}; // _device, which stays, for any thread
    std::unique_ptr<DeviceOpener> _opener;              // while there is no device; null: never
    std::atomic<bool> _isOpening{false};                // for the first time
    mutable std::mutex _telling;                        // guards the next two
    std::string _openError;
    Judgement _judged;
    std::atomic<bool> _muted{false};    // written under _sending, as the next two
    std::atomic<bool> _uncapped{false}; // the device can't keep _cap
    std::atomic<double> _cap{1.0};      // of setAmplitudeCap()
    bool _capTold = false;
    // The device's reconnects when a loss was told that hasn't ended; none: there is no such loss.
    std::optional<std::uint64_t> _toldLoss;
    bool _unsilencedTold = false;              // until it is silenced
    bool _complaintTold = false;               // until there is none
    bool _quietedTold = false;                 // until it plays again
    std::vector<device::DriveSignal> _signals; // of the last play(); empty: silent
    haptics::ModulatorOptions _modulation;     // of the last play()
    bool _playing = false;
    bool _holds = false;                   // the device should hold _signals.front()
    std::atomic<bool> _isMutedAway{false}; // a mute came after the last field; under _sending
    PlayedShare _share;
    std::atomic<bool> _isCutOff{false}; // silenceNow() came after the last field; under _sending
    std::atomic<bool> _sounds{false};   // something of _signals is no silence
    std::atomic<double> _sent_s{0.0};   // time of _before
    std::atomic<double> _sign_s;        // of life, the last one
    bool _missed = false;               // a held field was sent and not played; until one is
    std::uint64_t _playedAtMiss = 0;
    device::DeviceReport _before; // taken just before that was sent
};

} // namespace midair::bridge
