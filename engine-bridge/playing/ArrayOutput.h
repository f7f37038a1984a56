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

/// The device that a scene's fields go to: it holds a single field, has several played in turn,
/// falls silent, and knows whether the array plays what it was given last.
///
/// One thread at a time, but for silenceNow().
class ArrayOutput
{
public:
    using Open = std::function<std::unique_ptr<device::ArrayDevice>()>;

    /// A device that can't be opened is a message: fields are then shown as they would be played.
    ArrayOutput(const Open& open, base::MessageLog& messages);
    ~ArrayOutput(); ///< silences the device

    ArrayOutput(const ArrayOutput&) = delete;
    ArrayOutput& operator=(const ArrayOutput&) = delete;

    /// What the device can play; that of the simulator where there is none.
    device::DriveAbility ability() const;

    /// Plays \a sequence (K >= 1 fields of \a transducers activations) from now on. A field that
    /// the device refuses is a message, leaves it silent, and is tried again by attend(). Throws
    /// std::runtime_error, and plays on what it played, for activations that are not finite or of
    /// another number, base::Stopped where \a stop asks for it: whoever asked may have silenced the
    /// device already.
    void play(const haptics::FieldSequence& sequence, int transducers, const base::StopToken& stop);

    enum class Silence
    {
        WANTED, ///< there is nothing to play
        FAILED  ///< what should be played could not be made: it is to be tried again
    };
    void silence(Silence why);
    /// Any thread: the array is silent. What is being handed over may be played after it, unless a
    /// stop was asked for before.
    void silenceNow();

    /// Whether the array plays what it was given last, or is silent as WANTED. True where there is
    /// no device.
    bool isPlaying() const { return _playing; }

    enum class Attention
    {
        NOTHING, ///< all is as it was
        RESENT,  ///< the field that the device had lost plays again
        REFUSED  ///< it was lost, and is not taken
    };
    /// To be called now and then: sends the field that is held again once a device has lost it
    /// (unplugged and back, muted by its watchdog, a packet gone). Throws base::Stopped as play()
    /// does.
    Attention attend(const base::StopToken& stop);

    /// What the device plays of \a signal, as activations (m).
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    /// The fields of the last play() as the device is to play them; none once silence() came.
    std::vector<Eigen::VectorXcf> planned() const;
    /// The same as it does: of a held field what the device tells, where it has told already.
    std::vector<Eigen::VectorXcf> played() const;

    std::string status() const;

private:
    void usePlayer(bool wanted);
    bool sendHeld(const base::StopToken& stop);
    std::string refusal() const;

    base::MessageLog& _messages;
    std::mutex _sending; // of what is sent to the device and the player, and of the player's coming
                         // and going
    std::unique_ptr<device::ArrayDevice> _device;
    std::unique_ptr<FieldPlayer>
        _player; // while fields change with time: what sends to the device; gone first
    std::string _openError;
    std::vector<device::DriveSignal> _signals; // of the last play(); none: silent
    bool _playing = false;
    bool _holds = false;          // the device is to hold _signals.front()
    device::DeviceReport _before; // when that was sent
};

} // namespace midair::bridge
