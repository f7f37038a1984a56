#include "haptics/solvers/ManyStarts.h"

#include <algorithm>
#include <utility>

namespace midair::haptics
{

ManyStarts::ManyStarts(Make make, const SolverOptions& options, int starts) :
    _make(std::move(make)),
    _options(options),
    _starts(std::max(1, starts)),
    _first(this->make(0)) // so that an unknown method throws here
{
}

std::unique_ptr<HologramSolver> ManyStarts::make(int start) const
{
    SolverOptions options = _options;
    options.seed += static_cast<std::uint64_t>(start);
    return _make(options);
}

bool ManyStarts::isBetter(const SolveReport& a, const SolveReport& b, double tolerance)
{
    const double aError = std::max(a.rms, tolerance);
    const double bError = std::max(b.rms, tolerance);
    return aError != bError ? aError < bError : a.loudness > b.loudness;
}

// With crowded points a solve may end at its iteration limit, and the next one continues.
SolveReport ManyStarts::settle(HologramSolver& solver,
                               const ControlPoints& points,
                               const TransducerArray& array,
                               const Medium& medium,
                               Eigen::VectorXcf& q) const
{
    SolveReport best = solver.solve(points, array, medium, q);
    for (int again = 0; again < kMostAgain && best.stop == StopReason::MAX_ITERATIONS; ++again)
    {
        Eigen::VectorXcf field;
        SolveReport report = solver.solve(points, array, medium, field);
        report.matrix_ms += best.matrix_ms;
        report.solve_ms += best.solve_ms;
        const bool isField = report.stop != StopReason::STOPPED &&
                             report.stop != StopReason::SKIPPED &&
                             report.stop != StopReason::REFUSED;
        if (!isField || !isBetter(report, best, _options.rmsTolerance)) break;
        best = std::move(report);
        q = std::move(field);
    }
    return best;
}

SolveReport ManyStarts::solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q)
{
    if (_chosen) return settle(*_chosen, points, array, medium, q);
    SolveReport best;
    double matrix_ms = 0.0;
    double solve_ms = 0.0;
    for (int start = 0; start < _starts; ++start)
    {
        std::unique_ptr<HologramSolver> solver =
            start == 0 && _first ? std::move(_first) : make(start);
        Eigen::VectorXcf field;
        SolveReport report = settle(*solver, points, array, medium, field);
        matrix_ms += report.matrix_ms;
        solve_ms += report.solve_ms;
        // Without anything to solve no start is better than another.
        const bool isOver = report.stop == StopReason::NOTHING_TO_DO ||
                            report.stop == StopReason::REFUSED ||
                            report.stop == StopReason::STOPPED;
        if (isOver || start == 0 || isBetter(report, best, _options.rmsTolerance))
        {
            best = std::move(report);
            q = std::move(field);
            if (!isOver) _chosen = std::move(solver);
        }
        if (!isOver) continue;
        _chosen.reset(); // the next field is the first one
        break;
    }
    best.matrix_ms = matrix_ms;
    best.solve_ms = solve_ms;
    return best;
}

} // namespace midair::haptics
