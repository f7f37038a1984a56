#include "haptics/scattering/ScatteringSolver.h"

#include "haptics/sequence/FieldSequence.h"

#include <algorithm>
#include <utility>

namespace midair::haptics
{

namespace
{

constexpr double kProgress = 0.9; // ratio of errors below which another round is worth it

} // namespace

ScatteringSolver::ScatteringSolver(std::unique_ptr<HologramSolver> solver,
                                   std::shared_ptr<ScatteredField> truth,
                                   std::function<void(int round, double rms)> told,
                                   int rounds,
                                   bool hasOptics) :
    _solver(std::move(solver)),
    _truth(std::move(truth)),
    _told(std::move(told)),
    _rounds(rounds),
    _hasOptics(hasOptics)
{
}

SolveReport ScatteringSolver::solve(const ControlPoints& points,
                                    const TransducerArray& array,
                                    const Medium& medium,
                                    Eigen::VectorXcf& q)
{
    SolveReport refused;
    refused.solver = "scattering";
    refused.points = refused.leftOut = points.size();
    refused.transducers = array.size();
    q.setZero(array.size());
    try
    {
        refused.message = _truth->whyImpossible(points.positions);
        if (refused.message.empty()) return correct(points, array, medium, q);
        refused.stop = StopReason::REFUSED;
    }
    catch (const base::Stopped& stopped)
    {
        refused.message = stopped.what();
        refused.stop = StopReason::STOPPED;
    }
    q.setZero(array.size());
    return refused;
}

SolveReport ScatteringSolver::correct(const ControlPoints& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      Eigen::VectorXcf& q)
{
    ControlPoints now = points;
    now.outside_Pa.resize(0);
    now.outsideRows_Pa = nullptr;
    if (_hasOptics && now.size() > 0) now.outsideRows_Pa = _truth->optics_Pa(now.positions);
    SolveReport report = _solver->solve(now, array, medium, q), best;
    Eigen::VectorXcf bestDrive;
    double rms = 0.0, solve_ms = 0.0;
    for (int round = 0; report.level_Pa > 0.0; ++round)
    {
        solve_ms += report.solve_ms + report.matrix_ms;
        _truth->setDrive(q);
        const Eigen::VectorXcd p =
            _truth->free_Pa(now.positions) + _truth->scattered_Pa(now.positions);
        rateLevel(points, p.cwiseAbs().cast<float>(), report);
        if (_told) _told(round, report.rms);
        const bool isBetter = round == 0 || report.rms < rms;
        const bool isWorthMore = round == 0 || report.rms < kProgress * rms;
        if (isBetter)
        {
            best = report;
            bestDrive = q;
            rms = report.rms;
        }
        if (!isWorthMore || round == _rounds) break;
        now.outside_Pa = _truth->beyond_Pa(now.positions, array);
        if (now.outsideRows_Pa)
            now.outside_Pa -= (*now.outsideRows_Pa * q).cast<std::complex<double>>();
        report = _solver->solve(now, array, medium, q);
    }
    if (bestDrive.size() == 0) return report;
    q = bestDrive;
    best.solve_ms = solve_ms - best.matrix_ms;
    return best;
}

} // namespace midair::haptics
