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

/// Decides from a device's reports, over its last fields, whether it plays what it is sent. Single
/// losses of a noisy line are no fault.
class PlayedShare
{
public:
    /// Adds a newer report; returns true if the device plays too few of its fields.
    bool isFaulty(const device::DeviceReport& report);
    /// Starts again: losses before \a report no longer count.
    void forget(const device::DeviceReport& report);

private:
    std::uint64_t _settled = 0;
    std::uint64_t _played = 0;
    double _share = 1.0; ///< share of the last fields that were played
    bool _faulty = false;
};

/// State of an array and the fate of its fields, both from one report of its device.
struct ArrayReading
{
    ArrayState state = ArrayState::CLOSED;
    ArrayFields fields; ///< none while no device is open
    std::string status; ///< status of the device, for people
};

/// Sends a scene's fields to a device: holds a single field, plays several in turn, silences the
/// array, and resends lost fields.
///
/// Only one thread at a time may call its members, except those that are for any thread.
class ArrayOutput
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;

    /// Calls \a open on a separate thread and waits for it at most DeviceOpener::kPatience_s. If it
    /// throws or takes longer, this is reported and there is no device yet: fields are then decoded
    /// as by a device with default levels. \a retry_s: pause before \a open is called again; later
    /// pauses grow; 0: never. \a clock times the played fields, and must outlive this object.
    ArrayOutput(const Open& open,
                base::MessageLog& messages,
                double retry_s = 0.0,
                const base::Clock& clock = base::steadyClock());
    ~ArrayOutput(); ///< silences the device

    ArrayOutput(const ArrayOutput&) = delete;
    ArrayOutput& operator=(const ArrayOutput&) = delete;

    /// Returns false if the device could not be opened.
    bool isOpen() const { return _shared.device != nullptr; }

    /// Uses \a lead from now on instead of its own, with any device: its mute and its signs of
    /// life. The amplitude cap stays the one set here. Call it before other threads call anything.
    void follow(const std::shared_ptr<device::Lead>& lead);

    /// To be called at intervals while there is no device. Returns true if the device is open now;
    /// it is silent.
    bool tryAgain();

    /// The ability of the device; the default DriveAbility if there is no device.
    device::DriveAbility ability() const;

    /// Plays \a drives (at least one, all of the array's length) in turn with \a modulation:
    /// exactly these bytes, lowered only by the device's limits. If the device refuses a field,
    /// this is reported and the device is silenced; attend() sends the field again once a lost or
    /// muted device is ready. Throws base::Stopped without sending if \a stop was requested,
    /// because the requesting thread may have silenced the device.
    void play(std::vector<device::DriveSignal> drives,
              const haptics::ModulatorOptions& modulation,
              const base::StopToken& stop);

    /// Reason for silence.
    enum class Silence
    {
        WANTED, ///< there is nothing to play: isPlaying() returns true
        FAILED  ///< the field could not be computed: isPlaying() returns false, so that it is tried
                ///< again
    };
    void silence(Silence why);
    /// Silences the array. Any thread. A concurrent play() may still send its field afterwards,
    /// unless a stop was requested before.
    void silenceNow();

    /// Caps the amplitude of all later output, see ArrayDevice::setAmplitudeCap(). A device that
    /// can't apply it is silenced until it gets a cap that it can apply. Any thread.
    void setAmplitudeCap(double amplitude);
    double amplitudeCap() const { return _lead->amplitudeCap(); } ///< any thread
    /// Lowers the cap to \a amplitude if it is higher. Any thread.
    void lowerAmplitudeCap(double amplitude);

    /// Silences the array at once and sends nothing until setMuted(false); the next attend() then
    /// plays the last field of play(). Any thread.
    void setMuted(bool muted);

    /// Returns true if the array plays the last field given, or is silent as WANTED; after play()
    /// also if there is no device. False once another thread's silenceNow() or the device itself (a
    /// hold, an unconfirmed quieter field) has cut it off.
    /// quieter field that wasn't confirmed).
    bool isPlaying() const { return _sent.isPlaying && !_shared.isCutOff && !isCutShort(); }

    /// Returns true if the last field of play() is not silence. Any thread.
    bool sounds() const { return _shared.sounds && amplitudeCap() > 0.0; }

    /// Returns true if the device's hold has silenced it and no sign of life has come since (fields
    /// sent here are none). After a sign of life attend() plays the field again. Any thread.
    bool isHoldOver() const;

    /// Result of attend().
    enum class Attention
    {
        NOTHING, ///< nothing was lost
        RESENT,  ///< the device had lost the field, or was muted, and accepted it again
        REFUSED  ///< the device lost the field and refuses it
    };
    /// To be called at intervals: resends a held field that the device has lost (unplugged and
    /// back, silenced by its watchdog, a lost packet). Throws base::Stopped like play().
    Attention attend(const base::StopToken& stop);

    /// Drives of the last play(); empty after silence().
    const std::vector<device::DriveSignal>& drives() const { return _given.drives; }
    /// Returns the activations (m) that the device would play for \a signal.
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    /// The fields of the last play() as the device should play them (quantised); none after
    /// silence().
    std::vector<Eigen::VectorXcf> planned() const;
    /// The fields as the device plays them: for a single held field ArrayDevice::played() once it
    /// is no longer pending, else planned().
    std::vector<Eigen::VectorXcf> played() const;

    /// Returns the present state. Call it at each field, because it is judged by the last ones.
    ArrayState state();
    /// Stores the judged \a state for reading().
    void judge(ArrayState state);
    /// The judged state, updated by one report of the device, and its fields: lost takes effect at
    /// once, and playing once it has played more than when it was judged silent. Any thread.
    ArrayReading reading() const;
    /// Drives that a simulated device has played in the last \a duration_s (0 .. 0.1). Any thread.
    PlayedDrives playedOfLate(double duration_s) const;
    /// Reports the problem if the array has just changed to \a state.
    void tell(ArrayState state);
    /// Reports, once until it ends, that the device couldn't be silenced, or that its driver
    /// complains although it plays. To be called at intervals. Returns true if anything was
    /// reported.
    bool tellOfDriver();
    /// Ends messages about conditions of the device that are over.
    void endWhatIsOver();

