#pragma once

#include "device/ArrayDevice.h"
#include "haptics/sequence/Modulator.h"

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Plays fields in turn, with or without amplitude modulation, on a device at a steady rate.
///
/// A device that stores sequences and times them by itself (DriveAbility::sequenceFields) gets the
/// whole sequence if its steps repeat within that number (sequenceOfSteps()) and its clock has the
/// rate (DriveAbility::sequenceClock_Hz). For any other device, and any other sequence, a thread
/// sends each step, at multiples of 1/fieldRate_Hz since play(); steps that are late are skipped,
/// so that the cycle keeps its time. A single field without modulation is sent once. What it sends
/// is no sign of life: where the device has a hold, whoever leads has to give one
/// (ArrayDevice::keepAlive()). All members may be called from any thread.
class FieldPlayer
{
public:
    /// \a device must outlive the player; others may send to it and silence it while the player
    /// plays nothing.
    explicit FieldPlayer(device::ArrayDevice& device);
    ~FieldPlayer(); ///< stops sending; the device goes on with its last field or sequence

    FieldPlayer(const FieldPlayer&) = delete;
    FieldPlayer& operator=(const FieldPlayer&) = delete;

    /// Plays \a signals (K >= 1 fields, all for as many transducers) in turn from now on, in place
    /// of the last ones. Doesn't wait for the device. If \a modulation is the same as before, the
    /// new fields continue in step with the old ones, without a jump in the modulation. Throws
    /// base::InputError, and goes on playing the last ones, for no fields, fields of different
    /// sizes, and invalid options.
    void play(std::vector<device::DriveSignal> signals,
              const haptics::ModulatorOptions& modulation = {});

    /// Stops sending; waits for a send under way. A device that plays a sequence by itself goes on
    /// until it is sent something else or silenced.
    void stop();

    /// What was sent since the player was made.
    struct Counters
    {
        std::uint64_t sent = 0; ///< steps or sequences that the device took; a sequence counts once
        std::uint64_t refused = 0;    ///< steps or sequences that the device refused
        std::uint64_t leftOut = 0;    ///< steps skipped since they were late
        double worstLateness_s = 0.0; ///< of a step, or of the first step of a sequence, when sent
        /// Why a device that times sequences by itself was last sent one step by step; logged
        /// when it changes.
        std::string streamed;
    };
    Counters counters() const;

private:
    /// A sequence on its way to a device that times it by itself.
    struct Whole
    {
        device::DriveSequence sequence;
        std::int64_t first = 0; ///< the step number of its first signal
    };

    void run();
    void tellStreamed(std::string why);
    /// Waits until the next step is due and sends it; returns false once the player ends.
    bool sendStep(std::unique_lock<std::mutex>& lock);
    /// Waits while the device plays its sequence; returns when something else is to be played or
    /// the device was silenced (its count differs from \a silences) or isn't READY.
    void watchSequence(std::unique_lock<std::mutex>& lock, std::uint64_t silences);
    /// Sends \a whole, or the step if that is null, to the device with the lock released; returns
    /// true if the device took it.
    bool handOver(std::unique_lock<std::mutex>& lock, Whole* whole, std::int64_t step);
    /// Sends step by step from now on what the device refused as a whole, if its line carries that;
    /// true, too, if something else is to be played by now.
    bool isStreamedInstead(std::unique_lock<std::mutex>& lock);
    /// The number of the first step after \a now_s.
    std::int64_t nextStep(double now_s) const
    {
        return static_cast<std::int64_t>((now_s - _start_s) / period_s()) + 1;
    }
    double period_s() const { return 1.0 / _modulator.options().fieldRate_Hz; }

    device::ArrayDevice& _device;
    /// Guards all that follows except _out; not held while the device takes a field.
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    std::condition_variable _idle;           ///< a send has ended
    std::vector<device::DriveSignal> _cycle; ///< empty: nothing is played
    /// null: sent step by step; only the thread touches its contents
    std::shared_ptr<Whole> _whole;
    bool _byItself = false; ///< the device plays _whole
    haptics::Modulator _modulator;
    std::uint64_t _generation = 0; ///< grows with each play() and stop()
    double _start_s = 0.0;         ///< steady clock at step 0
    std::int64_t _step = 0;        ///< number of the next step
    bool _sending = false;
    bool _quit = false;
    Counters _counters;
    device::DriveSignal _out; ///< used by the thread only
    std::thread _thread;      ///< last member: it uses all others
};

} // namespace midair::bridge
