#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/SolveReport.h"

#include <osgMidair/FieldSettings>

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

/// Options of a solver; isValid() names the first that is out of range. With targets in Pa, a
/// loudness above 1 counts as 1, and the report's message says so.
struct SolverOptions : SolverSettings
{
    /// Thread pool. Solvers that never run at the same time can share one. Null: the solver makes a
    /// pool of \a threads.
    std::shared_ptr<base::ThreadPool> pool;
    std::uint64_t seed = 1; ///< seed of random phases; equal seeds give equal fields
    bool warmStart = true;  ///< start from the last field
    /// true: gauss-newton rounds every field as thoroughly as a cold start, which takes longer; for
    /// offline fields
    bool thorough = false;
    /// >= 0, in wavelengths. Points that moved by at most this since their rows of G were built
    /// keep them. If no point moved farther, nothing else changed and the last field was finished,
    /// it stays and the solve is SKIPPED. Reports ignore the resulting error, see SOLVER.md,
    /// "Skipping". 0: every call solves.
    double skipTolerance = 1e-5;
    /// > 0; fields per second, only for the audible part of a change (SolveReport::audibleChange).
    double updateRate_Hz = 1000.0;
    /// Checked at each deadline check and between blocks of the matrix. After a stop request the
    /// solve returns within milliseconds with StopReason::STOPPED.
    base::StopToken stop;

    /// Returns false if a setting is out of range; \a error, if given, then names the setting, its
    /// value and the range.
    bool isValid(std::string* error = nullptr) const;
};

/// Computes activations for control points; keeps buffers and the last field between calls.
class HologramSolver
{
public:
    virtual ~HologramSolver() = default;

    /// Solves for \a points and sets \a q to m activations, |q_i| <= 1, on the levels of
    /// array.drive. With points.outside_Pa, \a q is also an input: the drive that these belong to.
    /// They are never NaN: problems that can't be solved, or that exceed Limits.h, are
    /// REFUSED with zero activations. Doesn't throw by itself. One call at a time; another thread
    /// can end it through SolverOptions::stop.
    virtual SolveReport solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q) = 0;

    virtual const SolverOptions& options() const = 0;

    /// Returns the solver's own copy of the array of the last solve(), valid until the next one;
    /// null (the default): it has none. Passed to the next solve(), it isn't compared with the
    /// copy, which takes longer than solving for one point. Its drive is that of the first solve()
    /// for this array.
    virtual const TransducerArray* ownArray() const { return nullptr; }

    /// Returns |p| of the last solve()'s q, Pa (n), within kAchievedError of sqrt(m) |q| P0 g / R,
    /// with the R of the nearest transducer and the largest gain g, and within 0.5 % of itself.
    /// Empty (the default) if not known that accurately for each point.
    virtual const Eigen::VectorXf& achieved_Pa() const;
    /// Above the error of rounding the entries of G to 16 bits (3.5e-5).
    static constexpr float kAchievedError = 5e-5f;

    /// Returns the multipliers c of the last field (n; 0 for points that were left out): its drive
    /// has nearly the phases of G* c (SOLVER.md, "Why q = z/|z|"). Empty (the default): unknown.
    virtual Eigen::VectorXcf multipliers() const { return {}; }
    /// Makes the next solve() of the same points start from the multipliers \a c (n) instead of
    /// those of the last field. Returns false, and changes nothing, if this solver can't (the
    /// default).
    virtual bool startFrom(const Eigen::VectorXcf& /*c*/) { return false; }

    /// Replaces the options between two calls of solve(); the next solve still starts from the last
    /// field. Returns false, and changes nothing, if this solver can't; callers then make a new
    /// one. Pool and stop token must be those of its construction.
    virtual bool setOptions(const SolverOptions& /*options*/) { return false; }
};

/// Returns the names that makeSolver() knows, the default first.
std::vector<std::string> solverNames();

/// Makes the solver named \a name. Throws InputError for an unknown name (with the known ones) and
/// for invalid options.
std::unique_ptr<HologramSolver> makeSolver(const std::string& name,
                                           const SolverOptions& options = {});

} // namespace midair::haptics
