#include "haptics/sequence/SpeckleCycle.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/PlainText.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace midair::haptics
{

namespace
{

constexpr int kInnerSteps =
    8; // of LevenbergMarquardt: the others' fields change anyway before the next sweep

} // namespace

bool SpeckleCycleOptions::isValid(std::string* error) const
{
    base::PlainStream text;
    if (sweeps < 0)
        text << "sweeps is " << sweeps << "; it must be at least 0";
    else if (corrections < 1)
        text << "corrections is " << corrections << "; it must be at least 1";
    else if (!(loudness > 0.0 && std::isfinite(loudness)))
        text << "loudness is " << loudness << "; it must be above 0";
    else
        return solverOptions.isValid(error);
    if (error != nullptr) *error = text.str();
    return false;
}

SpeckleCycle::SpeckleCycle(const SpeckleCycleOptions& options) :
    _options(options),
    _dense(options.solverOptions.pool
               ? options.solverOptions.pool
               : std::make_shared<base::ThreadPool>(std::max(options.solverOptions.threads, 1)),
           Storage::FLOAT,
           options.solverOptions.stop)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("field cycle: " + error);
    if (_options.solver.empty()) _options.solver = solverNames().front();
}

const SpeckleCycleReport& SpeckleCycle::solve(const std::vector<ControlPoints>& sets,
                                              const Eigen::Matrix3Xd& surface,
                                              const TransducerArray& array,
                                              const Medium& medium)
{
    const auto start = std::chrono::steady_clock::now();
    if (sets.empty())
        throw base::InputError(
            "field cycle: there are no sets of points; there must be at least one");
    _drive = array.drive;
    _report = {};
    _report.fields = static_cast<int>(sets.size());
    while (_solvers.size() < sets.size())
        _solvers.push_back(makeSolver(_options.solver, _options.solverOptions));
    _fields.resize(sets.size());
    _reports.clear();
    _order.resize(sets.size());
    std::iota(_order.begin(), _order.end(), 0);
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
        const SolveReport solved = _solvers[k]->solve(sets[k], array, medium, _fields[k]);
        _reports.push_back(solved);
        if (solved.stop == StopReason::REFUSED)
            throw base::InputError("field cycle: set " + std::to_string(k) + ": " + solved.message);
        if (solved.stop == StopReason::STOPPED) throw base::Stopped();
        _report.points += solved.points;
        _report.worstRms = std::max(_report.worstRms, solved.rms);
    }
    const int threads = _options.solverOptions.threads;
    const base::StopToken& stop = _options.solverOptions.stop;
    if (surface.cols() > 0)
    {
        const auto played = std::find_if(_fields.begin(),
                                         _fields.end(),
                                         [](const Eigen::VectorXcf& q) { return !q.isZero(0.0f); });
        const Eigen::VectorXcf& first = played == _fields.end() ? _fields[0] : *played;
        _report.alone =
            statisticsOf(meanRadiationPressure(surface, array, medium, {first}, 2.0, threads, stop),
                         Eigen::VectorXd());
        if (_options.sweeps > 0 && _report.alone.mean_Pa > 0.0) even(surface, array, medium);
    }
    if (_options.reorder) _order = orderFields(_fields);
    alignFields(_fields, _drive);
    if (surface.cols() > 0)
        _report.cycle =
            statisticsOf(meanRadiationPressure(surface, array, medium, _fields, 2.0, threads, stop),
                         Eigen::VectorXd());
    const CycleSteps steps = cycleSteps(_fields);
    _report.meanPhaseStep_rad = steps.meanPhaseStep_rad;
    _report.driveChange = steps.driveChange;
    _report.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return _report;
}

// Block coordinate descent on f = sum_l (1 - (1/K) sum_k |p_l^k|^2 / s^2)^2 K^2; phase-only.
void SpeckleCycle::even(const Eigen::Matrix3Xd& surface,
                        const TransducerArray& array,
                        const Medium& medium)
{
    ControlPoints points;
    points.positions = surface;
    points.targets = Eigen::VectorXd::Ones(surface.cols());
    std::vector<int> all(static_cast<std::size_t>(surface.cols()));
    std::iota(all.begin(), all.end(), 0);
    _dense.assign(points, all, array, medium, 0.0);
    _dense.build();

    const auto K = static_cast<float>(_fields.size());
    // A little more than must be had, since what is uneven lowers the mean.
    double goal = 1.03 * _options.loudness * _report.alone.mean_Pa / radiationPressure(1.0, medium);
    const double floor = goal / 1.03;
    LevenbergMarquardt::Limits limits;
    limits.corrections = _options.corrections;
    limits.innerSteps = kInnerSteps;
    std::vector<Eigen::VectorXf> squares(_fields.size(), Eigen::VectorXf::Zero(surface.cols()));
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(surface.cols());
    std::vector<std::size_t> sounding; // a set without points stays silent
    for (std::size_t k = 0; k < _fields.size(); ++k)
        if (!_fields[k].isZero(0.0f)) sounding.push_back(k);
    for (const std::size_t k : sounding)
    {
        setPhases(_dense, _fields[k]);
        _dense.forward(_dense.q, _dense.p);
        _dense.phasesOf(_dense.p);
        squares[k] = _dense.y.cwiseAbs2();
        sum += squares[k];
    }
    for (int sweep = 0; sweep < _options.sweeps; ++sweep)
    {
        for (const std::size_t k : sounding)
        {
            setPhases(_dense, _fields[k]);
            const Eigen::VectorXf given = Eigen::VectorXf::Constant(sum.size(), K - 1.0f) -
                                          (sum - squares[k]) / static_cast<float>(goal);
            _even.fit(_dense, std::sqrt(goal), given, limits);
            sum -= squares[k];
            squares[k] = _dense.y.cwiseAbs2();
            sum += squares[k];
            _fields[k] = sweep + 1 < _options.sweeps ? currentPhases(_dense) : playedPhases(_dense);
        }
        const double mean = static_cast<double>(sum.mean() / K);
        if (mean < floor) goal *= std::clamp(floor / std::max(mean, 1e-30), 1.0, 1.1);
    }
}

} // namespace midair::haptics
