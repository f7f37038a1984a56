#pragma once

#include "device/drive/DriveSequence.h"
#include "device/drive/DriveSignal.h"

#include <complex>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace midair::device
{

class JointCommit;

/// Thrown when a device can't be opened or a URI can't be read: what() names the URI and what would
/// be right.
class DeviceError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// How the transducers are spread over the hardware; the caller knows it from the array file.
struct DeviceLayout
{
    int transducers = 0;
    std::vector<int> board; ///< transducers long, ascending from 0; empty: one board
};

/// Limits that hold whatever is sent; the stricter of these and of the URI's parameters of the same
/// names counts.
struct SafetyLimits
{
    double maxAmplitude = 1; ///< 0 .. 1 of full drive; a field that exceeds it is scaled down as a
                             ///< whole. `max-amplitude`
    double ramp_s =
        0; ///< 0 .. 10; amplitude rises from silence and falls at closing over this time. `ramp`
    double meanDrive = 1; ///< 0 .. 1; limit of the mean over transducers and time of amplitude
                          ///< squared. `mean-drive`
    double meanDriveTime_s = 10; ///< > 0; time constant of that mean. `mean-drive-time`
    double hold_s = 0;           ///< silence when no field came for so long; 0: hold it. `hold`
    /// >= 0; 0: none; peak Pa at any control point. A device knows none: it tells ability(), and
    /// who solves the field holds it (bridge::PressureCap). `max-pressure`
    double maxPressure_Pa = 0;
};

/// What can be played at all, for the solver to know.
struct DriveAbility
{
    int phaseLevels = 256;
    std::vector<float> amplitudes; ///< ascending in [0, 1]; empty: amplitudeLevels()
    /// SafetyLimits', to be held by whoever knows control points; 0: none.
    double maxPressure_Pa = 0;
    bool fades = false; ///< amplitudes may be lowered on the way: a ramp, a thermal budget
    /// m long, from 0: parts of the array that fade or fall silent by themselves; empty: all is
    /// one.
    std::vector<int> part = {};
    double fieldsPerSecond = 0; ///< how many the line to it carries; 0: more than anybody sends
    /// How many signals a DriveSequence may have that the device keeps and times by itself; 0: it
    /// takes none, and who plays fields in turn sends each in its time (bridge::FieldPlayer).
    int sequenceFields = 0;
};

enum class DeviceState
{
    READY, ///< plays what it is sent
    MUTED, ///< by setMuted()
    LOST   ///< unplugged or failing; comes back by itself where the device can
};

/// How a device fares. Every field that was sent is in one of the five: sent = played + dropped +
/// lost + refused + pending.
struct DeviceReport
{
    DeviceState state = DeviceState::READY;
    std::uint64_t sent = 0; ///< calls of send() and sendSequence(), which counts as one field
    std::uint64_t played =
        0; ///< confirmed by the device; where it doesn't answer: handed over whole
    std::uint64_t dropped =
        0;                  ///< overtaken by a newer field or by silence() before it was on its way
    std::uint64_t lost = 0; ///< on its way when the device failed or refused it
    std::uint64_t refused = 0;    ///< send() or sendSequence() gave false
    std::uint64_t pending = 0;    ///< waiting or on its way
    std::uint64_t faults = 0;     ///< stalls, timeouts, short transfers, unplugs, nonsense
    std::uint64_t reconnects = 0; ///< times that it came back
    /// Times that silence(), a mute or a hold ended what was played, by whomever: a sequence is to
    /// be sent again after it.
    std::uint64_t silences = 0;
    double lastHandedOver_s = 0; ///< std::chrono::steady_clock, when the last field was handed to
                                 ///< the hardware, with its commit; 0: never
    double latency_s = 0;        ///< of that field, from send() until then
    double skew_s = 0; ///< several devices: from the first to the last of them, for the last field;
                       ///< of arrays that commit together: of those
    double worstSkew_s = 0;
    std::string firmware;     ///< "1.2.3"; empty where unknown
    double temperature_C = 0; ///< 0 where unknown
    std::string message;      ///< the last fault; empty while there was none
    std::string shortfall;    ///< "3 of 1000 fields were played"; empty where it was half or more
};

/// A phased array that plays one field, or a sequence of fields, until the next replaces it whole.
/// send() never blocks on the hardware.
///
/// All members may be called from any thread.
class ArrayDevice
{
public:
    virtual ~ArrayDevice() = default; ///< silences the array

    /// Replaces the field as a whole, or not at all: false when refused (wrong length, muted,
    /// device lost), see status().
    virtual bool send(const DriveSignal& signal) = 0;

    /// Replaces what is played as a whole by fields that the device times by itself, the first of
    /// them at once, or not at all: false when refused, for send()'s reasons and for more signals
    /// than ability().sequenceFields.
    virtual bool sendSequence(const DriveSequence& /*sequence*/) { return false; }

    /// Whether sendTogether() can hold a field back until others have theirs.
    virtual bool canStage() const { return false; }
    /// As send(), but the field sounds when all devices in \a joint have their piece of it, and in
    /// none of them when one drops it. Every call joins or leaves it once. A device that can't
    /// stage leaves and plays at once; null: as send().
    virtual bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint);

    /// All transducers off, at once, overtaking fields that wait; the next field that is sent
    /// plays.
    virtual void silence() = 0;

    /// Off at once and until setMuted(false): fields sent meanwhile are refused. That is kept by
    /// the guard which openDevice() puts around every device; a device by itself falls silent.
    virtual void setMuted(bool muted)
    {
        if (muted) silence();
    }

    /// One line: what the device is and how it fares.
    virtual std::string status() const = 0;
    virtual DeviceReport report() const = 0;
    virtual DriveAbility ability() const { return {}; }

    /// Lights the lamp of a board, of all for -1; false where the hardware has none.
    virtual bool identify(int /*board*/, bool /*light*/) { return false; }

    /// What the array plays now, as activations (m): quantised, limited, zero when silent.
    /// Measured, by `sim:`; else as sent.
    virtual std::vector<std::complex<float>> played() const = 0;

    /// What the array plays of \a signal once it is there, as activations (m): rounded as the
    /// hardware does, scaled down to the amplitude cap; no ramp, no thermal budget.
    virtual std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const;
};

/// `sim:`, `usb:`, `record:FILE`, `null:`, ..; a list with commas opens several as one. Throws
/// DeviceError.
std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout);
/// \a owner is who drives it: another owner in this program that opens the same hardware or
/// recording meanwhile is refused by that name.
std::unique_ptr<ArrayDevice> openLimitedDevice(const std::string& uri,
                                               const DeviceLayout& layout,
                                               const SafetyLimits& limits,
                                               const std::string& owner = {});

/// Whether \a uri, or one in its list, is a show of its own (`play:`), which takes no fields from
/// anybody. Throws DeviceError for what isn't a URI.
bool playsByItself(const std::string& uri);

/// "sim", "usb", ..: what may stand before the colon of a URI.
std::vector<std::string> deviceSchemes();

/// The kinds of devices, one line each, for help texts.
std::string deviceKinds();

} // namespace midair::device
