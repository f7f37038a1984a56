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

/// Options of a HologramPipeline; isValid() names the first one that is out of its range.
struct HologramOptions
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    std::string solver; ///< a name from haptics::solverNames(); empty: the first of them
    haptics::SolverOptions solverOptions;
    std::string deviceUri = "sim:";
    /// the name of this user of the device, for the message when another one opens the same device
    std::string owner;
    /// >= 0, in wavelengths; while no object moved farther than this, the last field is kept
    double motionTolerance = 0.01;
    /// >= 0; the largest number of control points of all objects together, lowered to
    /// base::kMostControlPoints; 0: the selector's default.
    int maxPoints = 0;
    /// >= 0; cap on the pressure at every control point, in peak Pa; 0: none. If the device's URI
    /// sets `max-pressure` too, the lower of the two holds.
    double maxPressure_Pa = 0.0;
    /// 0 .. 1 of full drive; cap on the amplitude of every transducer. If the device's URI sets
    /// `max-amplitude` too, the lower of the two holds.
    double maxAmplitude = 1.0;
    /// Amplitude modulation of everything that is played, for arrays too weak for a static image
    /// (rate 0: none); and the number of fields per second where fields are played in turn, the
    /// steps between them included.
    haptics::ModulatorOptions modulation;
    /// 1 .. 64; the number of fields, each for its own shifted points on the same surface. A scene
    /// at rest is played with all of them in turn, which smooths the speckle between the points;
    /// while it moves, each update takes the next one.
    int cycle = 1;
    /// 0 .. 16; the number of steps between one field of the cycle and the next, which make it
    /// quieter
    int cycleSteps = 0;
    /// 1 .. 64; the points are split into this many subsets, played in turn: each point is pressed
    /// less often, but harder
    int subsets = 1;
    /// If true, a scene at rest whose objects are all sampled along their edges, with no spacing of
    /// their own, is played as one stationary field for densely placed points, nearly without
    /// ripples.
    bool denseOutlines = true;
    /// 0 .. 1e6, s; the shortest interval at which a played field is certified and its surface
    /// measured, in another thread; raised to 0.05; 0 disables it.
    double monitorInterval_s = 0.0;

    /// Replacements for makeSolver and openLimitedDevice, for tests and for applications with their
    /// own solvers and devices; empty: those two.
    std::function<std::unique_ptr<haptics::HologramSolver>(const std::string&,
                                                           const haptics::SolverOptions&)>
        solverFactory;
    std::function<std::unique_ptr<device::ArrayDevice>(const std::string&,
                                                       const device::DeviceLayout&)>
        deviceFactory;

    /// Returns true if all options are in their ranges, else puts the reason into \a error.
    bool isValid(std::string* error = nullptr) const;
};

/// Lowers the options that exceed what the machine can do: threads to the number of cores,
/// maxPoints, subsets and cycleSteps to what fits into memory; raises a monitorInterval_s between 0
/// and 0.05 to 0.05. Each change is a message. Creates a thread pool for the solvers if there is
/// none.
void keepToLimits(HologramOptions& options, base::MessageLog& messages);

/// Fills in empty options: the default solver, makeSolver, and openLimitedDevice() with the limits
/// and the owner. The latter throws device::DeviceError for devices that play by themselves. Lowers
/// solverOptions.skipTolerance to motionTolerance.
void fillIn(HologramOptions& options);

/// Sets the phase and amplitude levels of the array in \a options to those of a device of
/// \a ability.
void keepToLevels(HologramOptions& options, const device::DriveAbility& ability);

/// The composer's options for \a options, which must be filled in and outlive the returned object:
/// its makeSolver reads them at each call.
haptics::ComposerOptions composerOptions(const HologramOptions& options);

} // namespace midair::bridge
