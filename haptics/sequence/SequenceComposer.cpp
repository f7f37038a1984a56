#include "haptics/sequence/SequenceComposer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

bool isField(const SolveReport& report)
{
    return report.stop != StopReason::NOTHING_TO_DO && report.stop != StopReason::REFUSED &&
           report.stop != StopReason::STOPPED;
}

/// Reports since when something is busy.
class AtWork
{
public:
    explicit AtWork(std::atomic<double>& since_s) : _since_s(since_s)
    {
        _since_s = base::steadySeconds();
    }
    ~AtWork() { _since_s = 0.0; }
    AtWork(const AtWork&) = delete;
    AtWork& operator=(const AtWork&) = delete;

private:
    std::atomic<double>& _since_s;
};

// Moves the parts to their fields: field k was at order[k] and is followed by \a steps intermediate
// fields.
void placeParts(const std::vector<int>& order, int steps, FieldSequence& sequence)
{
    std::vector<ControlPoints> placed(sequence.fields.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        placed[k * static_cast<std::size_t>(steps + 1)] =
            std::move(sequence.parts[static_cast<std::size_t>(order[k])]);
    sequence.parts = std::move(placed);
}

// Relative targets must be comparable across all fields that the skin averages, so each set plays
// at the level of the weakest.
void matchLevels(const std::vector<std::size_t>& sizes,
                 std::vector<SolveReport>& reports,
                 FieldSequence& cycle,
                 const DriveResolution& drive)
{
    std::vector<double> levels;
    double common = 0.0;
    std::size_t first = 0;
    for (std::size_t set = 0; set < sizes.size(); first += sizes[set++])
    {
        const ControlPoints& points = cycle.parts[first];
        if (points.absolute) return;
        const double level = unitLevel(reports[set], points);
        levels.push_back(level);
        if (level > 0.0) common = common > 0.0 ? std::min(common, level) : level;
    }
    first = 0;
    for (std::size_t set = 0; set < sizes.size(); first += sizes[set++])
    {
        if (!(levels[set] > common)) continue;
        for (std::size_t k = first; k < first + sizes[set]; ++k)
            scaleField(cycle.fields[k], static_cast<float>(common / levels[set]), drive);
        reports[set].level_Pa *= common / levels[set];
        reports[set].loudness *= common / levels[set];
    }
}

// Evens out completely, and rates the average.
void evenOut(const ControlPoints& places,
             const TransducerArray& array,
             const Medium& medium,
             const ComposerOptions& options,
             FieldSequence& cycle)
{
    const SolverOptions& solver = options.solverOptions;
    EvenedCycle evened(options.even, options.cycleSteps, solver);
    evened.begin(cycle, places, array, medium);
    while (evened.hasWork())
        if (auto better = evened.step()) cycle = std::move(*better);
    if (!cycle.evened) return;
    rateLevel(cycle.points(),
              achievedPressure(cycle, array, medium, solver.threads, solver.stop),
              cycle.report);
}

// haptics/SOLVER.md, "From below": for outlines, whose targets in Pa coarse levels may exceed.
constexpr int kOutlinePasses = 8;
constexpr double kBelowTarget = 0.98;
constexpr double kMostOverTarget = 1.1;

// Outlines are solved at full amplitude; this lowers the field to targets in Pa and to the
// loudness.
void fitLevel(double loudness,
              const TransducerArray& array,
              const Medium& medium,
              const SolverOptions& solver,
              FieldSequence& sequence)
{
    Eigen::VectorXcf& q = sequence.fields.front();
    const ControlPoints& points = sequence.parts.front();
    double share = std::min(loudness, 1.0);
    if (points.absolute)
    {
        const Eigen::VectorXd y =
            achievedPressure(sequence, array, medium, solver.threads, solver.stop).cast<double>();
        const double level = fittedLevel(y, points.targets);
        if (level > 0.0) share = std::min(share, 1.0 / level);
    }
    if (!(share < 1.0)) return;
    const Eigen::VectorXcf full = q;
    double level = 0.0;
    for (int pass = 0; pass < kOutlinePasses; ++pass)
    {
        q = full;
        scaleField(q, static_cast<float>(share), array.drive);
        if (!points.absolute) return;
        level = fittedLevel(
            achievedPressure(sequence, array, medium, solver.threads, solver.stop).cast<double>(),
            points.targets);
        if (level <= 1.0 + kShortBy) return;
        share *= kBelowTarget / level;
    }
    if (level > kMostOverTarget) q.setZero(); // even one transducer is too loud
}

} // namespace

