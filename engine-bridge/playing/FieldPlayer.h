#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/sequence/Modulator.h"

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Replaces \a out by the signal for step \a step (>= 0; at step/fieldRate_Hz) of a modulated
/// \a cycle of at least one signal.
void signalOfStep(const std::vector<device::DriveSignal>& cycle,
                  const haptics::Modulator& modulator,
                  std::int64_t step,
                  device::DriveSignal& out);

/// Returns all steps of one period of a modulated \a cycle, for a device that times them itself.
/// Has no signals if the period is longer than \a most steps, or the modulation's period is not a
/// whole number of steps.
device::DriveSequence sequenceOfSteps(const std::vector<device::DriveSignal>& cycle,
                                      const haptics::Modulator& modulator,
                                      int most);

/// Plays fields in turn, with or without amplitude modulation, on a device at a steady rate.
///
/// A device that stores and times sequences (DriveAbility::sequenceFields) gets the whole sequence
/// if its steps repeat within that number (sequenceOfSteps()) and its clock has the rate
/// (DriveAbility::sequenceClock_Hz). Otherwise a thread sends each step at multiples of
/// 1/fieldRate_Hz since play(); late steps are skipped, so that the cycle keeps its time. A single
/// field without modulation is sent once. Sending is no sign of life: if the device has a hold, the
/// leader must give one (ArrayDevice::keepAlive()). All members may be called from any thread.
class FieldPlayer
{
public:
    /// \a device and \a clock must outlive the player; others may send to the device and silence it
    /// while the player plays nothing.
    explicit FieldPlayer(device::ArrayDevice& device,
                         const base::Clock& clock = base::steadyClock());
    ~FieldPlayer(); ///< stops sending; the device goes on with its last field or sequence

    FieldPlayer(const FieldPlayer&) = delete;
    FieldPlayer& operator=(const FieldPlayer&) = delete;

    /// Plays \a signals (K >= 1 fields, all of the same size) in turn instead of the last ones.
    /// Doesn't wait for the device. If \a modulation is unchanged, the new fields continue in step
    /// with the old ones, without a jump of the modulation. Throws base::InputError, and continues
    /// with the last ones, for no fields, fields of different sizes, and invalid options.
    void play(std::vector<device::DriveSignal> signals,
              const haptics::ModulatorOptions& modulation = {});

    /// Stops sending; waits for a send under way. A device that plays a sequence by itself goes on
    /// until it is sent something else or silenced.
    void stop();

    /// Counts since the player was made.
    struct Counters
    {
        std::uint64_t sent = 0;       ///< accepted steps or sequences; a sequence counts once
        std::uint64_t refused = 0;    ///< steps or sequences that the device refused
        std::uint64_t leftOut = 0;    ///< steps skipped because they were late
        double worstLateness_s = 0.0; ///< of a step, or of the first step of a sequence, when sent
        /// Why a device that times sequences was last sent one step by step; logged when it
        /// changes.
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

    /// The playing cycle and the position in it.
    struct Playing
    {
        std::vector<device::DriveSignal> cycle; ///< empty: nothing is played
        /// null: sent step by step; its contents belong to the thread
        std::shared_ptr<Whole> whole;
        bool byItself = false; ///< the device plays the whole sequence
        haptics::Modulator modulator;
        std::uint64_t generation = 0; ///< grows with each play() and stop()
        double start_s = 0.0;         ///< of step 0, by the clock
        std::int64_t step = 0;        ///< number of the next step

        double period_s() const { return 1.0 / modulator.options().fieldRate_Hz; }
        /// The number of the first step after \a now_s.
        std::int64_t nextStep(double now_s) const
        {
            return static_cast<std::int64_t>((now_s - start_s) / period_s()) + 1;
        }
    };

    void run() MIDAIR_EXCLUDES(_mutex);
    void tellStreamed(std::string why) MIDAIR_EXCLUDES(_mutex);
    bool isReplaced(std::uint64_t generation) const MIDAIR_REQUIRES(_mutex)
    {
        return _quit || _playing.generation != generation;
    }
    /// Waits until \a until_s, or until another \a generation is to be played; then returns true.
    bool awaitAnother(base::Lock& lock, std::uint64_t generation, double until_s)
        MIDAIR_REQUIRES(_mutex);
    /// Waits until the next step is due and sends it; returns false once the player ends.
    bool sendStep(base::Lock& lock) MIDAIR_REQUIRES(_mutex);
    /// Waits while the device plays its sequence; returns when something else is to be played or
    /// the device was silenced (its count differs from \a silences) or isn't READY.
    void watchSequence(base::Lock& lock, std::uint64_t silences) MIDAIR_REQUIRES(_mutex);
    /// Sends \a whole, or the step if that is null, to the device with the lock released; returns
    /// true if the device accepted it.
    bool handOver(Whole* whole, std::int64_t step) MIDAIR_REQUIRES(_mutex);
    /// Switches to sending step by step after the device refused the whole, if its line can carry
    /// that; also true if something else is to be played by now.
    bool isStreamedInstead() MIDAIR_REQUIRES(_mutex);

    device::ArrayDevice& _device;
    const base::Clock& _clock;

    mutable base::Mutex _mutex; ///< not held while the device takes a field
    base::Condition _wake;
    base::Condition _idle; ///< a send has ended
    Playing _playing MIDAIR_GUARDED_BY(_mutex);
    bool _sending MIDAIR_GUARDED_BY(_mutex) = false;
    bool _quit MIDAIR_GUARDED_BY(_mutex) = false;
    Counters _counters MIDAIR_GUARDED_BY(_mutex);

    device::DriveSignal _out; ///< used by the thread only
    std::thread _thread;      ///< last member: it uses all others
};

} // namespace midair::bridge
