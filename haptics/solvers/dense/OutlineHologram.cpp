#include "haptics/solvers/dense/OutlineHologram.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// haptics/SOLVER.md, "Dense points", explains these.
// Distance in wavelengths between the samples for judging a field.
constexpr double kJudgeSpacing = 0.1;
// Corrections per start before the finalists are chosen.
constexpr int kFirstCorrections = 5;
// Rounds of projections of a warm start from the last field.
constexpr int kWarmRounds = 3;
// Maximum number of raises of the requested pressure, until the mean is loud enough.
constexpr int kRaises = 6;
// Corrections after each raise.
constexpr int kRaiseCorrections = 15;
// Requested mean over required mean; equalising lowers the mean.
constexpr double kHeadroom = 1.03;
// Share of its own mean requested from a field that exceeds the required mean.
constexpr double kOwnShare = 0.97;
// Weight of the missing mean relative to the unevenness.
constexpr double kWeightOfLack = 2.0;
// Least divisor.
constexpr double kLeast_Pa = std::numeric_limits<double>::min();

// Turns of the phase along an outline in the first starts; all others start from random phases.
constexpr double kTurns[] = {0.0, 1.0, -1.0, 2.0};
constexpr int kRamps = 4;

bool better(bool loudEnough, const SurfaceStatistics& a, const SurfaceStatistics& b, double floor)
{
    // A field that is loud enough beats one that is not. Of two loud enough fields the smoother one
    // wins, of two others the louder one.
    const bool other = b.mean_Pa >= floor;
    if (loudEnough != other) return loudEnough;
    return loudEnough ? a.coefficientOfVariation < b.coefficientOfVariation : a.mean_Pa > b.mean_Pa;
}

} // namespace

bool OutlineOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .within("spacing", spacing, 0.1, 1.0, " wavelengths")
        .within("starts", starts, 1, 1000)
        .atLeast("finalists", finalists, 1)
        .atLeast("rounds", rounds, 1)
        .atLeast("corrections", corrections, 0)
        .above("loudness", loudness, 0.0)
        .atLeast("threads", threads, 1)
        .passed(error);
}

OutlineHologram::OutlineHologram(const OutlineOptions& options) :
    _options(options),
    _field(options.pool ? options.pool
                        : std::make_shared<base::ThreadPool>(std::max(options.threads, 1)),
           Storage::FLOAT,
           options.stop)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("outline hologram: " + error);
}

// Refuses outlines that are too long before placing points along them.
void OutlineHologram::checkLength(const std::vector<Outline>& outlines, double wavelength_m) const
{
    const double spacing_m = _options.spacing * wavelength_m;
    const double points = pointsAlong(outlines, spacing_m);
    if (points > base::kMostControlPoints ||
        pointsAlong(outlines, kJudgeSpacing * wavelength_m) > base::kMostOutlineSamples)
        throw base::InputError(
            fmt::format("outline hologram: {:g} points {:g} m apart; at most {} can be solved for",
                        points,
                        spacing_m,
                        base::kMostControlPoints));
}

// Places control points \a spacing_m apart along every outline and builds their matrix; later
// solves are for these points.
void OutlineHologram::place(const Scene& scene, double spacing_m)
{
    std::vector<Eigen::Matrix3Xd> parts;
    Eigen::Index count = 0;
    _along.clear();
    for (const Outline& outline : scene.outlines)
    {
        parts.push_back(outline.points(spacing_m));
        const Eigen::Index n = parts.back().cols();
        count += n;
        for (Eigen::Index l = 0; l < n; ++l)
            _along.push_back(static_cast<double>(l) /
                             static_cast<double>(outline.closed ? n : n - 1));
    }
    ControlPoints& points = _points;
    points.positions.resize(3, count);
    points.normals.setZero(3, count); // a curve has none of its own
    points.targets.resize(count);
    Eigen::Index at = 0;
    for (std::size_t k = 0; k < parts.size(); ++k)
    {
        points.positions.middleCols(at, parts[k].cols()) = parts[k];
        points.targets.segment(at, parts[k].cols()).setConstant(scene.outlines[k].target);
        at += parts[k].cols();
    }
    std::vector<int> all(static_cast<std::size_t>(count));
    for (std::size_t l = 0; l < all.size(); ++l)
        all[l] = static_cast<int>(l);
    _field.assign(points, all, scene.array, scene.medium, 0.0);
    _field.build();
    if (!(_field.meanRowSum() > 0.0))
        throw base::InputError("outline hologram: no transducer reaches the outlines");
}

