#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/HologramSolver.h"

#include <functional>
#include <memory>
#include <string>

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
    /// >= 0; control points shared by all objects, base::kMostControlPoints at most; 0: the
    /// selector's default.
    int maxPoints = 0;
    /// >= 0; peak Pa that no control point ever gets more than, whatever is asked for; 0: none. The
    /// device's own cap
    /// (`max-pressure` in its URI) counts too, the stricter one.
    double maxPressure_Pa = 0.0;
    /// 0 .. 1 of full drive; no transducer ever gets more. The device's own cap (`max-amplitude`)
    /// counts too, the stricter one.
    double maxAmplitude = 1.0;
    /// Amplitude modulation of all that is played, for arrays too weak for a static image (a rate
    /// of 0: none), and how many fields a second follow each other where they are played in turn,
    /// steps between them included.
    haptics::ModulatorOptions modulation;
    /// 1 .. 64; fields, each for its own shifted points on the same surface. What rests is played
    /// with all of them in turn, which smooths the speckle between the points; of what moves each
    /// update takes the next.
    int cycle = 1;
    int cycleSteps =
        0;           ///< 0 .. 16; between one of these fields and the next, so that less is heard
    int subsets = 1; ///< 1 .. 64; of the points, in turn: each is pressed less often, but harder
    /// Objects sampled along their edges with no spacing of their own are played, where they rest
    /// and nothing else is to be felt, in one stationary field for densely placed points, nearly
    /// without ripples.
    bool denseOutlines = true;
    /// >= 0, s; at most so often a field is certified and its surface measured, beside the solver;
    /// 0: never.
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

/// Takes down what \a options ask for beyond what the machine has, or than is good for it: threads
/// to the cores, points, subsets and steps to what fits into memory, looks of the monitor to twenty
/// a second. Each is a message. Gives the solvers a common thread pool where they have none.
void keepToLimits(HologramOptions& options, base::MessageLog& messages);

/// Puts in what \a options leave open: the default solver, makeSolver, and openLimitedDevice() with
/// the limits and the owner, but for devices that play by themselves, which are refused. Rows of G
/// are kept within the motion tolerance at most.
void fillIn(HologramOptions& options);

/// The array of \a options plays the levels that a device of \a ability has.
void keepToLevels(HologramOptions& options, const device::DriveAbility& ability);

/// What composes for \a options, which outlive it and are filled in. Its solvers are made with the
/// options as they then are.
haptics::ComposerOptions composerOptions(const HologramOptions& options);

} // namespace midair::bridge