double unitLevel(const SolveReport& report, const ControlPoints& points)
{
    return isField(report) && points.size() > 0 ? report.level_Pa / points.targets.maxCoeff() : 0.0;
}

SolveReport together(const std::vector<SolveReport>& reports)
{
    // A single field's steps are relative to its last one; solvers don't know the steps between
    // fields in turn.
    if (reports.size() == 1) return reports.front();
    SolveReport all = reports.front();
    double squares = 0.0, squaresOfLargest = 0.0;
    int points = 0, fields = 0;
    all.points = all.iterations = all.rowsBuilt = all.leftOut = all.shortPoints = 0;
    all.matrix_ms = all.solve_ms = all.max = all.maxOfLargest = all.loudness = all.level_Pa = 0.0;
    all.meanPhaseStep_rad = all.driveChange = all.audibleChange = all.worstShortfall = 0.0;
    all.message.clear();
    bool chosen = false;
    for (const SolveReport& r : reports)
    {
        all.points += r.points;
        all.iterations += r.iterations;
        all.rowsBuilt += r.rowsBuilt;
        all.leftOut += r.leftOut;
        all.shortPoints += r.shortPoints;
        all.matrix_ms += r.matrix_ms;
        all.solve_ms += r.solve_ms;
        all.max = std::max(all.max, r.max);
        all.maxOfLargest = std::max(all.maxOfLargest, r.maxOfLargest);
        all.level_Pa = std::max(all.level_Pa, r.level_Pa);
        all.worstShortfall = std::max(all.worstShortfall, r.worstShortfall);
        if (all.message.empty() && isField(r)) all.message = r.message;
        // The stop reason of the first field that did not converge; a refusal has precedence.
        const bool isReason = isField(r) && r.stop != StopReason::CONVERGED && !chosen;
        const bool isEnd = r.stop == StopReason::REFUSED || r.stop == StopReason::STOPPED;
        if (isEnd || isReason)
        {
            all.stop = r.stop;
            all.message = r.message;
            chosen = true;
        }
        if (isEnd) break;
        if (!isField(r)) continue;
        if (!chosen) all.stop = r.stop;
        squares += r.rms * r.rms * (r.points - r.leftOut);
        squaresOfLargest += r.rmsOfLargest * r.rmsOfLargest * (r.points - r.leftOut);
        points += r.points - r.leftOut;
        all.loudness += r.loudness;
        ++fields;
    }
    // The message about missing points is used only if no part has points.
    if (fields == 0 && all.message.empty()) all.message = reports.front().message;
    all.rms = points > 0 ? std::sqrt(squares / points) : 0.0;
    all.rmsOfLargest = points > 0 ? std::sqrt(squaresOfLargest / points) : 0.0;
    if (fields > 0) all.loudness /= fields;
    return all;
}

Eigen::VectorXf TimeMultiplexer::achieved_Pa() const
{
    return _reports.size() == 1 ? _solvers.front()->achieved_Pa() : Eigen::VectorXf();
}

Eigen::VectorXcf TimeMultiplexer::multipliers() const
{
    return _reports.size() == 1 ? _solvers.front()->multipliers() : Eigen::VectorXcf();
}

bool TimeMultiplexer::startFrom(const Eigen::VectorXcf& c)
{
    return _reports.size() == 1 && _solvers.front()->startFrom(c);
}

