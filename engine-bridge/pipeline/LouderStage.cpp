#include "engine-bridge/pipeline/LouderStage.h"

#include "haptics/base/ThrownBy.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr int kSet = 0;           // the composer's set of held fields
constexpr double kMostErrors = 2; // of a field on the way, over that at its start

} // namespace

LouderStage::LouderStage(PipelineContext& context,
                         haptics::SequenceComposer& composer,
                         HandStage& hands,
                         const RestRefiner& refiner) :
    _context(context),
    _composer(composer),
    _hands(hands),
    _refiner(refiner)
{
}

void LouderStage::setOptions()
{
    end();
    _phases.reset();
}

void LouderStage::replace()
{
    if (!_isOwn) end();
    _isOwn = false;
}

bool LouderStage::canBeLouder(const HologramResult& result) const
{
    const haptics::SolveReport& report = result.report();
    const bool isWanted = !result.points.absolute || report.shortPoints > 0;
    return isWanted && result.points.size() > 1 && _context.options.even > 0 &&
           std::isfinite(_context.options.restAfter_s) && _context.options.restAfter_s > 0.0 &&
           result.playing && result.foci == 0 && result.sequence.isHeld() &&
           !result.sequence.evened && !result.outline && report.capFactor == 1.0 &&
           _context.options.cycle == 1 && _context.options.solverOptions.loudness <= 1.0;
}

void LouderStage::settle(const HologramResult& result,
                         const SceneSnapshot& /*snapshot*/,
                         const haptics::TransducerArray& /*array*/)
{
    _work = canBeLouder(result) ? Work::BEGIN : Work::NONE;
    _due_s = _context.clock.now_s() + _context.options.restAfter_s;
}

bool LouderStage::hasTurn(bool isPlaying) const
{
    return isPlaying && _work != Work::NONE && !_refiner.rest_s(isPlaying);
}

std::optional<double> LouderStage::rest_s(bool isPlaying) const
{
    if (!hasTurn(isPlaying)) return std::nullopt;
    return std::max(0.0, _due_s - _context.clock.now_s());
}

RestStep LouderStage::attend(bool isPlaying)
{
    RestStep made;
    if (!hasTurn(isPlaying) || _context.clock.now_s() < _due_s) return made;
    try
    {
        if (_work == Work::BEGIN)
            begin();
        else if (_work == Work::SEARCH)
            search();
        else
            made.field = walk();
    }
    catch (const base::Stopped&)
    {
        throw; // not an error: the step can be repeated
    }
    catch (...)
    {
        _context.messages.say({base::MessageCode::FIELD_REST, base::whatWasThrown()});
        end();
    }
    _isOwn = made.isOtherField = made.field.has_value();
    return made;
}

void LouderStage::begin()
{
    const HologramResult& last = *_context.last;
    const Eigen::VectorXcf c = _composer.multipliers(kSet);
    if (c.size() == 0 || c.size() != last.points.size()) return end();
    if (!_phases) _phases = std::make_unique<haptics::LouderPhases>(_context.options.solverOptions);
    _phases->begin(last.points, _hands.shadowed(last.points), _context.options.medium, c);
    _work = Work::SEARCH;
}

void LouderStage::search()
{
    _phases->step();
    if (_phases->hasWork()) return;
    if (!(_phases->gain() >= kLeastGain)) return end();
    _walk = haptics::PhaseWalk(_composer.multipliers(kSet), _phases->best());
    _rms = _context.last->report().rms;
    _work = Work::WALK;
}

// Returns the next field, if it keeps the bounds of the walk.
std::optional<haptics::FieldSequence> LouderStage::walk()
{
    const HologramResult& last = *_context.last;
    const haptics::SolverOptions& options = _context.options.solverOptions;
    haptics::FieldSequence next = _composer.composeFrom(
        kSet, _walk.next(), last.sequence, _hands.shadowed(last.points), _context.options.medium);
    ++_context.counters.solves;
    const bool isGood = next.isHeld() && next.report.level_Pa > 0.0 &&
                        next.report.rms <= kMostErrors * std::max(_rms, options.rmsTolerance);
    if (!isGood)
    {
        end();
        return std::nullopt;
    }
    const bool isSmall = keepsBounds(_context, _walk, next);
    if (_walk.isOver()) end();
    if (!isSmall) return std::nullopt;
    _due_s = _context.clock.now_s() + kWalkPace_s;
    return next;
}

} // namespace midair::bridge
