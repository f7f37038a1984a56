#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace midair::device
{

class JointCommit;
class Lead;

/// Thrown when a device can't be opened or its URI can't be parsed; what() names the URI and what
/// would be right.
class DeviceError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// The number of transducers and their boards, as the array file gives them.
struct DeviceLayout
{
    int transducers = 0;
    std::vector<int> board; ///< the board of each transducer, ascending from 0; empty: one board
    /// Numbers of transducers that are never driven, for hardware that can mask them; whoever sends
    /// fields drives them with 0 anyway.
    std::vector<int> dead = {};
};

/// Limits on everything that a device plays. Each can also be set by the URI parameter named with
/// it; the stricter of the two holds, except for `mean-drive-time`, where the URI's replaces this
/// one.
struct SafetyLimits
{
    /// 0 .. 1 of full drive; a field whose largest amplitude exceeds it is scaled down as a whole.
    /// `max-amplitude`
    double maxAmplitude = 1;
    /// 0 .. 10; time over which the amplitude rises from silence to full, and falls at closing.
    /// `ramp`
    double ramp_s = 0;
    /// 0 .. 1; limit on the amplitude squared, averaged over transducers and time. `mean-drive`
    double meanDrive = 1;
    double meanDriveTime_s = 10; ///< > 0; time constant of that average. `mean-drive-time`
    /// >= 0; the device falls silent, and takes no field, once whoever leads has given no sign of
    /// life for this time (ArrayDevice::keepAlive()); 0: it holds the last field. In a list of
    /// devices the shortest counts for all. `hold`
    double hold_s = 0;
    /// >= 0; cap on the peak pressure at control points, Pa; 0: none. A device doesn't know the
    /// control points: it only reports the cap in ability(), and bridge::PressureCap enforces it.
    /// `max-pressure`
    double maxPressure_Pa = 0;
};

/// What a device can play: levels, caps and rates, for the solver.
struct DriveAbility
{
    int phaseLevels = 256;         ///< phase levels per turn
    std::vector<float> amplitudes; ///< ascending in [0, 1]; empty: amplitudeLevels()
    /// SafetyLimits::maxPressure_Pa, to be enforced by the caller, who knows the control points; 0:
    /// none.
    double maxPressure_Pa = 0;
    double maxAmplitude = 1; ///< SafetyLimits::maxAmplitude; of several devices the least strict
    bool fades = false;      ///< true: the device may lower amplitudes (ramp, thermal budget)
    /// For each transducer (m) the number, from 0, of the part of the array that it belongs to:
    /// parts fade or fall silent by themselves; empty: one part.
    std::vector<int> part = {};
    double fieldsPerSecond = 0; ///< the most fields/s that the connection carries; 0: no limit
    /// The largest number of signals in a DriveSequence, which the device stores and times by
    /// itself; 0: it takes no sequences, and bridge::FieldPlayer sends each field at its time.
    int sequenceFields = 0;
    /// >= 0, s: what is simulated rings with this time constant, whatever the array's file says;
    /// below 0: with the file's.
    double ringing_s = -1;
    /// A sequence's rate has to be this one over a whole number, Hz; 0: any. Others are sent field
    /// by field.
    double sequenceClock_Hz = 0;
};

/// Whether a device plays what it is sent; the worst of several devices counts.
enum class DeviceState
{
    READY, ///< plays what it is sent
    MUTED, ///< by setMuted()
    /// a call of its driver doesn't return, or the driver couldn't silence it, so nobody knows what
    /// it plays; ends by itself if the call returns, or a silence is written
    HANGING,
    LOST ///< unplugged or failing; becomes READY by itself if the device can come back
};

/// State and counters of a device. Every field sent is counted in exactly one of five: sent =
/// played + dropped + lost + refused + pending.
struct DeviceReport
{
    DeviceState state = DeviceState::READY;
    std::uint64_t sent = 0; ///< calls of send() and sendSequence(); a sequence counts as one field
    /// confirmed by the device; for a device that doesn't answer: handed over completely
    std::uint64_t played = 0;
    /// replaced by a newer field, or ended by silence(), before it was played
    std::uint64_t dropped = 0;
    std::uint64_t lost = 0;       ///< being sent when the device failed or refused it
    std::uint64_t refused = 0;    ///< send() or sendSequence() returned false
    std::uint64_t pending = 0;    ///< waiting, being sent or not confirmed yet
    std::uint64_t faults = 0;     ///< stalls, timeouts, short transfers, unplugs, invalid answers
    std::uint64_t reconnects = 0; ///< times that the device came back
    /// Times that silence(), a mute, SafetyLimits::hold_s or a quieter field that wasn't confirmed
    /// silenced the device, whoever called it; afterwards a sequence has to be sent again.
    std::uint64_t silences = 0;
    /// When the last field was handed to the hardware, with its commit, std::chrono::steady_clock;
    /// 0: never.
    double lastHandedOver_s = 0;
    double latency_s = 0; ///< from send() of that field until then
    /// For several devices: time from the first to the last one that got the last field; if some of
    /// them commit together, among those.
    double skew_s = 0;
    double worstSkew_s = 0;   ///< the largest skew_s so far
    std::string firmware;     ///< "1.2.3"; empty: unknown
    double temperature_C = 0; ///< 0: unknown
    std::string message;      ///< the last fault; empty if there was none
    /// Why the silence that is due isn't written, so that it may play on, as a sentence; empty: it
    /// is, or none is due. It is tried again until it is.
    std::string unsilenced;
    /// Why GuardedDevice has silenced it, as a sentence: a quieter field that wasn't confirmed;
    /// empty: it hasn't, or another field was confirmed since.
    std::string quieted;
    /// What is wrong with a driver that plays nevertheless, as a sentence; empty: nothing.
    std::string complaint;
    std::string shortfall; ///< "3 of 1000 fields were played"; empty if half or more were
};

/// What an array has played from a time on, until the next of these.
struct PlayedField
{
    double since_s = 0;                 ///< std::chrono::steady_clock
    std::vector<std::complex<float>> q; ///< activations (m), as played() has them
};

/// A phased array, which plays one field, or a sequence of fields, until the next one replaces it.
/// send() never blocks on the hardware.
///
/// All members may be called from any thread.
class ArrayDevice
{
public:
    /// The destructor silences the array.
    virtual ~ArrayDevice() = default;

    /// Replaces the field that is played. Returns false, and changes nothing, if the field is
    /// refused (wrong length, muted, device lost); status() says why. For whoever leads, an
    /// application: each call is a sign of life.
    virtual bool send(const DriveSignal& signal) = 0;
    /// The same for whoever plays by itself, such as a player's thread: no sign of life. Also
    /// refuses while isHoldOver().
    virtual bool sendUnled(const DriveSignal& signal) { return send(signal); }

    /// A sign of life: whoever leads (a frame, a tracker, an application's loop) still wants what
    /// is played. A device with SafetyLimits::hold_s is silent without. What it has silenced stays
    /// silent until the next field. Opening counts as one. Never waits.
    virtual void keepAlive() {}
    /// Does from now on what \a lead, which isn't null, has in it: a mute, a cap of the amplitude,
    /// signs of life. That it was opened is no sign of life then; that it was muted goes into \a
    /// lead. For whoever leads arrays before they are open and after they are closed; without, a
    /// device has a lead of its own.
    virtual void follow(const std::shared_ptr<Lead>& /*lead*/) {}
    /// Returns true if the last sign of life is longer ago than SafetyLimits::hold_s. Never waits.
    virtual bool isHoldOver() const { return false; }

    /// Replaces what is played by a sequence that the device times by itself, starting at once with
    /// the first signal. Returns false, and changes nothing, if refused: for send()'s reasons, or
    /// for more signals than ability().sequenceFields. No sign of life.
    virtual bool sendSequence(const DriveSequence& /*sequence*/) { return false; }

    /// Returns true if sendTogether() can hold a field back until other devices have theirs.
    virtual bool canStage() const { return false; }
    /// As send(), but the field sounds only once all devices in \a joint have their piece of it,
    /// and in none of them if one drops it. Every call joins or leaves \a joint once. A device that
    /// can't stage leaves it and plays at once. Null: as send().
    virtual bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint);

    /// Turns all transducers off at once and drops fields that wait; the next field sent plays.
    virtual void silence() = 0;

    /// Turns all transducers off at once, and refuses fields until setMuted(false). GuardedDevice,
    /// which openDevice() puts around every device, does the refusing; a device by itself only
    /// falls silent.
    virtual void setMuted(bool muted)
    {
        if (muted) silence();
    }

    /// Caps the amplitude of all that is played from now on at \a amplitude (0 .. 1 of full drive;
    /// anything else counts as 0), beside the limits that the device was opened with: what sounds
    /// already is lowered at once, or silenced. Returns false, with nothing changed, if the device
    /// has no such limit: its caller must then silence it. GuardedDevice has one.
    virtual bool setAmplitudeCap(double amplitude) { return amplitude >= 1; }

    /// What was asked for (send(), silence(), ..) before this time (steady clock) has been carried
    /// out, or something newer has: as far as the device can tell. A device that answers has said
    /// so, a driver's call has returned, a line has taken the bytes. Infinite: all is carried out
    /// within the call. Whatever was lost or refused is not carried out. See QuietWatch.
    virtual double confirmed_s() const { return std::numeric_limits<double>::infinity(); }

    /// One line of text: what the device is, its state and counters.
    virtual std::string status() const = 0;
    virtual DeviceReport report() const = 0;
    virtual DriveAbility ability() const { return {}; }

    /// Turns the lamp of a board, or of all boards for -1, on or off; returns false if the hardware
    /// has none.
    virtual bool identify(int /*board*/, bool /*light*/) { return false; }

    /// What the array plays now, as activations (m): quantised, limited, zero when silent. `sim:`
    /// measures it; other devices return what was sent.
    virtual std::vector<std::complex<float>> played() const = 0;

    /// What sounded at \a from_s (steady clock) or later, in order; the first may have begun
    /// before. It goes back a tenth of a second at most. Empty for all but simulations: nobody
    /// knows it.
    virtual std::vector<PlayedField> playedSince(double /*from_s*/) const { return {}; }

    /// What the array would play of \a signal, as activations (m): rounded to the hardware's levels
    /// and scaled down to the amplitude cap, without ramp and thermal budget.
    virtual std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const;
};

/// Opens a device: `sim:`, `usb:`, `record:FILE`, `null:`, ..; several URIs with commas in between
/// open several devices as one. Throws DeviceError.
std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout);
/// The same with \a limits. \a owner names the user of the device: while it is open, opening the
/// same hardware or recording again in this program throws DeviceError with that name.
std::unique_ptr<ArrayDevice> openLimitedDevice(const std::string& uri,
                                               const DeviceLayout& layout,
                                               const SafetyLimits& limits,
                                               const std::string& owner = {});

/// Returns true if \a uri, or one in its list, plays by itself (`play:`) and takes no fields.
/// Throws DeviceError for what isn't a URI.
bool playsByItself(const std::string& uri);

/// The schemes of URIs: "sim", "usb", ..
std::vector<std::string> deviceSchemes();

/// The kinds of devices, one line each, for help texts.
std::string deviceKinds();

} // namespace midair::device
