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

/// What is to be solved once, for an array that nothing plays yet. The references outlive the call.
struct SolveTask
{
    const haptics::TransducerArray& array; ///< its levels have passed keepToSignal()
    const haptics::Medium& medium;
    const haptics::FieldSettings& settings;
    /// Control points in the array frame, a set for each field of a cycle.
    std::vector<haptics::ControlPoints> sets = {};
    /// Modulation of the single points; of one set alone.
    haptics::ModulationPlan plan = {};
    /// Where the fields of a cycle are evened out; no points: only at those of the sets.
    haptics::ControlPoints places = {};
    /// In place of the sets: outlines for one stationary field.
    std::optional<std::vector<haptics::Outline>> outlines = std::nullopt;
    /// There are outlines, and none is within reach: the field is silence. Else it is an error if
    /// there are none.
    bool outlinesOutOfReach = false;
    bool absolute = false;          ///< the outlines' targets are in Pa
    double modulation_Hz = 0.0;     ///< 0 .. 500; amplitude modulation of all that is played
    const EarBound* ears = nullptr; ///< null: no ear limit
    SilenceRemedy remedy = {};      ///< names of the settings in messages
    /// Replacement for haptics::makeSolver; empty: that one.
    std::function<std::unique_ptr<haptics::HologramSolver>(const std::string&,
                                                           const haptics::SolverOptions&)>
        makeSolver = {};
    base::StopToken stop = {}; ///< once requested, base::Stopped is thrown
};

/// The fields as their drives play them, and what they are for.
struct SolvedFields
{
    haptics::FieldSequence sequence;          ///< at least one field, maybe silent
    std::vector<device::DriveSignal> signals; ///< one per field
    haptics::ControlPoints points;            ///< points of the sequence
    /// n, |p| computed in double from the encoded drive; each point in the field made for it, of an
    /// evened cycle what is felt
    Eigen::VectorXd achieved_Pa;
    Eigen::VectorXd target_Pa; ///< n; relative targets are at the level that was reached
};

/// Composes the fields, applies the caps, encodes the drives and measures and rates what these
/// play. Throws base::InputError for what can't be solved for.
SolvedFields solveOnce(const SolveTask& task);

/// How loud \a fields (K times m), played in turn without end, are at the loudest place of
/// \a exposure. \a limit_dB: the ear limit, for the figures.
haptics::ExposureFigures steadyExposure(haptics::Exposure& exposure,
                                        const std::vector<Eigen::VectorXcf>& fields,
                                        double limit_dB);

} // namespace midair::bridge
