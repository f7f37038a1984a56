#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Sends a scene's fields to a device: holds a single field, plays several in turn, silences the
/// array, and resends what the device lost.
///
/// Only one thread at a time may call its members, except silenceNow().
class ArrayOutput
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;

    /// Calls \a open. If that throws, the reason is a message and there is no device: fields are
    /// then decoded as a device with default levels would play them.
    ArrayOutput(const Open& open, base::MessageLog& messages);
    ~ArrayOutput(); ///< silences the device

    ArrayOutput(const ArrayOutput&) = delete;
    ArrayOutput& operator=(const ArrayOutput&) = delete;

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

    /// Returns true if the array plays what it was given last, or is silent as WANTED. After play()
    /// it is also true if there is no device.
    bool isPlaying() const { return _playing; }

    /// What attend() found and did.
    enum class Attention
    {
        NOTHING, ///< nothing was lost
        RESENT,  ///< the device had lost the field, and took it again
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

    std::string status() const;

private:
    void usePlayer(bool wanted);
    bool sendHeld(const base::StopToken& stop);
    std::string refusal() const;

    base::MessageLog& _messages;
    // Guards sending to the device and to the player, and creating and destroying the player.
    std::mutex _sending;
    std::unique_ptr<device::ArrayDevice> _device;
    // Sends to the device while fields change with time; null else. Destroyed before the device.
    std::unique_ptr<FieldPlayer> _player;
    std::string _openError;
    std::vector<device::DriveSignal> _signals; // of the last play(); empty: silent
    bool _playing = false;
    bool _holds = false;          // the device should hold _signals.front()
    device::DeviceReport _before; // taken just before that was sent
};

} // namespace midair::bridge
