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

/// What a solver is asked for; isValid() names the first setting that is out of its range.
struct SolverOptions
{
    int maxIterations = 0;      ///< >= 0; 0: the method's own default
    double rmsTolerance = 1e-3; ///< >= 0; a solve ends once the relative rms error is at most this
    /// >= 0, milliseconds from the call of solve(); a solve then ends with the best field so far.
    /// 0: no deadline.
    double deadline_ms = 0.0;
    double lambdaRel = 0.1; ///< >= 0; lambda = lambdaRel trace(K)/n, for the methods of Tikhonov
    /// True: targets are in Pa. False: only their ratios count, and the array plays as loud as it
    /// accurately can.
    bool absoluteTargets = false;
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
    /// >= 0; a transducer's phase turns by at most this from one field to the next. 0: by any angle.
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

/// Why a solve ended.
enum class StopReason
{
    NOTHING_TO_DO,  ///< there are no points, or none that can be reached
    CONVERGED,      ///< the error that was asked for is reached
    STALLED,        ///< the error no longer falls, or all of it comes from rounding
    MAX_ITERATIONS, ///< the options' or the method's limit of iterations is reached
    DEADLINE,       ///< the options' deadline has passed
    SKIPPED,        ///< nothing moved by more than the options' tolerance; the last field stays
    REFUSED,        ///< the input can't be solved; message says why; activations are zero
    STOPPED         ///< the options' token asked for it; activations are zero, the next start cold
};

/// A reason as text: "nothing to do", "converged", "iteration limit" and so on.
const char* stopReasonName(StopReason reason);

/// What was solved and how well, for q as the device plays it (clipped and rounded to its levels).
/// Symbols: y = |G q| at the points, a their targets, s = (y.a)/(a.a) the fitted level.
struct SolveReport
{
    std::string solver; ///< the method's name
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< what the user should know; empty: nothing
    int points = 0;      ///< as given, those that were left out among them
    int transducers = 0;
    int iterations = 0;
    /// sqrt(mean((y_l/(s a_l) - 1)^2)); with targets in Pa s = 1. 0.01: one percent.
    double rms = 0.0;
    double max = 0.0; ///< the largest |y_l/(s a_l) - 1|
    /// E = s |a| / mean_l(sum_i |G_li|): 1 is as loud as one focus's energy, shared among the
    /// points.
    double loudness = 0.0;
    double level_Pa = 0.0;          ///< peak pressure that is played where the target is largest
    double matrix_ms = 0.0;         ///< to build G
    double solve_ms = 0.0;          ///< for all the rest
    int rowsBuilt = 0;              ///< rows of G that were computed anew; the others had not moved
    int leftOut = 0;                ///< points with target 0, or that no transducer reaches
    int shortPoints = 0;            ///< targets in Pa: points that fall short by more than 1 %
    double worstShortfall = 0.0;    ///< targets in Pa: the largest 1 - y_l/a_l; 0: none falls short
    double meanPhaseStep_rad = 0.0; ///< mean |change of a transducer's phase| from the last field
    /// sum_i |q_i - q_i before|^2 / sum_i |q_i|^2: the energy of the drive's change. 0 for the first
    /// field.
    double driveChange = 0.0;
    /// The part of driveChange that lies from 20 Hz to 20 kHz beside the carrier at the options'
    /// updateRate_Hz (audibleShare()).
    double audibleChange = 0.0;
    /// What a hand would find between the points. Filled by the caller with surfaceStatistics(),
    /// which takes the time of many solves; in a live scene it belongs to the newest field that was
    /// measured. samples == 0: not measured.
    SurfaceStatistics surface;
};

/// Takes control points and returns activations; holds its buffers and the last field between calls.
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

/// Makes the solver of that name. Throws InputError for an unknown name (listing the known ones) and
/// for options that are not valid.
std::unique_ptr<HologramSolver> makeSolver(const std::string& name,
                                           const SolverOptions& options = {});

} // namespace midair::haptics
