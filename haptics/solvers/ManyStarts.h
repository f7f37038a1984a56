#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <functional>
#include <memory>

namespace midair::haptics
{

/// Solves the first field with several solvers of one method, with different seeds of random
/// phases, and continues with the best; later fields start from its last. A field that may improve
/// is solved again until it doesn't. For offline sequences of fields. Equal input gives equal
/// fields.
class ManyStarts final : public HologramSolver
{
public:
    using Make = std::function<std::unique_ptr<HologramSolver>(const SolverOptions&)>;

    /// Calls \a make \a starts (>= 1) times, with \a options and the seeds options.seed + 0, 1, ..,
    /// one after the other; passes on its exceptions.
    ManyStarts(Make make, const SolverOptions& options, int starts);

    /// The report is that of the chosen field; its times are those of all starts.
    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) override;

    const SolverOptions& options() const override { return _options; }

    /// Returns true if the figures \a a are better than \a b: a smaller rms error if one exceeds \a
    /// tolerance, otherwise louder.
    static bool isBetter(const SolveReport& a, const SolveReport& b, double tolerance);

    /// Maximum number of repeated solves of a field.
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
    std::unique_ptr<HologramSolver> _first;  ///< of the first start; null: already used
    std::unique_ptr<HologramSolver> _chosen; ///< null: no field was solved yet
};

} // namespace midair::haptics
