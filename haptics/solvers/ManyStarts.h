#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <functional>
#include <memory>

namespace midair::haptics
{

/// Solves its first field with several solvers of one method, whose random phases have different
/// seeds, and goes on with the one whose field is best; the following fields start from its last.
/// A field that could become better is solved for again, until it doesn't.
/// For sequences of fields that nobody waits for. The same input gives the same fields.
class ManyStarts final : public HologramSolver
{
public:
    using Make = std::function<std::unique_ptr<HologramSolver>(const SolverOptions&)>;

    /// \a make is called \a starts (>= 1) times, with \a options and the seeds options.seed + 0, 1,
    /// .., one after the other; what it throws gets through.
    ManyStarts(Make make, const SolverOptions& options, int starts);

    /// The report is that of the field that was chosen; its times are those of all starts.
    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) override;

    const SolverOptions& options() const override { return _options; }

    /// Returns true if a field with the figures of \a a is better than one with those of \a b: its
    /// rms error is less, where one exceeds \a tolerance, else it is louder.
    static bool isBetter(const SolveReport& a, const SolveReport& b, double tolerance);

    /// Most times that a field is solved for again.
    static constexpr int kMostAgain = 8;

private:
    std::unique_ptr<HologramSolver> make(int start) const;
    SolveReport settle(HologramSolver& solver,
                       const ControlPoints& points,
                       const TransducerArray& array,
                       const Medium& medium,
                       Eigen::VectorXcf& q) const;

    const Make _make;
    const SolverOptions _options;
    const int _starts;
    std::unique_ptr<HologramSolver> _first;  ///< of the first start; null: it was used
    std::unique_ptr<HologramSolver> _chosen; ///< null: no field was solved for yet
};

} // namespace midair::haptics
