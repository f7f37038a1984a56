#include "engine-bridge/pipeline/EveningWalk.h"

#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

// haptics/SOLVER.md, "Fields in turn".
constexpr double kNear = 0.7;      // share of PhaseWalk::kMostTurn_rad: nearer fields are passed by
constexpr double kMeantStep = 0.7; // PhaseWalk::Steps::meant
constexpr double kMeantChange = 0.025; // of the mean pressure on the surface, in a step
constexpr double kMeasure_s = 0.25;    // between two measurements of the surface

/// Mean angle between \a a and \a b, which have the same common phase, rad.
double turnBetween(const Eigen::VectorXcf& a, const Eigen::VectorXcf& b)
{
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.size(); ++i)
        sum += std::fabs(static_cast<double>(std::arg(b[i] * std::conj(a[i]))));
    return a.size() > 0 ? sum / static_cast<double>(a.size()) : 0.0;
}

} // namespace

bool keepsBounds(PipelineContext& context, haptics::PhaseWalk& walk, haptics::FieldSequence& next)
{
    haptics::continueFrom(context.last->played(),
                          context.options.solverOptions.updateRate_Hz,
                          context.options.array.drive,
                          next);
    const double ratio = next.report.level_Pa / context.level_Pa;
    if (!walk.accept(next.report.meanPhaseStep_rad, std::max(ratio, 1.0 / ratio))) return false;
    ++context.counters.walked;
    return true;
}

EveningWalk::EveningWalk(PipelineContext& context) :
    _context(context),
    _evened(0, 0, context.options.solverOptions)
{
}

void EveningWalk::setOptions()
{
    const HologramOptions& options = _context.options;
    _evened = haptics::EvenedCycle(options.even, 0, options.solverOptions);
    end();
}

void EveningWalk::end()
{
    _evened.end();
    _trail = {};
    _walk.end();
}

void EveningWalk::begin(const haptics::FieldSequence& held,
                        PlacesToEven where,
                        const haptics::TransducerArray& array)
{
    end();
    _held = held;
    _held.most = _context.last->report().capFactor;
    _held.achieved_Pa.resize(0);
    _held.evened = true;
    _at = {_held.fields.front(), 1.0};
    _measured = {};
    _measured.places = std::move(where.between);
    _evened.begin(_held, where.places, array, _context.options.medium);
}

double EveningWalk::rest_s() const
{
    if (_evened.hasWork() || !isWalking()) return 0.0;
    return std::max(0.0, _due_s - _context.clock.now_s());
}

std::optional<haptics::FieldSequence> EveningWalk::step(const haptics::TransducerArray& array)
{
    if (isWalking() && _context.clock.now_s() >= _due_s) return walk(array);
    if (_evened.hasWork()) look();
    return std::nullopt;
}

// Notes each field that the equalizer finds; all up to one that is worth it may be walked.
void EveningWalk::look()
{
    const auto better = _evened.step();
    const int passes = _evened.equalizer().passes();
    if (passes > _trail.seen)
    {
        _trail.seen = passes;
        _trail.stops.push_back(
            {_evened.equalizer().unroundedFields().front(), _evened.equalizer().gain()});
    }
    if (better) _trail.open = _trail.stops.size();
}

// Heads for the last of the next fields that is near.
void EveningWalk::aim()
{
    const Stop from = _at;
    double turn_rad = 0.0;
    while (_trail.open > 0)
    {
        const double next_rad = turnBetween(from.field, _trail.stops.front().field);
        if (turn_rad > 0.0 && next_rad > kNear * haptics::PhaseWalk::kMostTurn_rad) break;
        turn_rad = std::max(next_rad, 1e-6);
        _at = std::move(_trail.stops.front());
        _trail.stops.pop_front();
        --_trail.open;
    }
    const double most_rad = haptics::PhaseWalk::kMostTurn_rad;
    const double change = std::fabs(_at.gain / from.gain - 1.0);
    const double first =
        std::min({1.0, kMeantStep * most_rad / turn_rad, kMeantChange / std::max(change, 1e-6)});
    _walk.begin(from.field, _at.field, {first, std::min(kMeantStep, first * turn_rad / most_rad)});
}

// Returns the next field, if it keeps the bounds.
std::optional<haptics::FieldSequence> EveningWalk::walk(const haptics::TransducerArray& array)
{
    if (_walk.isOver()) aim();
    const haptics::SolverOptions& options = _context.options.solverOptions;
    haptics::FieldSequence next = _held;
    next.fields = {_walk.next()};
    haptics::roundPhases(next.fields.front(), _context.options.array.drive);
    haptics::rateLevel(next.points(),
                       haptics::achievedPressure(
                           next, array, _context.options.medium, options.threads, options.stop),
                       next.report);
    if (!keepsBounds(_context, _walk, next))
    {
        if (_walk.isOver()) end(); // no field is near enough
        return std::nullopt;
    }
    _due_s = _context.clock.now_s() + kWalkPace_s;
    return next;
}

void EveningWalk::report(HologramResult& result, bool isOtherField)
{
    const double now_s = _context.clock.now_s();
    const bool isDue = now_s >= _measured.next_s || !hasWork();
    if (isOtherField && isDue && result.playing && _measured.places.cols() > 0)
    {
        haptics::SurfaceStatisticsOptions options;
        options.offPoints = 0;
        options.threads = _context.options.solverOptions.threads;
        options.stop = _context.options.solverOptions.stop;
        try
        {
            _measured.surface = haptics::surfaceStatistics(_measured.places,
                                                           *result.array,
                                                           _context.options.medium,
                                                           result.sequence.fields,
                                                           options);
        }
        catch (const base::Stopped&)
        {
            return; // the playing field ends soon
        }
        _measured.next_s = _context.clock.now_s() + kMeasure_s;
    }
    result.sequence.report.surface = _measured.surface;
}

} // namespace midair::bridge