bool TimeMultiplexer::setOptions(const SolverOptions& options)
{
    return std::all_of(_solvers.begin(),
                       _solvers.end(),
                       [&](const auto& solver) { return solver->setOptions(options); });
}

SolveReport TimeMultiplexer::solve(const std::vector<ControlPoints>& parts,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   std::vector<Eigen::VectorXcf>& fields)
{
    if (parts.empty())
        throw base::InputError(
            "fields in turn: there are no points; there must be at least one set");
    Eigen::Index points = 0;
    for (const ControlPoints& part : parts)
        points += part.size();
    if (points > base::kMostPointsInTurn)
        throw base::InputError(fmt::format("fields in turn: the {} fields have {} control points "
                                           "together; there must be at most {}",
                                           parts.size(),
                                           points,
                                           base::kMostPointsInTurn));
    while (_solvers.size() < parts.size())
        _solvers.push_back(_makeSolver());
    fields.resize(parts.size());
    _reports.resize(parts.size());
    double common = 0.0; // Pa per unit of target
    for (std::size_t k = 0; k < parts.size(); ++k)
    {
        _reports[k] = _solvers[k]->solve(parts[k], array, medium, fields[k]);
        if (_reports[k].stop == StopReason::STOPPED)
        {
            for (Eigen::VectorXcf& field : fields)
                field.setZero(array.size());
            return _reports[k];
        }
        const double level = unitLevel(_reports[k], parts[k]);
        if (level > 0.0) common = common > 0.0 ? std::min(common, level) : level;
    }
    const bool absolute = parts.front().absolute;
    for (std::size_t k = 0; k < parts.size() && !absolute && parts.size() > 1; ++k)
    {
        const double level = unitLevel(_reports[k], parts[k]);
        if (!(level > common)) continue;
        scaleField(fields[k], static_cast<float>(common / level), array.drive);
        _reports[k].level_Pa *= common / level;
        _reports[k].loudness *= common / level;
    }
    return together(_reports);
}

SequenceComposer::SequenceComposer(ComposerOptions options, base::MessageLog& messages) :
    _options(std::move(options)),
    _messages(messages)
{
    _options.modulation.fieldRate_Hz = _options.fieldRate;
    if (!_options.makeSolver)
        _options.makeSolver = [solver = _options.solverOptions]
        { return haptics::makeSolver(solverNames().front(), solver); };
}

void SequenceComposer::setOptions(ComposerOptions options, bool otherSolver)
{
    _options = std::move(options);
    _options.modulation.fieldRate_Hz = _options.fieldRate;
    for (auto known = _kept.begin(); known != _kept.end();)
        known = otherSolver || !known->second.solvers.setOptions(_options.solverOptions)
                    ? _kept.erase(known)
                    : std::next(known);
}

// The solvers of a set keep their matrices for a warm start, for as many sets as memory allows.
SequenceComposer::Kept& SequenceComposer::keptFor(int set, int points)
{
    auto own = _kept.find(set);
    if (own == _kept.end())
        own = _kept.emplace(set, Kept{TimeMultiplexer(_options.makeSolver), {}, 0}).first;
    own->second.points = std::max(own->second.points, points);
    int all = 0;
    for (const auto& known : _kept)
        all += known.second.points;
    for (auto other = _kept.begin(); other != _kept.end() && all > base::kMostPointsInTurn;)
    {
        if (other == own)
        {
            ++other;
            continue;
        }
        all -= other->second.points;
        other = _kept.erase(other);
    }
    return own->second;
}

