#pragma once

#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "engine-bridge/playing/PressureCap.h"
#include "engine-bridge/rendering/ContactView.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"

#include <osgMidair/ExposureFigures>
#include <osgMidair/HologramCounters>

#include <Eigen/Core>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// One solved field, handed back to the overlays, the HUD and the report; immutable.
struct HologramResult
{
    std::uint64_t frame = 0;       ///< of the snapshot it was solved for
    double simulationTime_s = 0.0; ///< of that snapshot
    double latency_ms = 0.0;       ///< from SceneSnapshot::time_s until the field was handed over
    double handedOver_s = 0.0;     ///< steady clock, when what is played was handed to the device
    /// affine, from the scene's world, in its units, to the array
    Eigen::Matrix4d worldToArray = Eigen::Matrix4d::Identity();
    /// What the points were solved with, shadows of hands included; null if there is no pipeline.
    std::shared_ptr<const haptics::TransducerArray> array;
    haptics::Medium medium;
    /// The fields as the device plays them, with the parts and the report of what was solved; one
    /// silent field if there is nothing to play, no fields if there is no pipeline.
    haptics::FieldSequence sequence;
    haptics::ControlPoints points; ///< of the sequence, array frame
    /// HapticObject::origin of the snapshot's objects, which points.object counts
    std::vector<std::shared_ptr<const void>> origins;
    /// What was left out of these objects, in their order; empty where nothing was assembled.
    std::vector<ObjectPoints> objects;
    /// 3 x k, array frame: points that were left out (workspace, spacing, budget, reach).
    Eigen::Matrix3Xd skipped;
    /// n, |p| at each point in the field that is for it, as played; of an evened cycle what is felt
    Eigen::VectorXf achieved_Pa;
    /// True if the field is one stationary field for dense points along outlines.
    bool outline = false;
    /// What is played where hands touch; null: nothing of the scene is rendered by contacts.
    std::shared_ptr<const ContactScene> touched;
    /// Certificate and surface figures of the newest field that the monitor measured; null: none
    /// yet.
    std::shared_ptr<const haptics::FieldMonitor::Result> monitored;
    double maxPressure_Pa = 0.0;       ///< cap at the control points, peak; 0: none
    haptics::ExposureFigures exposure; ///< when this was made
    /// True if the device took the field, if no device is open, or if there is nothing to play.
    bool playing = false;
    bool deviceOpen = false;               ///< false: the device could not be opened
    ArrayState state = ArrayState::CLOSED; ///< what the array did when this was made
    HologramCounters counters;
    double updatesPerSecond = 0.0; ///< snapshots solved within the last second
    std::string deviceStatus;
    std::vector<std::string> messages; ///< for the user, all so far, each once
    std::vector<base::Message> told;   ///< the same, with what they are about

    /// The first field that the device plays, as m activations. Empty if there is no pipeline.
    const Eigen::VectorXcf& played() const;
    const haptics::SolveReport& report() const { return sequence.report; }
    /// True if there is a field but no level of the array to play it with.
    bool isSilenced() const { return report().stop == haptics::StopReason::SILENCED; }
};

/// Counts how many snapshots were solved within the last second.
class UpdateRate
{
public:
    void count(double now_s) { _times_s.push_back(now_s); }
    /// The number of count() calls within the second before \a now_s.
    double perSecond(double now_s);

private:
    std::deque<double> _times_s; // of the last second
};

/// Adds what \a assembler made of a snapshot, and what a solver reports, to \a counters.
void count(const PointAssembler& assembler,
           const AssembledPoints& assembled,
           HologramCounters& counters);
void count(const haptics::SolveReport& report, HologramCounters& counters);

/// Replaces the fields in \a result by those that \a output plays (quantised, limited), puts the
/// pressure at the points into achieved_Pa, and if a cap of the pressure or of the amplitude scaled
/// the fields down or they are evened out, computes the report's level figures again, and so for
/// fields of which the levels leave nothing. Returns false if nothing is to sound. \a known: a held
/// field of which the pressures at the points are known; may be empty.
bool measurePlayed(const ArrayOutput& output,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium,
                   const haptics::SolverOptions& options,
                   const CappedField& known,
                   HologramResult& result);

} // namespace midair::bridge
