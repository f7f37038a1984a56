#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/FieldPlayer.h"
#include "engine-bridge/HologramResult.h"
#include "engine-bridge/MessageLog.h"
#include "engine-bridge/PointAssembler.h"
#include "engine-bridge/PressureCap.h"
#include "engine-bridge/SceneSnapshot.h"
#include "haptics/HologramSolver.h"
#include "haptics/Medium.h"
#include "haptics/TransducerArray.h"

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// What a HologramPipeline works with; isValid() names the first thing that is wrong.
struct HologramOptions
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    std::string solver; ///< a name that makeSolver knows; empty: its default
    haptics::SolverOptions solverOptions;
    std::string deviceUri = "sim:";
    double motionTolerance = 0.01; ///< >= 0, in wavelengths: what moved less is not solved again
    int maxPoints = 0; ///< >= 0; control points shared by all objects; 0: the selector's default
    /// >= 0; peak Pa that no control point ever gets more than, whatever is asked for; 0: none. The device's own cap
    /// (`max-pressure` in its URI) counts too, the stricter one.
    double maxPressure_Pa = 0.0;
    /// Amplitude modulation of all that is played, for arrays too weak for a static image; a rate of 0: none, and no
    /// thread for it.
    haptics::ModulatorOptions modulation;

    /// Stand-ins for tests and applications with their own; empty: makeSolver and openDevice.
    std::function<std::unique_ptr<haptics::HologramSolver>(const std::string&,
                                                           const haptics::SolverOptions&)>
        solverFactory;
    std::function<std::unique_ptr<device::ArrayDevice>(const std::string&,
                                                       const device::DeviceLayout&)>
        deviceFactory;

    bool isValid(std::string* error = nullptr) const;
};

/// The way of one snapshot to the array: sampled (cached), posed, selected, solved, encoded, sent; in one thread.
///
/// Nothing that a snapshot holds makes process() throw: an object that can't be felt is left out with a message, and
/// when the field can't be made the array falls silent. The message log says each thing once.
class HologramPipeline
{
public:
    /// Throws haptics::InputError where the options are wrong. A device that can't be opened is a message: the field is
    /// then solved and shown as it would be played.
    explicit HologramPipeline(HologramOptions options);
    ~HologramPipeline(); ///< silences the device

    HologramPipeline(const HologramPipeline&) = delete;
    HologramPipeline& operator=(const HologramPipeline&) = delete;

    /// The field for \a snapshot, or the last one again where nothing moved by more than the tolerance. Never null.
    /// \a superseded: how many snapshots were dropped for this one; only counted.
    std::shared_ptr<const HologramResult> process(const SceneSnapshot& snapshot,
                                                  std::uint64_t superseded = 0);

    /// To be called now and then while no snapshot comes: sends the field again that a device has lost (unplugged and back,
    /// muted by its watchdog, a packet gone), since what doesn't move brings no next field. Null where nothing changed.
    std::shared_ptr<const HologramResult> attend();

    /// The array plays nothing until the next process(), which solves in any case.
    void silence();

    const HologramCounters& counters() const { return _counters; }
    const HologramOptions& options() const { return _options; }
    const std::vector<std::string>& messages() const { return _messages.all(); }

private:
    void openDevice();
    void silenceDevice();
    const haptics::TransducerArray& arrayFor(const HologramResult& result);
    void play(const haptics::TransducerArray& array, HologramResult& result);
    void holdToCap(const haptics::TransducerArray& array, HologramResult& result);
    bool sendSignal();
    std::string refusal() const;
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    Eigen::VectorXcf playedNow() const;
    void measure(const haptics::TransducerArray& array, HologramResult& result) const;
    std::shared_ptr<const HologramResult> solveAndPlay(const SceneSnapshot& snapshot);
    std::shared_ptr<const HologramResult> refuse(const SceneSnapshot& snapshot,
                                                 const std::string& why);
    void finish(const SceneSnapshot& snapshot, HologramResult& result);
    double updatesPerSecond();
    haptics::HologramSolver& solver(bool absolute);

    HologramOptions _options;
    std::unique_ptr<device::ArrayDevice> _device;
    std::unique_ptr<FieldPlayer> _player; ///< where modulated: what sends to the device; gone first
    std::string _deviceError;
    std::unique_ptr<haptics::HologramSolver> _relativeSolver;
    std::unique_ptr<haptics::HologramSolver> _absoluteSolver;
    MessageLog _messages;
    std::unique_ptr<PointAssembler> _assembler;
    SurroundingsEffect _around;
    HologramCounters _counters;

    bool _playing = false;        ///< what was assembled last is what the array plays
    bool _holds = false;          ///< the device is to hold _signal
    device::DeviceReport _before; ///< when _signal was sent
    std::unique_ptr<PressureCap> _cap;
    Eigen::VectorXcf _q;
    device::DriveSignal _signal;
    std::shared_ptr<const HologramResult> _last;
    std::deque<double> _solveTimes_s; ///< of the last second
};

/// Seconds of the steady clock, as SceneSnapshot::time_s wants them.
double steadySeconds();

} // namespace midair::bridge
