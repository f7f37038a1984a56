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

/// What a solver is asked for; isValid() names the first violated constraint.
struct SolverOptions
{
    int maxIterations = 0;      ///< >= 0; 0: the method's own default
    double rmsTolerance = 1e-3; ///< >= 0; stop once the relative rms error is at most this
    double deadline_ms = 0.0;   ///< >= 0; 0: none; else the best field within this time
    double lambdaRel = 0.1;     ///< >= 0; lambda = lambdaRel trace(K)/n (Tikhonov)
    /// Over 0, up to 2. 1: as loud as it accurately can; below, that share of it; above, louder at the price of error:
    /// targets bent by loudness - 1 of the way to the pressures of the loudest field nearby. Taken as 1 at most with absolute targets.
    double loudness = 1.0;
    bool phaseOnly =
        true;        ///< every transducer at one amplitude; false: amplitudes are solved for too
    int threads = 1; ///< 1 .. 256; more than the machine has cores are slower, not faster
    /// Threads that solvers share which never run at the same time, in place of threads of their own; null: their own.
    std::shared_ptr<base::ThreadPool> pool;
    std::uint64_t seed = 1;
    bool warmStart = true; ///< start from the last field where the points correspond
    /// >= 0, in wavelengths: points that moved by no more keep their rows of G; when none moved further, and nothing else
    /// changed, nothing is solved and the last field stays. 0: every call solves.
    double skipTolerance = 0.01;
    double maxPhaseStep_rad =
        0.0; ///< >= 0; most that a transducer's phase may turn in an update; 0: any
    double maxAmplitudeStep = 0.0; ///< 0 .. 1; the same for its amplitude; 0: any
    /// > 0; at which fields follow each other: what of a change is audible hangs on it.
    double updateRate_Hz = 1000.0;
    /// Looked at wherever the deadline is, and between blocks of the matrix: a solve that is asked to stop is back within
    /// milliseconds, STOPPED.
    base::StopToken stop;

    bool isValid(std::string* error = nullptr) const;
};

/// Control points in, activations out; holds its buffers and the last field between calls.
class HologramSolver
{
public:
    virtual ~HologramSolver() = default;

    /// Solves for \a points and leaves m activations in \a q, |q_i| <= 1, as array.drive can play them. Never NaN:
    /// what can't be solved is REFUSED with zero activations, more points than Limits.h has room for too. One thread at a
    /// time; another one breaks it off by SolverOptions::stop.
    virtual SolveReport solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q) = 0;

    virtual const SolverOptions& options() const = 0;
};

/// Names that makeSolver knows, the default first.
std::vector<std::string> solverNames();

/// Throws InputError for an unknown name (listing the known ones) and for options that are not valid.
std::unique_ptr<HologramSolver> makeSolver(const std::string& name,
                                           const SolverOptions& options = {});

} // namespace midair::haptics
