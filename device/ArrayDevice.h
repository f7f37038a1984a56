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

/// Thrown when a device can't be opened or its URI can't be parsed. what() names the URI and the
/// expected value.
class DeviceError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// Number of transducers and their boards, from the array file.
struct DeviceLayout
{
    int transducers = 0;
    std::vector<int> board; ///< board of each transducer, ascending from 0; empty: one board
    /// Indices of transducers that are never driven, for hardware that can mask them. Callers send
    /// 0 for them anyway.
    std::vector<int> dead = {};
};

/// Limits on everything that a device plays. The URI parameter named with each limit can set it,
/// too; the stricter value applies, except for `mean-drive-time`, where the URI overrides this one.
struct SafetyLimits
{
    /// 0 .. 1 of full drive; fields with a larger amplitude are scaled down as a whole.
    /// `max-amplitude`
    double maxAmplitude = 1;
    /// 0 .. 10; time in which the amplitude rises from silence to full, and falls at closing.
    /// `ramp`
    double ramp_s = 0;
    /// 0 .. 1; limit on the squared amplitude, averaged over transducers and time. `mean-drive`
    double meanDrive = 1;
    double meanDriveTime_s = 10; ///< > 0; time constant of that average. `mean-drive-time`
    /// >= 0; without a keepAlive() for this time the device falls silent and refuses fields; 0: it
    /// holds the last field. In a list of devices the shortest applies to all. `hold`
    double hold_s = 0;
    /// >= 0; cap on the peak pressure at control points, Pa; 0: none. Devices don't know the
    /// control points: they only report the cap in ability(), and bridge::PressureCap enforces it.
    /// `max-pressure`
    double maxPressure_Pa = 0;
};

/// Levels, caps and rates of a device, for the solver.
struct DriveAbility
{
    int phaseLevels = 256;         ///< phase levels per turn
    std::vector<float> amplitudes; ///< ascending in [0, 1]; empty: amplitudeLevels()
    /// SafetyLimits::maxPressure_Pa, which the caller enforces because it knows the control points;
    /// 0: none.
    double maxPressure_Pa = 0;
    double maxAmplitude = 1; ///< SafetyLimits::maxAmplitude; for several devices the least strict
    bool fades = false;      ///< true: the device may lower amplitudes (ramp, thermal budget)
    /// For each transducer (m) its part of the array, from 0. Parts fade or fall silent separately.
    /// Empty: one part.
    std::vector<int> part = {};
    double fieldsPerSecond = 0; ///< capacity of the connection, fields/s; 0: no limit
    /// Maximum number of signals in a DriveSequence, which the device stores and times itself; 0:
    /// no sequences; bridge::FieldPlayer then sends each field at its time.
    int sequenceFields = 0;
    /// >= 0, s: ringing time constant of a simulation, instead of the array file's; below 0: the
    /// file's.
    double ringing_s = -1;
    /// A sequence's rate must be this over a whole number, Hz; 0: any. Other sequences are sent
    /// field by field.
    double sequenceClock_Hz = 0;
};

/// Whether a device plays what is sent; the worst of several devices counts.
enum class DeviceState
{
    READY, ///< plays what is sent
    MUTED, ///< by setMuted()
    /// a driver call doesn't return, or the driver could not silence the device, so its output is
    /// unknown; ends when the call returns or a silence is written
    HANGING,
    LOST ///< unplugged or failing; becomes READY when the device comes back
};

/// State and counters of a device. Each field sent is in exactly one of five counters: sent =
/// played + dropped + lost + refused + pending.
struct DeviceReport
{
    DeviceState state = DeviceState::READY;
    std::uint64_t sent = 0; ///< calls of send() and sendSequence(); a sequence counts as one field
    /// confirmed by the device; if it doesn't answer: completely handed over
    std::uint64_t played = 0;
    /// replaced by a newer field, or ended by silence(), before it played
    std::uint64_t dropped = 0;
    std::uint64_t lost = 0;       ///< in transfer when the device failed, or refused by the device
    std::uint64_t refused = 0;    ///< send() or sendSequence() returned false
    std::uint64_t pending = 0;    ///< waiting, in transfer or not confirmed yet
    std::uint64_t faults = 0;     ///< stalls, timeouts, short transfers, unplugs, invalid answers
    std::uint64_t reconnects = 0; ///< times that the device came back
    /// Number of silences by silence(), a mute, SafetyLimits::hold_s or an unconfirmed quieter
    /// field. After one of them a sequence must be sent again.
    std::uint64_t silences = 0;
    /// Time when the last field was handed to the hardware, with its commit,
    /// std::chrono::steady_clock; 0: never.
    double lastHandedOver_s = 0;
    double latency_s = 0; ///< from send() of that field to lastHandedOver_s
    /// For several devices: time between the first and the last device that got the last field; if
    /// some of them commit together, among those.
    double skew_s = 0;
    double worstSkew_s = 0;   ///< the largest skew_s so far
    std::string firmware;     ///< "1.2.3"; empty: unknown
    double temperature_C = 0; ///< 0: unknown
    std::string message;      ///< the last fault; empty if there was none
    /// Reason why a due silence was not written, as a sentence, so the device may still play;
    /// otherwise empty. Writing is retried.
    std::string unsilenced;
    /// Reason why GuardedDevice silenced the device, as a sentence: a quieter field was not
    /// confirmed. Empty: not silenced, or another field was confirmed since.
    std::string quieted;
    /// Problem of a driver that plays nevertheless, as a sentence; empty: none.
    std::string complaint;
    std::string shortfall; ///< "3 of 1000 fields were played"; empty if half or more were
};