// Sets field.u to the starting phases with the number \a index and returns their name.
std::string OutlineHologram::start(int index)
{
    const auto n = static_cast<std::size_t>(_field.n());
    if (index < kRamps)
    {
        for (std::size_t l = 0; l < n; ++l)
            _field.u.set(
                l, std::polar(1.0f, static_cast<float>(base::kTwoPi * kTurns[index] * _along[l])));
        return index == 0 ? "equal" : fmt::format("ramp of {:g}", kTurns[index]);
    }
    std::mt19937_64 random(_options.seed + static_cast<std::uint64_t>(index));
    for (std::size_t l = 0; l < n; ++l)
        _field.u.set(l,
                     std::polar(1.0f,
                                static_cast<float>(base::kTwoPi * 0x1p-53 *
                                                   static_cast<double>(random() >> 11U))));
    return fmt::format("random {}", index - kRamps);
}

// Measures the radiation pressure along the outlines for field.q as the device plays it.
SurfaceStatistics OutlineHologram::judge(const Scene& scene, Eigen::VectorXcf* played)
{
    const Eigen::VectorXcf q = playedPhases(_field);
    if (played != nullptr) *played = q;
    Eigen::VectorXd pressure_Pa = meanRadiationPressure(
        scene.dense, scene.array, scene.medium, {q}, 2.0, _options.threads, _options.stop);
    // Radiation pressure goes with the square of the pressure, so this compares with the targets.
    pressure_Pa.array() /= scene.targets.array().square();
    return statisticsOf(pressure_Pa, Eigen::VectorXd());
}

// Finds the loudest field for points \a spacing_m apart and returns its radiation pressure.
SurfaceStatistics OutlineHologram::solveApart(const Scene& scene, double spacing_m)
{
    place(scene, spacing_m);
    SurfaceStatistics loudest;
    for (int k = 0; k < _options.starts; ++k)
    {
        start(k);
        _even.project(_field, 2 * _options.rounds);
        const SurfaceStatistics found = judge(scene);
        if (found.mean_Pa > loudest.mean_Pa) loudest = found;
    }
    return loudest;
}

// Equalises the pressure of field.q along the outlines at the candidate's goal and stores the
// result in the candidate.
void OutlineHologram::follow(const Scene& scene, int corrections, Candidate& candidate)
{
    LevenbergMarquardt::Limits limits;
    limits.corrections = corrections;
    candidate.corrections +=
        _even.fit(_field, std::sqrt(candidate.goal_Pa / scene.unit_Pa) / _field.unit_Pa(), limits);
    candidate.along = judge(scene);
    candidate.q = currentPhases(_field);
}

// Fully corrects a finalist and raises its goal until its mean pressure is loud enough.
void OutlineHologram::raise(const Scene& scene, double floor_Pa, Candidate& candidate)
{
    setPhases(_field, candidate.q);
    follow(scene, _options.corrections, candidate);
    const int corrections = std::min(kRaiseCorrections, _options.corrections);
    for (int k = 0; k < kRaises && corrections > 0 && candidate.along.mean_Pa < floor_Pa; ++k)
    {
        // The higher the goal, the more uneven the field must become and the less its mean follows,
        // so later raises are larger.
        const double lack = floor_Pa / std::max(candidate.along.mean_Pa, kLeast_Pa);
        candidate.goal_Pa *=
            std::clamp(1.005 * std::pow(lack, 1.5 + 0.5 * k), 1.01 + 0.01 * k, 1.25);
        follow(scene, corrections, candidate);
    }
}

