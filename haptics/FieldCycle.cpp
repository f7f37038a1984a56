#include "haptics/FieldCycle.h"

#include "haptics/InputError.h"
#include "haptics/PressureField.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <sstream>

namespace midair::haptics
{

namespace
{

constexpr double kPi = 3.14159265358979323846;
constexpr int kInnerSteps =
    8; // of EvenField: the others' fields change anyway before the next sweep

float onLevel(float angle, int levels)
{
    if (levels <= 0) return angle;
    const float step = static_cast<float>(2.0 * kPi) / static_cast<float>(levels);
    return step * std::round(angle / step);
}

} // namespace

bool FieldCycleOptions::isValid(std::string* error) const
{
    std::ostringstream text;
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

CycleSteps cycleSteps(const std::vector<Eigen::VectorXcf>& cycle)
{
    CycleSteps steps;
    double power = 0.0;
    for (std::size_t k = 0; k < cycle.size(); ++k)
    {
        const Eigen::VectorXcf& from = cycle[k];
        const Eigen::VectorXcf& to = cycle[(k + 1) % cycle.size()];
        for (Eigen::Index i = 0; i < from.size(); ++i)
        {
            const double step = std::fabs(std::arg(to[i] * std::conj(from[i])));
            steps.meanPhaseStep_rad += step / static_cast<double>(from.size() * cycle.size());
            steps.largestPhaseStep_rad = std::max(steps.largestPhaseStep_rad, step);
        }
        steps.driveChange += (to - from).squaredNorm();
        power += to.squaredNorm();
    }
    steps.driveChange = power > 0.0 ? steps.driveChange / power : 0.0;
    return steps;
}

FieldCycle::FieldCycle(const FieldCycleOptions& options) :
    _options(options),
    _dense(std::max(options.solverOptions.threads, 1))
{
    std::string error;
    if (!options.isValid(&error)) throw InputError("field cycle: " + error);
    if (_options.solver.empty()) _options.solver = solverNames().front();
}

const FieldCycleReport& FieldCycle::solve(const std::vector<ControlPoints>& sets,
                                          const Eigen::Matrix3Xd& surface,
                                          const TransducerArray& array,
                                          const Medium& medium)
{
    const auto start = std::chrono::steady_clock::now();
    if (sets.empty())
        throw InputError("field cycle: there are no sets of points; there must be at least one");
    _drive = array.drive;
    _report = {};
    _report.fields = static_cast<int>(sets.size());
    while (_solvers.size() < sets.size())
        _solvers.push_back(makeSolver(_options.solver, _options.solverOptions));
    _fields.resize(sets.size());
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
        const SolveReport solved = _solvers[k]->solve(sets[k], array, medium, _fields[k]);
        if (solved.stop == StopReason::REFUSED)
            throw InputError("field cycle: set " + std::to_string(k) + ": " + solved.message);
        _report.points += solved.points;
        _report.worstRms = std::max(_report.worstRms, solved.rms);
    }
    const int threads = _options.solverOptions.threads;
    if (surface.cols() > 0)
    {
        _report.alone =
            statisticsOf(meanRadiationPressure(surface, array, medium, {_fields[0]}, 2.0, threads),
                         Eigen::VectorXd());
        if (_options.sweeps > 0) even(surface, array, medium);
    }
    if (_options.reorder) order();
    align();
    if (surface.cols() > 0)
        _report.cycle =
            statisticsOf(meanRadiationPressure(surface, array, medium, _fields, 2.0, threads),
                         Eigen::VectorXd());
    const CycleSteps steps = cycleSteps(_fields);
    _report.meanPhaseStep_rad = steps.meanPhaseStep_rad;
    _report.driveChange = steps.driveChange;
    _report.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return _report;
}

// Block coordinate descent on f = sum_l (1 - (1/K) sum_k |p_l^k|^2 / s^2)^2 K^2; phase-only.
void FieldCycle::even(const Eigen::Matrix3Xd& surface,
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
    EvenField::Limits limits;
    limits.corrections = _options.corrections;
    limits.innerSteps = kInnerSteps;
    std::vector<Eigen::VectorXf> squares(_fields.size());
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(surface.cols());
    for (std::size_t k = 0; k < _fields.size(); ++k)
    {
        setPhases(_dense, _fields[k]);
        _dense.forward(_dense.q, _dense.p);
        _dense.phasesOf(_dense.p);
        squares[k] = _dense.y.cwiseAbs2();
        sum += squares[k];
    }
    for (int sweep = 0; sweep < _options.sweeps; ++sweep)
    {
        for (std::size_t k = 0; k < _fields.size(); ++k)
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

// Nearest neighbour from the first field on, then 2-opt: both by |<q_k, q_l>|, which a common phase leaves alone.
void FieldCycle::order()
{
    const std::size_t K = _fields.size();
    if (K < 4) return; // of three every order is the same cycle
    Eigen::MatrixXd near(K, K);
    for (std::size_t k = 0; k < K; ++k)
        for (std::size_t l = 0; l < K; ++l)
            near(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) =
                std::abs(_fields[k].dot(_fields[l]));
    const auto at = [&near](std::size_t k, std::size_t l)
    { return near(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)); };
    std::vector<std::size_t> way(K);
    std::iota(way.begin(), way.end(), std::size_t(0));
    for (std::size_t k = 1; k + 1 < K; ++k)
        for (std::size_t l = k + 1; l < K; ++l)
            if (at(way[k - 1], way[l]) > at(way[k - 1], way[k])) std::swap(way[k], way[l]);
    for (bool changed = true; changed;)
    {
        changed = false;
        for (std::size_t k = 1; k + 1 < K; ++k)
            for (std::size_t l = k + 1; l < K; ++l)
            {
                const std::size_t before = way[k - 1], after = way[(l + 1) % K];
                const double gain =
                    at(before, way[l]) + at(way[k], after) - at(before, way[k]) - at(way[l], after);
                if (!(gain > 1e-6 * near(0, 0))) continue;
                std::reverse(way.begin() + static_cast<std::ptrdiff_t>(k),
                             way.begin() + static_cast<std::ptrdiff_t>(l) + 1);
                changed = true;
            }
    }
    std::vector<Eigen::VectorXcf> ordered(K);
    for (std::size_t k = 0; k < K; ++k)
        ordered[k].swap(_fields[way[k]]);
    _fields.swap(ordered);
}

// A field's common phase can't be felt: each takes that which leaves the least change from the one before, and what is
// left between the last and the first is spread over all. Turns by whole levels keep a field playable.
void FieldCycle::align()
{
    const std::size_t K = _fields.size();
    if (K < 2) return;
    for (std::size_t k = 1; k < K; ++k)
    {
        const float angle = std::arg(_fields[k].dot(_fields[k - 1]));
        _fields[k] *= std::polar(1.0f, onLevel(angle, _drive.phaseLevels));
    }
    const float left = std::arg(_fields[0].dot(_fields[K - 1])); // ahead of the first by this
    for (std::size_t k = 1; k < K; ++k)
    {
        const float share = -left * static_cast<float>(k) / static_cast<float>(K);
        _fields[k] *= std::polar(1.0f, onLevel(share, _drive.phaseLevels));
    }
}

std::vector<Eigen::VectorXcf> FieldCycle::smoothed(int steps) const
{
    std::vector<Eigen::VectorXcf> result;
    if (steps < 0)
        throw InputError("field cycle: " + std::to_string(steps) +
                         " steps between fields; there must be at least 0");
    for (std::size_t k = 0; k < _fields.size(); ++k)
    {
        const Eigen::VectorXcf& from = _fields[k];
        const Eigen::VectorXcf& to = _fields[(k + 1) % _fields.size()];
        result.push_back(from);
        for (int s = 1; s <= steps && _fields.size() > 1; ++s)
        {
            const float share = static_cast<float>(s) / static_cast<float>(steps + 1);
            Eigen::VectorXcf between(from.size());
            for (Eigen::Index i = 0; i < from.size(); ++i)
            {
                const float amplitude =
                    (1.0f - share) * std::abs(from[i]) + share * std::abs(to[i]);
                const float angle =
                    std::arg(from[i]) + share * std::arg(to[i] * std::conj(from[i]));
                between[i] = std::polar(playableAmplitude(_drive.amplitudeLevels, amplitude),
                                        onLevel(angle, _drive.phaseLevels));
            }
            result.push_back(std::move(between));
        }
    }
    return result;
}

} // namespace midair::haptics
