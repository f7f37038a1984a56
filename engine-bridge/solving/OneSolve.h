#pragma once

#include "device/drive/DriveSignal.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/Outline.h"

#include <osgMidair/ExposureFigures>
#include <osgMidair/FieldSettings>

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Input of a single solve, for an array that isn't playing. The references outlive the call.
struct SolveTask
{
    /// What plays the fields, with its reflectors; already limited by keepToSignal().
    const haptics::TransducerArray& array;
    const haptics::Medium& medium;
    const haptics::FieldSettings& settings;
    /// Control points in the array frame, a set for each field of a cycle.
    std::vector<haptics::ControlPoints> sets = {};
    /// Modulation of the points; only with a single set.
    haptics::ModulationPlan plan = {};
    /// Places where the fields of a cycle, or one held field, are evened out; none: they are not.
    haptics::ControlPoints places = {};
    /// Outlines for one stationary field, instead of the sets.
    std::optional<std::vector<haptics::Outline>> outlines = std::nullopt;
    /// Outlines exist, but none is within reach: the field is silence. Otherwise having none is an
    /// error.
    bool outlinesOutOfReach = false;
    bool absolute = false;          ///< the outlines' targets are in Pa
    double modulation_Hz = 0.0;     ///< 0 .. 500; amplitude modulation of the whole output
    const EarBound* ears = nullptr; ///< null: no ear limit
    /// Returns the complex pressures, Pa, that something outside the array's model adds to those of
    /// activations (m) at places (3 x n); empty: nothing. Measured pressures
    /// include them, the pressure cap holds with and without them, ears don't know them.
    std::function<Eigen::VectorXcd(const Eigen::Matrix3Xd& places, const Eigen::VectorXcf& q)>
        outside_Pa = {};
    SilenceRemedy remedy = {}; ///< names of the settings in messages
    /// The array with the reflectors that fields are solved for; null: with all. Caps and figures
    /// know all.
    const haptics::TransducerArray* solvedFor = nullptr;
    /// Replacement for haptics::makeSolver; empty: the original.
    std::function<std::unique_ptr<haptics::HologramSolver>(const std::string&,
                                                           const haptics::SolverOptions&)>
        makeSolver = {};
    base::StopToken stop = {}; ///< once requested, base::Stopped is thrown
};

/// Fields as their drives play them, with their points.
struct SolvedFields
{
    haptics::FieldSequence sequence;          ///< at least one field, maybe silent
    std::vector<device::DriveSignal> signals; ///< one per field
    haptics::ControlPoints points;            ///< points of the sequence
    /// n, |p| computed in double from the encoded drive; each point in its own field, for an evened
    /// cycle as felt
    Eigen::VectorXd achieved_Pa;
    Eigen::VectorXd target_Pa; ///< n; relative targets at the level that was reached
};

/// Composes the fields, applies the caps, encodes the drives, and measures and rates their output.
/// Throws base::InputError for a task that can't be solved.
SolvedFields solveOnce(const SolveTask& task);

/// Returns the exposure of \a fields (K times m), played in turn forever, at the loudest place of
/// \a exposure. \a limit_dB: the ear limit, for the figures.
haptics::ExposureFigures steadyExposure(haptics::Exposure& exposure,
                                        const std::vector<Eigen::VectorXcf>& fields,
                                        double limit_dB);

} // namespace midair::bridge
