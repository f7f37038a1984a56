#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/SolveReport.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::base
{
class ThreadPool;
}

namespace midair::haptics
{

/// Settings of a solver; isValid() names the first one that is out of range.
struct SolverOptions
{
    int maxIterations = 0;      ///< >= 0; 0: the method's default
    double rmsTolerance = 1e-3; ///< >= 0; relative rms error at which a solve ends
    /// >= 0, milliseconds from the call of solve(); the solve then ends with the best field so far.
    /// 0: no deadline.
    double deadline_ms = 0.0;
    /// >= 0; Tikhonov regularisation lambda = lambdaRel trace(K)/n, for the methods that use it
    double lambdaRel = 0.1;
    /// Above 0, up to 2. 1: as loud as the field stays accurate. Below 1: this share of that. Above
    /// 1: louder and less accurate; the targets are shifted by loudness - 1 of the way to the
    /// pressures of the loudest field nearby. With targets in Pa, a loudness above 1 counts as 1,
    /// and the report's message says so.
    double loudness = 1.0;
    /// True: all transducers play one amplitude, and only their phases are solved for. False: their
    /// amplitudes are solved for as well.
    bool phaseOnly = true;
    int threads = 1; ///< 1 .. 256; more threads than the machine has cores are slower
    /// Threads to run on. Solvers that never run at the same time can share one pool. Null: the
    /// solver makes a pool of \a threads.
    std::shared_ptr<base::ThreadPool> pool;
    std::uint64_t seed = 1; ///< seed of random phases; the same seed gives the same fields
    bool warmStart = true;  ///< start from the last field
    /// >= 0, in wavelengths. Points that moved by no more than this keep their rows of G. If no
    /// point moved farther and nothing else changed, the last field stays and the solve is SKIPPED.
    /// 0: every call solves.
    double skipTolerance = 0.01;
    /// >= 0; a transducer's phase turns by at most this from one field to the next. 0: by any
    /// angle.
    double maxPhaseStep_rad = 0.0;
    /// 0 .. 1; a transducer's amplitude changes by at most this from one field to the next. 0: by
    /// any amount.
    double maxAmplitudeStep = 0.0;
    /// > 0; fields per second. Used only for the audible part of a change
    /// (SolveReport::audibleChange).
    double updateRate_Hz = 1000.0;
    /// Checked at each deadline check and between blocks of the matrix. After a stop request the
    /// solve returns within milliseconds with StopReason::STOPPED.
    base::StopToken stop;

    /// Returns false if a setting is out of range; \a error, if given, then names the setting, its
    /// value and the range.
    bool isValid(std::string* error = nullptr) const;
};

/// Computes activations for control points; keeps its buffers and the last field between calls.
class HologramSolver
{
public:
    virtual ~HologramSolver() = default;

    /// Solves for \a points and sets \a q to m activations, |q_i| <= 1, on the levels of
    /// array.drive. They are never NaN: problems that can't be solved, or that exceed Limits.h, are
    /// REFUSED with zero activations. Throws nothing of its own. One call at a time; another thread
    /// can end it through SolverOptions::stop.
    virtual SolveReport solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q) = 0;

    virtual const SolverOptions& options() const = 0;
};

/// Returns the names that makeSolver() knows, the default first.
std::vector<std::string> solverNames();

/// Makes the solver with the name \a name. Throws InputError for an unknown name (with a list of
/// the known ones) and for options that are not valid.
std::unique_ptr<HologramSolver> makeSolver(const std::string& name,
                                           const SolverOptions& options = {});

} // namespace midair::haptics
