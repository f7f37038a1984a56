#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/rendering/ContactRenderer.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Options of a HologramPipeline; isValid() names the first that is out of range. If the device's
/// URI also sets `max-pressure` or `max-amplitude`, the lower cap holds.
struct HologramOptions : haptics::SequenceSettings, haptics::PlayingSettings
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    /// 3 x n, m, array frame: listening places in addition to those around the array; finite
    Eigen::Matrix3Xd earPoints = Eigen::Matrix3Xd(3, 0);
    std::string solver; ///< a name from haptics::solverNames(); empty: the first of them
    haptics::SolverOptions solverOptions; ///< its updateRate_Hz is the fieldRate
    std::string deviceUri = "sim:";
    /// s; pause before the first retry to open a device; later pauses are longer. 0: no retry.
    double reopen_s = 1.0;
    /// s, >= 0; how long a field has to be held before it is evened out or made louder, so that
    /// what moves from frame to frame costs nothing more; infinity, or even = 0: neither is done.
    /// 0, for what isn't played yet: each field of surfaces that move by less than a quarter of a
    /// wavelength is evened out in its place, and none is made louder.
    double restAfter_s = 0.15;
    /// the name of this user of the device, for the message when another user opens it
    std::string owner;
    /// The amplitude cap is 0 because of an invalid value, which is reported elsewhere.
    bool isSilencedElsewhere = false;
    std::vector<base::Message> notes; ///< messages about these options
    /// times the played fields, replaceable in tests; outlives the pipeline
    const base::Clock* clock = &base::steadyClock();
    ContactRendererOptions contacts;      ///< of objects rendered by contacts
    haptics::ModulatorOptions modulation; ///< of all output; its fieldRate_Hz is the fieldRate

    /// Replacements for makeSolver and openLimitedDevice, for tests and for applications with their
    /// own solvers and devices; empty: the originals.
    std::function<std::unique_ptr<haptics::HologramSolver>(const std::string&,
                                                           const haptics::SolverOptions&)>
        solverFactory;
    std::function<std::unique_ptr<device::ArrayDevice>(const std::string&,
                                                       const device::DeviceLayout&)>
        deviceFactory;

    double wavelength_m() const { return medium.wavelength(array.frequency_Hz); }

    /// Returns true if all options are in their ranges; else puts the reason into \a error.
    bool isValid(std::string* error = nullptr) const;
};

/// Lowers options that exceed the machine's resources: threads to the number of cores, maxPoints,
/// subsets and cycleSteps to what fits into memory; raises a monitorInterval between 0 and 0.05 to
/// 0.05. Reports each change. Creates a thread pool for the solvers if there is none.
void keepToLimits(HologramOptions& options, base::MessageLog& messages);

/// Fills in empty options: the default solver, makeSolver, and openLimitedDevice() with the owner
/// (the pipeline applies the limits), which throws device::DeviceError for devices that play by
/// themselves. Sets solverOptions.skipTolerance to motionTolerance.
void fillIn(HologramOptions& options);

/// Sets the phase and amplitude levels of the array in \a options, and the ringing of a simulated
/// one, to those of a device of \a ability.
void keepToLevels(HologramOptions& options, const device::DriveAbility& ability);

/// Returns the error for an unknown solver name.
base::CodedError noSolver(const std::string& name);

/// Returns the composer's options for \a options, which must be filled in and outlive the result:
/// its makeSolver reads them at each call.
haptics::ComposerOptions composerOptions(const HologramOptions& options);

} // namespace midair::bridge
