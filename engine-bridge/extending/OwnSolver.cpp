#include "engine-bridge/extending/OwnSolver.h"

#include "engine-bridge/extending/NamedFactories.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using namespace midair::haptics;
using midair::base::InputError;

NamedFactories<FieldMethodFactory>& registry()
{
    static NamedFactories<FieldMethodFactory> all("solver");
    return all;
}

/// Amplitudes above 1 by at most this are rounding errors, and count as 1.
constexpr float kRounding = 1e-5F;

using Matrix = Eigen::Matrix<std::complex<float>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Wraps an application's FieldMethod as a HologramSolver.
class OwnSolver : public HologramSolver
{
public:
    OwnSolver(std::string name,
              const std::shared_ptr<FieldMethod>& solver,
              const SolverOptions& options) :
        _name(std::move(name)),
        _solver(solver),
        _options(options)
    {
    }

    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) override
    {
        SolveReport report;
        report.solver = _name;
        report.points = points.size();
        report.transducers = array.size();
        q.setZero(array.size());
        const auto silent = [&](StopReason stop, const std::string& why)
        {
            q.setZero(array.size());
            _last.resize(0);
            report.stop = stop;
            report.message = why;
            return report;
        };
        std::string why = refusal(points, array, medium);
        if (!why.empty()) return silent(StopReason::REFUSED, why);
        keepWanted(points);
        if (_wanted.size() == 0) return silent(StopReason::NOTHING_TO_DO, "every target is 0");
        report.leftOut = points.size() - _wanted.size();
        const double start_ms = 1e3 * base::steadySeconds();
        build(array, medium);
        report.matrix_ms = 1e3 * base::steadySeconds() - start_ms;
        report.rowsBuilt = _wanted.size();
        why = ask(array, q);
        if (_options.stop.requested()) return silent(StopReason::STOPPED, "stopped");
        if (!why.empty())
            return silent(StopReason::REFUSED, "solver \"" + _name + "\" has failed: " + why);
        round(array.drive, q);
        rate(q, report);
        report.stop = StopReason::CONVERGED;
        report.solve_ms = 1e3 * base::steadySeconds() - start_ms - report.matrix_ms;
        return report;
    }
    const SolverOptions& options() const override { return _options; }

