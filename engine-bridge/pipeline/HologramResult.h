#pragma once

#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "engine-bridge/playing/PressureCap.h"
#include "engine-bridge/rendering/ContactView.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/probe/FingertipForce.h"
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

/// One solved field, for overlays, HUD and report; immutable.
struct HologramResult
{
    std::uint64_t frame = 0;       ///< of the snapshot it was solved for
    double simulationTime_s = 0.0; ///< of that snapshot
    double latency_ms = 0.0;       ///< from SceneSnapshot::time_s until the field was handed over
    double handedOver_s = 0.0;     ///< steady clock; when this field was handed to the device
    /// affine, from the scene's world, in its units, to the array
    Eigen::Matrix4d worldToArray = Eigen::Matrix4d::Identity();
    /// The array used for solving, including shadows of hands; null if there is no pipeline.
    std::shared_ptr<const haptics::TransducerArray> array;
    haptics::Medium medium;
    /// The fields as the device plays them, with the parts and the report of the solve; one silent
    /// field if there is nothing to play, no fields if there is no pipeline.
    haptics::FieldSequence sequence;
    haptics::ControlPoints points; ///< of the sequence, array frame
    int foci = 0;                  ///< number of the last points that are foci of contacts, in Pa
    /// HapticObject::origin of the snapshot's objects, indexed by points.object
    std::vector<std::shared_ptr<const void>> origins;
    /// Omissions of these objects, in their order; empty if nothing was assembled.
    std::vector<ObjectPoints> objects;
    /// 3 x k, array frame: points that were left out (workspace, spacing, budget, reach).
    Eigen::Matrix3Xd skipped;
    /// n, |p| at each point in its own field, as played; for an evened cycle as felt
    Eigen::VectorXf achieved_Pa;
    /// Force on a fingertip at the point with the highest of these, for foci up to 0.1 s ago; 0 N
    /// while none is played.
    haptics::FingertipForce fingertip;
    /// True: one stationary field for dense points along outlines.
    bool outline = false;
    /// Contacts that are played; null: no object is rendered by contacts.
    std::shared_ptr<const ContactScene> touched;
    /// Certificate and surface figures of the newest field that the monitor has measured; null:
    /// none yet.
    std::shared_ptr<const haptics::FieldMonitor::Result> monitored;
    double maxPressure_Pa = 0.0;       ///< cap at the control points, peak; 0: none
    haptics::ExposureFigures exposure; ///< when this was made
    /// True if the device accepted the field, if no device is open, or if there is nothing to play.
    bool playing = false;
    bool deviceOpen = false;               ///< false: the device could not be opened
    ArrayState state = ArrayState::CLOSED; ///< state of the array when this was made
    HologramCounters counters;
    double updatesPerSecond = 0.0; ///< snapshots solved within the last second
    std::string deviceStatus;
    std::vector<std::string> messages; ///< for the user, all so far, each once
    std::vector<base::Message> told;   ///< the same, with their subjects

    /// The first field that the device plays, as m activations. Empty if there is no pipeline.
    const Eigen::VectorXcf& played() const;
    const haptics::SolveReport& report() const { return sequence.report; }
    /// True if there is a field but the array has no level to play it.
    bool isSilenced() const { return report().stop == haptics::StopReason::SILENCED; }
};

/// Counts how many snapshots were solved within the last second.
class UpdateRate
{
public:
    void count(double now_s) { _times_s.push_back(now_s); }
    /// Returns the number of count() calls within the second before \a now_s.
    double perSecond(double now_s);

private:
    std::deque<double> _times_s; // of the last second
};

/// Adds the counts of \a assembler for a snapshot, and a solver's report, to \a counters.
void count(const PointAssembler& assembler,
           const AssembledPoints& assembled,
           HologramCounters& counters);
void count(const haptics::SolveReport& report, HologramCounters& counters);

/// Sets the report's errors and levels from achieved_Pa. If there are foci, only contacts count,
/// because the targets of whole objects may be ratios and the pressure added by foci is no error.
void ratePlayed(HologramResult& result);

/// Replaces the fields in \a result by those that \a output plays (quantised, limited), and stores
/// the pressures at the points in achieved_Pa. Computes the report's level figures again if a
/// pressure or amplitude cap scaled the fields down, if they are evened out, and if the levels
/// leave nothing of them. Returns false if nothing should sound. \a known: a held field with known
/// pressures at the points; may be empty. \a isRated: false if they were solved for an array with
/// fewer reflectors, so that their figures are not those of \a array.
bool measurePlayed(const ArrayOutput& output,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium,
                   const haptics::SolverOptions& options,
                   const CappedField& known,
                   HologramResult& result,
                   bool isRated = true);

} // namespace midair::bridge
