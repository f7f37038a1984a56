#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/SurfaceStatistics.h"

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
    bool absoluteTargets =
        false; ///< targets are in Pa; else only their ratios count and the array plays as loud as it accurately can
    /// Over 0, up to 2. 1: as loud as it accurately can; below, that share of it; above, louder at the price of error:
    /// targets bent by loudness - 1 of the way to the pressures of the loudest field nearby. Not above 1 with absolute targets.
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

enum class StopReason
{
    NOTHING_TO_DO, ///< no points, or none that can be reached
    CONVERGED,     ///< the error asked for is reached
    STALLED,       ///< no longer improving
    MAX_ITERATIONS,
    DEADLINE,
    SKIPPED, ///< nothing moved by more than the tolerance
    REFUSED, ///< the input is not solvable; message says why; activations are zero
    STOPPED ///< SolverOptions::stop asked for it; activations are zero, the next solve starts from nothing
};

const char* stopReasonName(StopReason reason);

/// What was solved and how well, for q as the device plays it (clipped, quantised).
struct SolveReport
{
    std::string solver;
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< empty, or what the user should know
    int points = 0;
    int transducers = 0;
    int iterations = 0;
    double rms =
        0.0; ///< sqrt(mean((y_l/(s a_l) - 1)^2)), s = (y.a)/(a.a); with absolute targets s = 1
    double max = 0.0;      ///< the largest of the same
    double loudness = 0.0; ///< E = s |a| / mean_l(sum_i |G_li|)
    double level_Pa =
        0.0; ///< s times the largest target: the pressure played where the target is largest
    double matrix_ms = 0.0;
    double solve_ms = 0.0;
    int rowsBuilt = 0;   ///< rows of G that were computed anew; the others had not moved
    int leftOut = 0;     ///< points with target 0, or that no transducer reaches
    int shortPoints = 0; ///< absolute targets: points that fall short by more than 1 %
    double worstShortfall =
        0.0; ///< absolute targets: the largest 1 - y_l/a_l, 0 if none falls short
    double meanPhaseStep_rad =
        0.0; ///< mean |change of phase| of the transducers from the field before
    /// sum_i |q_i - q_i before|^2 / sum_i |q_i|^2: the energy of the drive's change; 0 for the first field.
    double driveChange = 0.0;
    /// Of that, what lies from 20 Hz to 20 kHz beside the carrier at the options' updateRate_Hz: see audibleShare().
    double audibleChange = 0.0;
    /// What a hand would find between the points: filled by whoever knows the surface that they stand for
    /// (surfaceStatistics()), since that takes many solves' time; of a live scene that of the newest field that was looked
    /// at. samples == 0: none.
    SurfaceStatistics surface;
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
