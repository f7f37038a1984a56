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

/// What a solver is asked for; isValid() names the first setting that is out of its range.
struct SolverOptions
{
    int maxIterations = 0;      ///< >= 0; 0: the method's own default
    double rmsTolerance = 1e-3; ///< >= 0; a solve ends once the relative rms error is at most this
    /// >= 0, milliseconds from the call of solve(); a solve then ends with the best field so far.
    /// 0: no deadline.
    double deadline_ms = 0.0;
    double lambdaRel = 0.1; ///< >= 0; lambda = lambdaRel trace(K)/n, for the methods of Tikhonov
    /// Over 0, up to 2. 1: as loud as is accurate. Below 1: this share of that. Above 1: louder and
    /// less accurate, with the targets bent by loudness - 1 of the way to the pressures of the
    /// loudest field nearby. Targets in Pa say by themselves how loud they are: with them a
    /// loudness above 1 counts as 1, and the report's message says so.
    double loudness = 1.0;
    /// True: all transducers play one amplitude, and only their phases are solved for. False: their
    /// amplitudes are solved for as well.
    bool phaseOnly = true;
    int threads = 1; ///< 1 .. 256; more than the machine has cores are slower, not faster
    /// Threads to run on in place of the solver's own. Solvers that never run at the same time can
    /// share one pool. Null: the solver makes a pool of \a threads.
    std::shared_ptr<base::ThreadPool> pool;
    std::uint64_t seed = 1; ///< of the starting phases; the same seed gives the same fields
    bool warmStart = true;  ///< start from the last field where the points correspond to its own
    /// >= 0, in wavelengths. Points that moved by no more keep their rows of G. Where none moved
    /// further and nothing else changed, the last field stays and the solve is SKIPPED. 0: every
    /// call solves.
    double skipTolerance = 0.01;
    /// >= 0; a transducer's phase turns by at most this from one field to the next. 0: by any
    /// angle.
    double maxPhaseStep_rad = 0.0;
    /// 0 .. 1; a transducer's amplitude changes by at most this from one field to the next. 0: by
    /// any amount.
    double maxAmplitudeStep = 0.0;
    /// > 0; the rate at which fields follow one another. It decides how much of a change is audible
    /// (SolveReport::audibleChange), and nothing else.
    double updateRate_Hz = 1000.0;
    /// Asked wherever the deadline is, and between blocks of the matrix. A solve that is asked to
    /// stop returns within milliseconds with StopReason::STOPPED.
    base::StopToken stop;

    /// False where a setting is out of its range; \a error, if given, then names the setting, its
    /// value and the range.
    bool isValid(std::string* error = nullptr) const;
};

/// Takes control points and returns activations; holds its buffers and the last field between
/// calls.
class HologramSolver
{
public:
    virtual ~HologramSolver() = default;

    /// Solves for \a points and leaves m activations in \a q, |q_i| <= 1, as array.drive can play
    /// them. They are never NaN: what can't be solved is REFUSED with zero activations, more points
    /// than Limits.h has room for too. Throws nothing of its own. One thread at a time; another
    /// thread breaks a solve off through SolverOptions::stop.
    virtual SolveReport solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q) = 0;

    virtual const SolverOptions& options() const = 0;
};

/// The names that makeSolver() knows, the default first.
std::vector<std::string> solverNames();

/// Makes the solver of that name. Throws InputError for an unknown name (listing the known ones)
/// and for options that are not valid.
std::unique_ptr<HologramSolver> makeSolver(const std::string& name,
                                           const SolverOptions& options = {});

} // namespace midair::haptics