/// Output of an array from a time until the next PlayedField.
struct PlayedField
{
    double since_s = 0;                 ///< std::chrono::steady_clock
    std::vector<std::complex<float>> q; ///< activations (m), as in played()
};

/// A phased array, which plays a field or a sequence of fields until the next one replaces it.
/// send() never blocks on the hardware.
///
/// Any thread may call any member.
class ArrayDevice
{
public:
    /// The destructor silences the array.
    virtual ~ArrayDevice() = default;

    /// Replaces the playing field. Returns false, and changes nothing, if the field is refused
    /// (wrong length, muted, device lost); status() gives the reason. For the application that
    /// leads the array: each call is a sign of life.
    virtual bool send(const DriveSignal& signal) = 0;
    /// The same for players with their own thread: not a sign of life. Also refuses while
    /// isHoldOver().
    virtual bool sendUnled(const DriveSignal& signal) { return send(signal); }

    /// Sign of life: the leading application (a frame, a tracker, a loop) still wants the output.
    /// Without it a device with SafetyLimits::hold_s falls silent, and stays silent until the next
    /// field. Opening counts as a sign of life. Never waits.
    virtual void keepAlive() {}
    /// Follows the mute, amplitude cap and signs of life of \a lead (not null) from now on. Opening
    /// is then not a sign of life, and an existing mute is copied to \a lead. For applications that
    /// control arrays before opening and after closing; otherwise a device has its own lead.
    virtual void follow(const std::shared_ptr<Lead>& /*lead*/) {}
    /// Returns true if the last sign of life is older than SafetyLimits::hold_s. Never waits.
    virtual bool isHoldOver() const { return false; }

    /// Replaces the output by a sequence that the device times itself, starting at once with the
    /// first signal. Returns false, and changes nothing, if refused: for send()'s reasons, or for
    /// more signals than ability().sequenceFields. Not a sign of life.
    virtual bool sendSequence(const DriveSequence& /*sequence*/) { return false; }

    /// Returns true if sendTogether() can hold a field back until other devices have theirs.
    virtual bool canStage() const { return false; }
    /// As send(), but the field plays only when all devices in \a joint have their part of it, and
    /// in none of them if one drops it. Each call joins or leaves \a joint once. A device that
    /// can't stage leaves it and plays at once. Null: as send().
    virtual bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint);

    /// Turns all transducers off at once and drops waiting fields; the next field sent plays.
    virtual void silence() = 0;

    /// Turns all transducers off at once and refuses fields until setMuted(false). GuardedDevice,
    /// which openDevice() puts around every device, refuses them; a bare device only falls silent.
    virtual void setMuted(bool muted)
    {
        if (muted) silence();
    }

    /// Caps the amplitude of all output at \a amplitude (0 .. 1 of full drive; other values count
    /// as 0), in addition to the limits at opening: present output is lowered at once, or silenced.
    /// Returns false, with nothing changed, if the device has no such limit; the caller must then
    /// silence it. GuardedDevice has one.
    virtual bool setAmplitudeCap(double amplitude) { return amplitude >= 1; }

    /// Everything requested (send(), silence(), ..) before this time (steady clock) was carried out
    /// or superseded, as far as the device can tell: it has answered, a driver call has returned,
    /// or a line has taken the bytes. Infinite: calls complete everything themselves. Lost or
    /// refused requests don't count. See QuietWatch.
    virtual double confirmed_s() const { return std::numeric_limits<double>::infinity(); }

    /// Returns one line of text: device, state and counters.
    virtual std::string status() const = 0;
    virtual DeviceReport report() const = 0;
    virtual DriveAbility ability() const { return {}; }

    /// Turns the lamp of a board (-1: all boards) on or off; returns false if there is none.
    virtual bool identify(int /*board*/, bool /*light*/) { return false; }

    /// Returns the present output as activations (m): quantised, limited, zero when silent. `sim:`
    /// measures it; other devices return what was sent.
    virtual std::vector<std::complex<float>> played() const = 0;

    /// Returns what was played at \a from_s (steady clock) or later, in order; the first may have
    /// begun before. Goes back a tenth of a second at most. Empty for all devices but simulations.
    virtual std::vector<PlayedField> playedSince(double /*from_s*/) const { return {}; }

    /// Returns the activations (m) that the array would play for \a signal: rounded to the
    /// hardware's levels and scaled down to the amplitude cap, without ramp and thermal budget.
    virtual std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const;
};

/// Opens a device: `sim:`, `usb:`, `record:FILE`, `null:`, ..; several URIs separated by commas
/// open several devices as one. Throws DeviceError.
std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout);
/// The same with \a limits. \a owner names the device's user: while it is open, opening the same
/// hardware or recording again in this program throws DeviceError with that name.
std::unique_ptr<ArrayDevice> openLimitedDevice(const std::string& uri,
                                               const DeviceLayout& layout,
                                               const SafetyLimits& limits,
                                               const std::string& owner = {});

/// Returns true if \a uri, or one in its list, plays by itself (`play:`) and takes no fields.
/// Throws DeviceError for an invalid URI.
bool playsByItself(const std::string& uri);

/// Returns the schemes of URIs: "sim", "usb", ..
std::vector<std::string> deviceSchemes();

/// Returns the kinds of devices, one line each, for help texts.
std::string deviceKinds();

} // namespace midair::device
