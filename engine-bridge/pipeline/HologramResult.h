#pragma once

#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"

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
    std::uint64_t frame = 0; ///< of the snapshot it was solved for
    double latency_ms = 0.0; ///< from SceneSnapshot::time_s until the field was handed over
    /// The fields as the device plays them, with the parts and the report of what was solved; one
    /// silent field if there is nothing to play, no fields if there is no pipeline.
    haptics::FieldSequence sequence;
    haptics::ControlPoints points; ///< of the sequence, array frame
    /// 3 x k, array frame: points that were left out (workspace, spacing, budget, reach).
    Eigen::Matrix3Xd skipped;
    Eigen::VectorXf achieved_Pa; ///< n, |p| at each point in the field that is for it, as played
    /// True if the field is one stationary field for dense points along outlines.
    bool outline = false;
    /// Certificate and surface figures of the newest field that the monitor measured; null: none
    /// yet.
    std::shared_ptr<const haptics::FieldMonitor::Result> monitored;
    double maxPressure_Pa = 0.0; ///< cap at the control points, peak; 0: none
    /// True if the device took the field, if no device is open, or if there is nothing to play.
    bool playing = false;
    HologramCounters counters;
    double updatesPerSecond = 0.0; ///< snapshots solved within the last second
    std::string deviceStatus;
    std::vector<std::string> messages; ///< for the user, all so far, each once

    /// The first field that the device plays, as m activations. Empty if there is no pipeline.
    const Eigen::VectorXcf& played() const;
    const haptics::SolveReport& report() const { return sequence.report; }
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
/// pressure at the points into achieved_Pa, and if a cap scaled the fields down, computes the
/// report's level figures again.
void measurePlayed(const ArrayOutput& output,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium,
                   const haptics::SolverOptions& options,
                   HologramResult& result);

} // namespace midair::bridge
