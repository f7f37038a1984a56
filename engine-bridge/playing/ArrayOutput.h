#pragma once

#include "device/ArrayDevice.h"
#include "device/limits/Lead.h"
#include "engine-bridge/playing/DeviceOpener.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "engine-bridge/playing/PlayedDrives.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/Modulator.h"

#include <osgMidair/ArrayState>

#include <Eigen/Core>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Tells from a device's reports whether it plays what it is sent, over its last fields, so that
/// single losses of a noisy line are no fault.
class PlayedShare
{
public:
    /// Takes a newer report in, and returns true if the device plays too few of its fields.
    bool isFaulty(const device::DeviceReport& report);
    /// Begins anew: what was lost before \a report counts no more.
    void forget(const device::DeviceReport& report);

private:
    std::uint64_t _settled = 0;
    std::uint64_t _played = 0;
    double _share = 1.0; ///< of the last fields, those that were played
    bool _faulty = false;
};

/// What an array does, and what became of its fields: all by one report of its device.
struct ArrayReading
{
    ArrayState state = ArrayState::CLOSED;
    ArrayFields fields; ///< none while no device is open
    std::string status; ///< of the device, for people
};

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
    /// retry_s: pause before \a open is called again, and then again with growing pauses; 0: never.
    /// \a clock is that of what it plays, and outlives it.
    ArrayOutput(const Open& open,
                base::MessageLog& messages,
                double retry_s = 0.0,
                const base::Clock& clock = base::steadyClock());
    ~ArrayOutput(); ///< silences the device

    ArrayOutput(const ArrayOutput&) = delete;
    ArrayOutput& operator=(const ArrayOutput&) = delete;

    /// Returns false if the device could not be opened.
    bool isOpen() const { return _shared.device != nullptr; }

    /// Follows \a lead from now on in place of its own, with whatever device: its mute and its
    /// signs of life. The cap of the amplitude is the one that was set here. To be called before
    /// other threads call anything.
    void follow(const std::shared_ptr<device::Lead>& lead);

    /// To be called at intervals while there is no device. Returns true if it could be opened by
    /// now: it is silent, and isOpen() from now on.
    bool tryAgain();

    /// The ability of the device; the default DriveAbility if there is no device.
    device::DriveAbility ability() const;

    /// Plays \a drives (at least one, all of the array's length) in turn from now on, with \a
    /// modulation: these very bytes, lowered by the device's limits alone. If the device refuses a
    /// field, that is a message and the device is silenced; attend() sends the field again once a
    /// lost or muted device is ready. Throws base::Stopped without sending if \a stop was
    /// requested, since the thread that requested it may have silenced the device.
    void play(std::vector<device::DriveSignal> drives,
              const haptics::ModulatorOptions& modulation,
              const base::StopToken& stop);

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
    double amplitudeCap() const { return _lead->amplitudeCap(); } ///< any thread
    /// Lowers the cap to \a amplitude if it is higher. Any thread.
    void lowerAmplitudeCap(double amplitude);

    /// Silences the array at once and sends nothing until setMuted(false); the next attend() then
    /// plays what play() was given last. Any thread.
    void setMuted(bool muted);

    /// Returns true if the array plays what it was given last, or is silent as WANTED. After play()
    /// it is also true if there is no device.
    /// False once another thread's silenceNow() has cut it off, or the device itself (a hold, a
    /// quieter field that wasn't confirmed).
    bool isPlaying() const { return _sent.isPlaying && !_shared.isCutOff && !isCutShort(); }

    /// Returns true if what play() was given last is no silence. Any thread.
    bool sounds() const { return _shared.sounds && amplitudeCap() > 0.0; }

    /// Returns true if the device's hold has silenced it and no sign of life came since: what is
    /// sent here is none. Comes one after that, attend() plays the field again. Any thread.
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

    /// What play() was given last; none after silence().
    const std::vector<device::DriveSignal>& drives() const { return _given.drives; }
    /// What the device would play of \a signal, as activations (m).
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    /// The fields of the last play() as the device should play them (quantised); none after
    /// silence().
    std::vector<Eigen::VectorXcf> planned() const;
    /// The fields as the device plays them: for a single held field ArrayDevice::played() once it
    /// is no longer pending, else planned().
    std::vector<Eigen::VectorXcf> played() const;

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
    /// Ends messages about what the device doesn't do any more.
    void endWhatIsOver();

