#pragma once

#include "device/ArrayDevice.h"
#include "haptics/sequence/Modulator.h"

#include <Eigen/Core>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Plays fields in turn, and modulated, on a device at a steady rate.
///
/// A device that keeps sequences and times them by itself (DriveAbility::sequenceFields) is handed
/// the whole of it, where the steps repeat within what it keeps (sequenceOfSteps()). On any other a
/// thread sends each step: the times of the steps are multiples of 1/fieldRate_Hz since play(); a
/// step that comes too late is left out, so that the cycle keeps its time. A single field without
/// modulation is sent once. All members may be called from any thread.
class FieldPlayer
{
public:
    /// \a device outlives the player; others may send to it and silence it while nothing is played
    /// here.
    explicit FieldPlayer(device::ArrayDevice& device);
    ~FieldPlayer(); ///< stops; the device holds what it plays, or goes on with its sequence

    FieldPlayer(const FieldPlayer&) = delete;
    FieldPlayer& operator=(const FieldPlayer&) = delete;

    /// From now on \a cycle (K >= 1 times m activations, |q| <= 1), in place of what was played.
    /// Doesn't wait for the device. With the modulation of before the new fields go on in its time,
    /// without a jump. Throws base::InputError, and goes on with what was played, for no fields,
    /// fields of different lengths, an activation that is not finite, and invalid options.
    void play(const std::vector<Eigen::VectorXcf>& cycle,
              const haptics::ModulatorOptions& modulation = {});

    /// Sends nothing more once it returns: at most the send at hand is waited for. A device that
    /// plays a sequence by itself goes on until it is sent something else, or silenced.
    void stop();

    struct Counters
    {
        std::uint64_t sent = 0;       ///< taken by the device; a sequence is one
        std::uint64_t refused = 0;    ///< not taken
        std::uint64_t leftOut = 0;    ///< steps that came too late
        double worstLateness_s = 0.0; ///< of a step, or the first of a sequence, that was sent
    };
    Counters counters() const;

private:
    /// A sequence on its way to a device that times it by itself.
    struct Whole
    {
        device::DriveSequence sequence;
        std::int64_t first = 0; ///< the step that its first signal is
    };

    void run();
    /// The next step to send, waited for; false when there is none any more.
    bool sendStep(std::unique_lock<std::mutex>& lock);
    /// While the device plays its sequence; ends when something else is to be played here, or the
    /// device was silenced.
    void watchSequence(std::unique_lock<std::mutex>& lock, std::uint64_t silences);
    /// Hands \a whole, or else the step, to the device, unlocked meanwhile; whether it was taken.
    bool handOver(std::unique_lock<std::mutex>& lock, Whole* whole, std::int64_t step);
    std::int64_t nextStep(double now_s) const
    {
        return static_cast<std::int64_t>((now_s - _start_s) / period_s()) + 1;
    }
    double period_s() const { return 1.0 / _modulator.options().fieldRate_Hz; }

    device::ArrayDevice& _device;
    mutable std::mutex
        _mutex; ///< of all that follows but _out; not held while the device takes a field
    std::condition_variable _wake;
    std::condition_variable _idle;
    std::vector<device::DriveSignal> _cycle; ///< empty: nothing is played
    std::shared_ptr<Whole> _whole; ///< null: sent step by step; its contents are the thread's
    bool _byItself = false;        ///< the device has _whole
    haptics::Modulator _modulator;
    std::uint64_t _generation = 0; ///< of _cycle
    double _start_s = 0.0;
    std::int64_t _step = 0; ///< next one
    bool _sending = false;
    bool _quit = false;
    Counters _counters;
    device::DriveSignal _out; ///< of the thread alone
    std::thread _thread;      ///< last: starts when all else is there
};

} // namespace midair::bridge