// Sets sequence.modulation, and returns the points of each field.
std::vector<ControlPoints> SequenceComposer::split(const ControlPoints& points,
                                                   const ModulationPlan& plan,
                                                   FieldSequence& sequence)
{
    ModulatorOptions& modulation = sequence.modulation;
    modulation = _options.modulation;
    const bool isOfFields = plan.isModulated() && !plan.isAlike();
    const double frequency_Hz =
        _options.line.fit(modulation,
                          plan.isModulated() ? plan.rate_Hz : modulation.amplitudeRate_Hz,
                          isOfFields ? 1 : std::max(1, _options.subsets));
    if (isOfFields)
    {
        // The margin keeps rounding from losing a field if the rate is a multiple.
        const int instants = static_cast<int>(
            std::clamp(modulation.fieldRate_Hz / frequency_Hz + 1e-9, 2.0, double(kMostInstants)));
        modulation.fieldRate_Hz = instants * frequency_Hz;
        if (_options.subsets > 1)
            _messages.say({base::MessageCode::MODULATION_SUBSETS,
                           "objects that are modulated differently are not played in subsets"});
        return modulationSteps(points, plan.depth, instants);
    }
    if (plan.isModulated())
    {
        modulation.amplitudeDepth = plan.depth[0];
    }
    modulation.amplitudeRate_Hz = frequency_Hz;
    if (_options.subsets > 1) return subsetsInTurn(points, _options.subsets);
    return {points};
}

FieldSequence SequenceComposer::compose(int set,
                                        const ControlPoints& points,
                                        const ModulationPlan& plan,
                                        const TransducerArray& array,
                                        const Medium& medium)
{
    const AtWork atWork(_busySince_s);
    FieldSequence sequence;
    sequence.parts = split(points, plan, sequence);
    int all = 0;
    for (const ControlPoints& part : sequence.parts)
        all += part.size();
    solve(keptFor(set, all), array, medium, sequence);
    // In the first instant of a modulation all points have their full targets.
    if (plan.isModulated() && !plan.isAlike()) sequence.parts.resize(1);
    return sequence;
}

// Solves the parts of \a sequence.
void SequenceComposer::solve(Kept& kept,
                             const TransducerArray& array,
                             const Medium& medium,
                             FieldSequence& sequence)
{
    sequence.report = kept.solvers.solve(sequence.parts, array, medium, kept.fields);
    if (sequence.report.stop == StopReason::STOPPED) throw base::Stopped();
    if (sequence.report.stop == StopReason::REFUSED) return;
    sequence.fields = kept.fields;
    sequence.achieved_Pa = kept.solvers.achieved_Pa();
    if (!sequence.isHeld()) // the solver reports its step from the last field
    {
        alignFields(sequence.fields, array.drive);
        rateSteps(sequence);
    }
    rateRinging(sequence, array.ringing_s);
}

Eigen::VectorXcf SequenceComposer::multipliers(int set) const
{
    const auto kept = _kept.find(set);
    return kept == _kept.end() ? Eigen::VectorXcf() : kept->second.solvers.multipliers();
}

FieldSequence SequenceComposer::composeFrom(int set,
                                            const Eigen::VectorXcf& c,
                                            const FieldSequence& held,
                                            const TransducerArray& array,
                                            const Medium& medium)
{
    const AtWork atWork(_busySince_s);
    FieldSequence sequence;
    sequence.modulation = held.modulation;
    sequence.parts = held.parts;
    const auto kept = _kept.find(set);
    if (sequence.parts.size() == 1 && kept != _kept.end() && kept->second.solvers.startFrom(c))
        solve(kept->second, array, medium, sequence);
    return sequence;
}