std::vector<OutlineHologram::Candidate>
OutlineHologram::begin(const Scene& scene, double floor_Pa, OutlineReport& report)
{
    std::vector<Candidate> candidates;
    const bool warm =
        _options.warmStart && _last.size() == _field.arraySize() && _lastPoints == _field.n();
    const int starts = warm ? 1 : _options.starts;
    for (int k = 0; k < starts; ++k)
    {
        OutlineReport::Start begun;
        if (warm)
        {
            begun.name = "last field";
            setPhases(_field, _last);
            _field.forward(_field.q, _field.p);
            _field.phasesOf(_field.p);
            _even.project(_field, kWarmRounds);
        }
        else
        {
            begun.name = start(k);
            _even.project(_field, _options.rounds);
        }
        const double own = judge(scene).mean_Pa;
        Candidate candidate;
        candidate.start = k;
        candidate.goal_Pa = std::max(kHeadroom * floor_Pa, kOwnShare * own);
        follow(scene, std::min(kFirstCorrections, _options.corrections), candidate);
        begun.mean_Pa = candidate.along.mean_Pa;
        begun.coefficientOfVariation = candidate.along.coefficientOfVariation;
        report.starts.push_back(begun);
        candidates.push_back(std::move(candidate));
    }
    return candidates;
}

void OutlineHologram::finish(const Scene& scene,
                             double floor_Pa,
                             std::vector<Candidate>& candidates,
                             OutlineReport& report,
                             Eigen::VectorXcf& q)
{
    // A candidate ranks by its unevenness plus the weighted share that its mean lacks.
    const auto lack = [floor_Pa](const Candidate& c)
    {
        return c.along.coefficientOfVariation +
               kWeightOfLack * std::max(0.0, 1.0 - c.along.mean_Pa / std::max(floor_Pa, kLeast_Pa));
    };
    std::stable_sort(candidates.begin(),
                     candidates.end(),
                     [&](const Candidate& a, const Candidate& b) { return lack(a) < lack(b); });
    if (candidates.size() > static_cast<std::size_t>(_options.finalists))
        candidates.resize(static_cast<std::size_t>(_options.finalists));
    const Candidate* best = nullptr;
    for (Candidate& candidate : candidates)
    {
        raise(scene, floor_Pa, candidate);
        auto& line = report.starts[static_cast<std::size_t>(candidate.start)];
        line.mean_Pa = candidate.along.mean_Pa;
        line.coefficientOfVariation = candidate.along.coefficientOfVariation;
        line.finalist = true;
        if (best == nullptr ||
            better(candidate.along.mean_Pa >= floor_Pa, candidate.along, best->along, floor_Pa))
            best = &candidate;
    }
    setPhases(_field, best->q);
    report.along = judge(scene, &q);
    report.chosen = best->start;
    report.corrections = best->corrections;
    report.loudEnough = report.along.mean_Pa >= floor_Pa;
    _last = best->q;
    _lastPoints = _field.n();
}

OutlineReport OutlineHologram::solve(const std::vector<Outline>& outlines,
                                     const TransducerArray& array,
                                     const Medium& medium,
                                     Eigen::VectorXcf& q)
{
    _field.start();
    std::string error;
    if (outlines.empty())
        throw base::InputError(
            "outline hologram: there are no outlines; there must be at least one");
    if (!array.isValid(&error) || !medium.isValid(&error))
        throw base::InputError("outline hologram: " + error);
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    checkLength(outlines, wavelength_m);
    Eigen::Matrix3Xd dense;
    Eigen::VectorXd targets;
    for (const Outline& outline : outlines)
    {
        _options.stop.throwIfRequested();
        if (!(outline.target > 0.0 && std::isfinite(outline.target)))
            throw base::InputError(
                fmt::format("outline hologram: an outline's target is {:f}; it must be above 0",
                            outline.target));
        const Eigen::Matrix3Xd part = outline.points(kJudgeSpacing * wavelength_m);
        dense.conservativeResize(3, dense.cols() + part.cols());
        dense.rightCols(part.cols()) = part;
        targets.conservativeResize(dense.cols());
        targets.tail(part.cols()).setConstant(outline.target);
    }
    const Scene scene{outlines, array, medium, dense, targets, radiationPressure(1.0, medium)};

    OutlineReport report;
    place(scene, _options.spacing * wavelength_m);
    const bool warm =
        _options.warmStart && _last.size() == _field.arraySize() && _lastPoints == _field.n();
    if (!warm) _lastApart = solveApart(scene, wavelength_m);
    report.apart = _lastApart;
    const double floor_Pa = _options.loudness * report.apart.mean_Pa;
    if (!warm) place(scene, _options.spacing * wavelength_m);
    report.points = _field.n();
    std::vector<Candidate> candidates = begin(scene, floor_Pa, report);
    finish(scene, floor_Pa, candidates, report, q);
    report.solve_ms = _field.elapsed_ms();
    return report;
}

} // namespace midair::haptics
