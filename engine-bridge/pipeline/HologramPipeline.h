#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/pipeline/FieldMaker.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "engine-bridge/pipeline/StillScene.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "engine-bridge/playing/LineRate.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/OutlineHologram.h"

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
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
    std::string
        owner; ///< what messages call who drives the device, where somebody else wants it too
    double motionTolerance = 0.01; ///< >= 0, in wavelengths: what moved less is not solved again
    /// >= 0; control points shared by all objects, base::kMostControlPoints at most; 0: the selector's default.
    int maxPoints = 0;
    /// >= 0; peak Pa that no control point ever gets more than, whatever is asked for; 0: none. The device's own cap
    /// (`max-pressure` in its URI) counts too, the stricter one.
    double maxPressure_Pa = 0.0;
    /// 0 .. 1 of full drive; no transducer ever gets more. The device's own cap (`max-amplitude`) counts too, the stricter one.
    double maxAmplitude = 1.0;
    /// Amplitude modulation of all that is played, for arrays too weak for a static image (a rate of 0: none), and how
    /// many fields a second follow each other where they are played in turn, steps between them included.
    haptics::ModulatorOptions modulation;
    /// 1 .. 64; fields, each for its own shifted points on the same surface. What rests is played with all of them in turn, which
    /// smooths the speckle between the points; of what moves each update takes the next.
    int cycle = 1;
    int cycleSteps =
        0;           ///< 0 .. 16; between one of these fields and the next, so that less is heard
    int subsets = 1; ///< 1 .. 64; of the points, in turn: each is pressed less often, but harder
    /// Objects sampled along their edges with no spacing of their own are played, where they rest and nothing else is
    /// to be felt, in one stationary field for densely placed points, nearly without ripples.
    bool denseOutlines = true;
    /// >= 0, s; at most so often a field is certified and its surface measured, beside the solver; 0: never.
    double monitorInterval_s = 0.0;

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
    /// Throws base::InputError where the options are wrong. A device that can't be opened is a message: the field is
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
    /// Makes and plays what is still missing for what rests (the other fields of the cycle, outlines), and hands on
    /// what the monitor found.
    std::shared_ptr<const HologramResult> attend();
    /// How long attend() may be put off, s.
    double rest_s() const;
    /// A device that plays a still scene is looked after so often: a field that it lost is back within a blink.
    static constexpr double kAttend_s = 0.5; // each look costs some 50 us, most of it waking up

    /// The array plays nothing until the next process(), which solves in any case.
    void silence();

    /// To be given before the first process(). Where \a stop asks for it process() and attend() are back within milliseconds,
    /// with nothing sent any more: process() STOPPED and silent, attend() as if nothing had changed.
    void setStop(const base::StopToken& stop);
    /// Any thread, while process() is at work: the array is silent. What is in hand may be played after it, unless a stop
    /// was asked for before.
    void silenceNow();

    const HologramCounters& counters() const { return _counters; }
    const HologramOptions& options() const { return _options; }
    const std::vector<std::string>& messages() const { return _messages.all(); }

private:
    void openDevice();
    void silenceDevice();
    const haptics::TransducerArray& arrayFor(const HologramResult& result);
    void play(const haptics::TransducerArray& array, HologramResult& result);
    PressureCap::Where whereCapHolds(const haptics::TransducerArray& array,
                                     const HologramResult& result) const;
    void noteCap(HologramResult& result);
    void holdToCap(const haptics::TransducerArray& array, HologramResult& result);
    bool sendSignal();
    std::string refusal() const;
    Eigen::VectorXcf wouldPlay(const device::DriveSignal& signal) const;
    Eigen::VectorXcf playedNow() const;
    void measure(const haptics::TransducerArray& array, HologramResult& result) const;
    std::shared_ptr<const HologramResult> solveAndPlay(const SceneSnapshot& snapshot);
    std::shared_ptr<const HologramResult> lookAfterDevice();
    void keepToLimits();
    std::shared_ptr<const HologramResult> stopped(const SceneSnapshot& snapshot);
    std::shared_ptr<const HologramResult> refuse(const SceneSnapshot& snapshot,
                                                 const std::string& why);
    void finish(const SceneSnapshot& snapshot, HologramResult& result);
    double updatesPerSecond();

    // HologramTurns.cpp: fields in turn, and what is done while nothing moves.
    void prepareTurns();
    int nextSet();
    void usePlayer(bool inTurn);
    void handToPlayer(const std::vector<Eigen::VectorXcf>& fields);
    void playMade(const haptics::TransducerArray& array, MadeFields& made, HologramResult& result);
    void playInTurn(const haptics::TransducerArray& array,
                    const std::vector<Eigen::VectorXcf>& fields,
                    HologramResult& result);
    void remember(const SceneSnapshot& snapshot,
                  int set,
                  MadeFields& made,
                  const HologramResult& result);
    std::shared_ptr<const HologramResult> goOn();
    bool makeNextSet();
    std::shared_ptr<const HologramResult> playAllSets();
    bool isOutline(const SceneSnapshot& snapshot) const;
    std::vector<haptics::Outline> stillOutlines() const;
    std::shared_ptr<const HologramResult> playOutlines();
    std::shared_ptr<const HologramResult> askMonitor();
    void submitToMonitor(const HologramResult& result);
    Eigen::VectorXf achievedOf(const haptics::TransducerArray& array, const MadeFields& made) const;
    void fitLevel(const haptics::TransducerArray& array,
                  Eigen::VectorXcf& q,
                  const HologramResult& result) const;

    HologramOptions _options;
    std::mutex
        _sending; ///< of what is sent to the device and the player, and of the player's coming and going
    std::unique_ptr<device::ArrayDevice> _device;
    std::unique_ptr<FieldPlayer>
        _player; ///< while fields are played in turn or modulated: what sends to the device; gone first
    std::string _deviceError;
    base::MessageLog _messages;
    std::unique_ptr<FieldMaker> _maker;
    std::unique_ptr<haptics::OutlineHologram> _outlines;
    StillScene _still;
    std::unique_ptr<haptics::FieldMonitor> _monitor;
    std::unique_ptr<PointAssembler> _assembler;
    ReachAndShadow _around;
    HologramCounters _counters;

    bool _playing = false;        ///< what was assembled last is what the array plays
    bool _holds = false;          ///< the device is to hold _signal
    device::DeviceReport _before; ///< when _signal was sent
    std::unique_ptr<PressureCap> _cap;
    haptics::ModulatorOptions _modulation; ///< of what is played
    LineRate _line;
    Eigen::VectorXcf _q;
    device::DriveSignal _signal; ///< of fields in turn the first
    std::shared_ptr<const HologramResult> _last;
    std::deque<double> _solveTimes_s; ///< of the last second
};

} // namespace midair::bridge
