#pragma once

#include "haptics/scattering/ScatteredField.h"
#include "haptics/solvers/HologramSolver.h"

#include <functional>
#include <memory>

namespace midair::haptics
{

/// A solver for fields at rest that corrects another's for things in the field: it hands over what
/// the true field of the last drive has and the rows of that solver have not, as outside pressures
/// (ControlPoints), and solves again. Reflectors of the array that stand for things, as images, and
/// physical optics of bodies (Scatterer::optics()) are in the rows, so that the rest is small.
class ScatteringSolver final : public HologramSolver
{
public:
    static constexpr int kRounds = 4; ///< corrections, at most

    /// \a truth: shared with the caller, who doesn't use it while this solves. \a told, if given,
    /// is called with the true rms error of the drive after each round, first of the one that the
    /// rows alone give. \a hasOptics: false leaves optics out of them.
    ScatteringSolver(std::unique_ptr<HologramSolver> solver,
                     std::shared_ptr<ScatteredField> truth,
                     std::function<void(int round, double rms)> told = {},
                     int rounds = kRounds,
                     bool hasOptics = true);

    /// Returns the best drive of all rounds; errors and level in the report are those of the true
    /// field. Ends early once a round doesn't lower the error by a tenth. REFUSED for points inside
    /// a thing.
    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) override;
    const SolverOptions& options() const override { return _solver->options(); }

private:
    SolveReport correct(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        Eigen::VectorXcf& q);

    std::unique_ptr<HologramSolver> _solver;
    std::shared_ptr<ScatteredField> _truth;
    std::function<void(int round, double rms)> _told;
    int _rounds;
    bool _hasOptics;
};

} // namespace midair::haptics