FieldSequence SequenceComposer::join(std::vector<FieldSequence> sets,
                                     const ControlPoints& places,
                                     const TransducerArray& array,
                                     const Medium& medium)
{
    if (sets.empty())
        throw base::InputError(
            "field cycle: there are no sets of points; there must be at least one");
    FieldSequence cycle;
    cycle.modulation = sets.front().modulation;
    std::vector<SolveReport> reports;
    std::vector<std::size_t> sizes;
    bool oneEach = true;
    for (FieldSequence& set : sets)
    {
        if (set.isEmpty())
            throw base::InputError(
                fmt::format("field cycle: set {}: {}", reports.size(), set.report.message));
        oneEach = oneEach && set.isHeld();
        set.parts.resize(set.fields.size());
        sizes.push_back(set.fields.size());
        std::move(set.fields.begin(), set.fields.end(), std::back_inserter(cycle.fields));
        std::move(set.parts.begin(), set.parts.end(), std::back_inserter(cycle.parts));
        reports.push_back(set.report);
    }
    if (!oneEach) matchLevels(sizes, reports, cycle, array.drive);
    cycle.report = together(reports);
    std::vector<int> order(cycle.fields.size());
    std::iota(order.begin(), order.end(), 0);
    int steps = 0;
    if (oneEach)
    {
        if (_options.reorder) order = orderFields(cycle.fields);
        steps = _options.cycleSteps;
    }
    // Not reordered, because the order of subsets and instants matters.
    alignFields(cycle.fields, array.drive);
    cycle.fields = smoothedFields(cycle.fields, steps, array.drive);
    placeParts(order, steps, cycle);
    rateSteps(cycle);
    rateRinging(cycle, array.ringing_s);
    if (oneEach) evenOut(places, array, medium, _options, cycle);
    return cycle;
}

FieldSequence SequenceComposer::composeCycle(const std::vector<ControlPoints>& sets,
                                             const ControlPoints& places,
                                             const TransducerArray& array,
                                             const Medium& medium)
{
    std::vector<FieldSequence> made;
    made.reserve(sets.size());
    for (const ControlPoints& set : sets)
        made.push_back(compose(static_cast<int>(made.size()), set, {}, array, medium));
    return join(std::move(made), places, array, medium);
}

FieldSequence SequenceComposer::composeOutlines(const std::vector<Outline>& outlines,
                                                bool absolute,
                                                const ModulatorOptions& modulation,
                                                const TransducerArray& array,
                                                const Medium& medium)
{
    if (!_outlines)
    {
        // One thread, so that the field of a curve does not depend on the number of threads.
        OutlineOptions options;
        options.stop = _options.solverOptions.stop;
        options.seed = _options.solverOptions.seed;
        _outlines = std::make_unique<OutlineHologram>(options);
    }
    FieldSequence sequence;
    sequence.modulation = modulation;
    sequence.fields.resize(1);
    // Solves for the ratios of the targets, so that the same curves give the same field at any
    // pressure.
    double largest = 0.0;
    for (const Outline& outline : outlines)
        largest = std::max(largest, outline.target);
    std::vector<Outline> relative = outlines;
    if (largest > 0.0 && std::isfinite(largest))
        for (Outline& outline : relative)
            outline.target /= largest;
    else
        largest = 1.0; // the solver reports the error
    const OutlineReport found = _outlines->solve(relative, array, medium, sequence.fields.front());
    sequence.parts = {_outlines->points()};
    sequence.parts.front().targets *= largest;
    sequence.parts.front().absolute = absolute;
    fitLevel(_options.solverOptions.loudness, array, medium, _options.solverOptions, sequence);
    SolveReport& report = sequence.report;
    if (_options.solverOptions.loudness > 1.0)
        report.message = fmt::format("a loudness of {:g} counts as 1: outlines are as loud as they "
                                     "can be smooth",
                                     _options.solverOptions.loudness);
    report.solver = kOutlineSolver;
    report.stop = StopReason::STALLED;
    report.points = sequence.parts.front().size();
    report.transducers = array.size();
    report.iterations = found.corrections;
    report.rowsBuilt = report.points;
    report.solve_ms = found.solve_ms;
    const ControlPoints& points = sequence.parts.front();
    rateLevel(
        points,
        achievedPressure(
            sequence, array, medium, _options.solverOptions.threads, _options.solverOptions.stop),
        report);
    report.loudness = loudnessOf(report.level_Pa / points.targets.maxCoeff(),
                                 points.targets.norm(),
                                 _outlines->meanRowSum_Pa());
    rateRinging(sequence, array.ringing_s);
    return sequence;
}

} // namespace midair::haptics