private:
    static std::string
    refusal(const ControlPoints& points, const TransducerArray& array, const Medium& medium)
    {
        std::string why;
        if (!medium.isValid(&why) || !array.isValid(&why)) return why;
        const auto entries =
            static_cast<std::size_t>(points.size()) * static_cast<std::size_t>(array.size());
        if (points.size() > base::kMostControlPoints || entries > base::kMostEntries)
            return fmt::format(
                "{} control points and {} transducers are more than can be solved for",
                points.size(),
                array.size());
        if (points.targets.size() != points.size() || !points.positions.allFinite() ||
            !points.targets.allFinite())
            return "the control points are not finite";
        if (points.outside_Pa.size() > 0 || points.outsideRows_Pa)
            return "outside pressures need a solver of the kit";
        return {};
    }
    void keepWanted(const ControlPoints& points)
    {
        std::vector<Eigen::Index> kept;
        for (Eigen::Index l = 0; l < points.size(); ++l)
            if (points.targets[l] > 0.0) kept.push_back(l);
        _wanted.positions = points.positions(Eigen::all, kept);
        _wanted.targets = points.targets(kept);
        _wanted.absolute = points.absolute;
    }
    void build(const TransducerArray& array, const Medium& medium)
    {
        _lanes.bind(array, medium);
        _lanes.build(_wanted.positions);
        _matrix.setZero(_wanted.size(), array.size()); // dead transducers have no column
        const auto unit_Pa = static_cast<float>(_lanes.unit_Pa());
        const std::vector<int>& order = _lanes.order();
        for (int l = 0; l < _wanted.size(); ++l)
            for (int lane = 0; lane < _lanes.transducers(); ++lane)
                if (!_lanes.isFiller(lane))
                    _matrix(l, order[static_cast<std::size_t>(lane)]) =
                        unit_Pa * _lanes.at(l, lane);
    }
    // Returns why there is no field; empty on success.
    std::string ask(const TransducerArray& array, Eigen::VectorXcf& q)
    {
        FieldMethod::Problem problem;
        problem.points = static_cast<unsigned int>(_wanted.size());
        problem.transducers = static_cast<unsigned int>(array.size());
        problem.positions = _wanted.positions.data();
        problem.targets = _wanted.targets.data();
        problem.isAbsolute = _wanted.absolute;
        problem.matrix = _matrix.data();
        problem.loudness = _options.loudness;
        problem.phaseOnly = _options.phaseOnly;
        problem.maxIterations = _options.maxIterations;
        problem.deadline_ms = _options.deadline_ms;
        problem.isStopped = [this] { return _options.stop.requested(); };
        std::string why;
        bool isSolved = false;
        const std::string thrown =
            base::thrownBy([&] { isSolved = _solver && _solver->solve(problem, q.data(), why); });
        if (!thrown.empty()) return "it has thrown " + thrown;
        if (!isSolved) return why.empty() ? "it found no field" : why;
        return check(q);
    }
    std::string check(Eigen::VectorXcf& q) const
    {
        for (Eigen::Index i = 0; i < q.size(); ++i)
        {
            const float amplitude = std::abs(q[i]);
            if (!(amplitude <= 1.0F + kRounding)) // also for NaN
                return fmt::format("its activation {} is {:g}{:+g}i; it must be finite and of an "
                                   "amplitude of at most 1",
                                   i,
                                   q[i].real(),
                                   q[i].imag());
            if (amplitude > 1.0F) q[i] /= amplitude;
        }
        return {};
    }
    static void round(const DriveResolution& drive, Eigen::VectorXcf& q)
    {
        const auto step =
            static_cast<float>(base::kTwoPi) / static_cast<float>(std::max(1, drive.phaseLevels));
        for (Eigen::Index i = 0; i < q.size(); ++i)
        {
            const float phase = std::arg(q[i]);
            q[i] = std::polar(playableAmplitude(drive.amplitudeLevels, std::abs(q[i])),
                              drive.phaseLevels > 0 ? step * std::round(phase / step) : phase);
        }
    }
    void rate(const Eigen::VectorXcf& q, SolveReport& report)
    {
        const Eigen::VectorXf achieved_Pa = (_matrix * q).cwiseAbs();
        rateLevel(_wanted, achieved_Pa, report);
        const double rowSum = _matrix.cwiseAbs().rowwise().sum().cast<double>().mean();
        const double largest = _wanted.targets.maxCoeff();
        if (rowSum > 0.0)
            report.loudness = loudnessOf(report.level_Pa / largest, _wanted.targets.norm(), rowSum);
        const double power = q.cast<std::complex<double>>().squaredNorm();
        if (_last.size() == q.size() && power > 0.0)
            report.driveChange = (q - _last).cast<std::complex<double>>().squaredNorm() / power;
        _last = q;
    }

    const std::string _name;
    const std::shared_ptr<FieldMethod> _solver;
    const SolverOptions _options;
    ControlPoints _wanted; ///< those with a target above 0
    PropagationMatrix _lanes;
    Matrix _matrix; ///< n x m, Pa, in the array's order
    Eigen::VectorXcf _last;
};

} // namespace

bool registerMethod(const std::string& name, FieldMethodFactory make, std::string& error)
{
    return registry().add(name, std::move(make), solverNames(), error);
}

std::vector<std::string> ownSolverNames()
{
    return registry().names();
}

bool isOwnSolver(const std::string& name)
{
    return registry().find(name) != nullptr;
}

std::unique_ptr<HologramSolver> makeAnySolver(const std::string& name, const SolverOptions& options)
{
    const FieldMethodFactory make = registry().find(name);
    if (make)
    {
        std::string why;
        if (!options.isValid(&why)) throw InputError(why);
        std::shared_ptr<FieldMethod> solver;
        why = base::thrownBy([&] { solver = make(); });
        if (!why.empty())
            throw InputError("solver \"" + name + "\": what makes it has thrown " + why);
        return std::make_unique<OwnSolver>(name, std::move(solver), options);
    }
    std::vector<std::string> known = solverNames();
    if (std::find(known.begin(), known.end(), name) == known.end())
    {
        for (const std::string& own : ownSolverNames())
            known.push_back(own);
        throw base::CodedError(
            base::MessageCode::SOLVER_UNKNOWN,
            fmt::format("unknown solver '{}'; known are {}", name, fmt::join(known, ", ")));
    }
    return makeSolver(name, options);
}

} // namespace midair::bridge