private:
    /// A state, and how many fields had been played then.
    struct Judgement
    {
        ArrayState state = ArrayState::OPENING;
        std::uint64_t played = 0;
    };

    /// What play() was given last.
    struct Given
    {
        std::vector<device::DriveSignal> drives; ///< empty: silence
        haptics::ModulatorOptions modulation;
    };
    /// What has become of that at the device.
    struct Sent
    {
        bool isPlaying = false;
        bool isHeld = false;     ///< the device should hold the first of the drives
        bool byPlayer = false;   ///< or else a player sends them
        std::uint64_t mutes = 0; ///< Lead::mutes() then; kNever: it was muted already
        double time_s = 0.0;
        device::DeviceReport before; ///< taken just before
    };
    static constexpr std::uint64_t kNever = ~std::uint64_t{0};
    /// Whether the device plays what it takes, over its last fields.
    struct Faithfulness
    {
        PlayedShare share;
        bool isMissed = false; ///< a held field was sent and not played; until one is
        std::uint64_t playedAtMiss = 0;
    };
    /// What other threads see.
    struct Shared
    {
        std::atomic<device::ArrayDevice*> device{nullptr}; ///< once it is open it stays
        std::atomic<bool> isOpening{false};                ///< for the first time
        std::atomic<bool> isUncapped{false};               ///< the device can't keep the lead's cap
        std::atomic<bool> isCutOff{false}; ///< silenceNow() came after the last field
        std::atomic<bool> sounds{false};   ///< something of what was given is no silence
        mutable base::Mutex mutex;
        std::string openError MIDAIR_GUARDED_BY(mutex);
        Judgement judged MIDAIR_GUARDED_BY(mutex);
    };

    void usePlayer(bool wanted);
    bool sendHeld(const base::StopToken& stop);
    bool startPlayer(const base::StopToken& stop);
    bool isCutShort() const;
    bool isBlocked() const { return _lead->isMuted() || _shared.isUncapped; }
    bool isMutedAway() const { return _lead->mutes() != _sent.mutes; }
    void noteSending();
    void keepCap(double amplitude) MIDAIR_REQUIRES(_sending);
    bool takeDevice();
    base::Message refusal(const device::DeviceReport& report) const;
    void tellRefusal(const device::DeviceReport& report);
    device::ArrayDevice* device() const { return _shared.device; }

    base::MessageLog& _messages;
    const base::Clock& _clock;
    std::shared_ptr<device::Lead> _lead = std::make_shared<device::Lead>(_clock);

    /// Guards sending to the device and to the player, and making and destroying the two.
    base::Mutex _sending;
    std::unique_ptr<device::ArrayDevice> _device MIDAIR_GUARDED_BY(_sending);
    /// Sends to the device while fields change with time; null else. Destroyed before the device.
    std::unique_ptr<FieldPlayer> _player MIDAIR_GUARDED_BY(_sending);
    std::unique_ptr<DeviceOpener> _opener; ///< while there is no device; null: never

    Given _given;
    Sent _sent;
    Faithfulness _faithfulness;
    std::optional<std::uint64_t> _toldLoss; ///< the device's reconnects at a loss; none: no loss
    Shared _shared;
};

/// Returns \a fields as a device takes them, with all \a dead transducers off. Throws
/// std::runtime_error for fields that don't have \a transducers activations, and for activations
/// that are not finite.
std::vector<device::DriveSignal> drivesOf(const std::vector<Eigen::VectorXcf>& fields,
                                          int transducers,
                                          const std::vector<int>& dead = {});

} // namespace midair::bridge
