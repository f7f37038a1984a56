#pragma once

#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// What has been done and what was spared since the thread started.
struct HologramCounters
{
    std::uint64_t snapshots = 0;  ///< submitted
    std::uint64_t superseded = 0; ///< replaced by a newer one before they were looked at
    std::uint64_t solves = 0;
    std::uint64_t skippedUnmoved = 0; ///< nothing moved: nothing solved
    std::uint64_t rowsBuilt = 0;      ///< of the propagation matrix: points that came or moved
    std::uint64_t rowsKept = 0;       ///< points that had not moved: theirs were there
    std::uint64_t sampled = 0;        ///< meshes sampled (a cached mesh is not sampled again)
    std::uint64_t followed = 0;   ///< meshes whose points went along with their vertices, unsampled
    std::uint64_t overBudget = 0; ///< points left out because there were too many
    std::uint64_t outOfWorkspace =
        0;                        ///< points or objects left out because the array can't reach them
    std::uint64_t crowded = 0;    ///< points left out because another one was too near
    std::uint64_t unpainted = 0;  ///< points left out because their paint is of intensity 0
    std::uint64_t outOfReach = 0; ///< points left out because no hand was near them
    std::uint64_t capped = 0;     ///< fields played at less, to keep to the cap of pressure
    std::uint64_t resent =
        0; ///< fields sent again since the device had lost them, nothing having moved
};

/// One solved field, handed back to the overlays, the HUD and the report; immutable.
struct HologramResult
{
    std::uint64_t frame = 0; ///< of the snapshot it was solved for
    double latency_ms = 0.0; ///< from the snapshot's stamp to the drive signal
    /// As the device plays it, with the parts and the report of what was solved; a silent field
    /// where there is nothing to play, none where nothing is open.
    haptics::FieldSequence sequence;
    haptics::ControlPoints points; ///< of the sequence, array frame
    /// 3 x k, array frame: points that were left out (workspace, spacing, budget, reach).
    Eigen::Matrix3Xd skipped;
    Eigen::VectorXf achieved_Pa; ///< n, |p| at points, each in the field that is for it, as played
    bool outline = false; ///< dense points along curves, in one stationary field without ripples
    /// Certificate and surface figures of the newest field that was looked at beside the solver;
    /// null: none yet.
    std::shared_ptr<const haptics::FieldMonitor::Result> monitored;
    double maxPressure_Pa = 0.0; ///< cap at the control points, peak; 0: none
    bool playing = false; ///< the device took the field; or there is none, or nothing to play
    HologramCounters counters;
    double updatesPerSecond = 0.0;
    std::string deviceStatus;
    std::vector<std::string> messages; ///< what the user should know, each said once

    /// m activations, what the device plays; of fields in turn the first. Empty where nothing is
    /// open.
    const Eigen::VectorXcf& played() const;
    const haptics::SolveReport& report() const { return sequence.report; }
};

/// How many fields were solved in the last second.
class UpdateRate
{
public:
    void count(double now_s) { _times_s.push_back(now_s); }
    double perSecond(double now_s);

private:
    std::deque<double> _times_s; // of the last second
};

/// Adds what \a assembler made of a snapshot, and what a solver reports, to \a counters.
void count(const PointAssembler& assembler,
           const AssembledPoints& assembled,
           HologramCounters& counters);
void count(const haptics::SolveReport& report, HologramCounters& counters);

/// Puts the fields as \a output plays them in place of those that it was given, measures what they
/// achieve at the points, and rates anew what a cap took down.
void measurePlayed(const ArrayOutput& output,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium,
                   const haptics::SolverOptions& options,
                   HologramResult& result);

} // namespace midair::bridge