private:
    /// A state, and the number of played fields at that time.
    struct Judgement
    {
        ArrayState state = ArrayState::OPENING;
        std::uint64_t played = 0;
    };

    /// Arguments of the last play().
    struct Given
    {
        std::vector<device::DriveSignal> drives; ///< empty: silence
        haptics::ModulatorOptions modulation;
    };
    /// State of that at the device.
    struct Sent
    {
        bool isPlaying = false;
        bool isHeld = false;     ///< the device should hold the first of the drives
        bool byPlayer = false;   ///< otherwise a player sends them
        std::uint64_t mutes = 0; ///< Lead::mutes() at that time; kNever: it was muted already
        double time_s = 0.0;
        device::DeviceReport before; ///< taken just before
    };
    static constexpr std::uint64_t kNever = ~std::uint64_t{0};
    /// Share of accepted fields that the device has played lately.
    struct Faithfulness
    {
        PlayedShare share;
        bool isMissed = false; ///< a held field was sent but not played; reset when one is
        std::uint64_t playedAtMiss = 0;
    };
    /// State shared with other threads.
    struct Shared
    {
        std::atomic<device::ArrayDevice*> device{nullptr}; ///< once open it stays
        std::atomic<bool> isOpening{false};                ///< the first try is running
        std::atomic<bool> isUncapped{false}; ///< the device can't apply the lead's cap
        std::atomic<bool> isCutOff{false};   ///< silenceNow() came after the last field
        std::atomic<bool> sounds{false};     ///< the last field is not silence
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

    /// Guards sending to the device and the player, and making and destroying both.
    base::Mutex _sending;
    std::unique_ptr<device::ArrayDevice> _device MIDAIR_GUARDED_BY(_sending);
    /// Sends to the device while fields change with time, else null. Destroyed before the device.
    std::unique_ptr<FieldPlayer> _player MIDAIR_GUARDED_BY(_sending);
    std::unique_ptr<DeviceOpener> _opener; ///< while there is no device; null: not needed

    Given _given;
    Sent _sent;
    Faithfulness _faithfulness;
    std::optional<std::uint64_t> _toldLoss; ///< reconnects at a reported loss; none: no loss
    Shared _shared;
};

/// Encodes \a fields for a device, with all \a dead transducers off. Throws std::runtime_error
/// unless all fields have \a transducers finite activations.
std::vector<device::DriveSignal> drivesOf(const std::vector<Eigen::VectorXcf>& fields,
                                          int transducers,
                                          const std::vector<int>& dead = {});

} // namespace midair::bridge
