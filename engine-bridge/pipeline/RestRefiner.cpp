#include "engine-bridge/pipeline/RestRefiner.h"

#include "engine-bridge/rendering/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/Workspace.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

RestRefiner::RestRefiner(PipelineContext& context,
                         PointAssembler& assembler,
                         haptics::SequenceComposer& composer,
                         HandStage& hands) :
    _context(context),
    _assembler(assembler),
    _composer(composer),
    _hands(hands),
    _surface(context.options.wavelength_m()),
    _evened(context.options.even, context.options.cycleSteps, context.options.solverOptions),
    _walk(context)
{
    setOptions();
}

void RestRefiner::setOptions()
{
    const HologramOptions& options = _context.options;
    _snapshot = {};
    _isCurrent = false;
    _missing = {};
    _sets.assign(static_cast<std::size_t>(options.cycle), {});
    _next = 0;
    _joined = {};
    _before = {};
    _surface = FeltSurface(options.wavelength_m());
    _surface.setStop(options.solverOptions.stop);
    _evened = haptics::EvenedCycle(options.even, options.cycleSteps, options.solverOptions);
    _walk.setOptions();
}

bool RestRefiner::hasWork() const
{
    return _isCurrent && (_missing.sets || _missing.outline || _missing.places ||
                          _evened.hasWork() || _walk.hasWork());
}

int RestRefiner::nextSet()
{
    const int set = _next;
    _next = (set + 1) % _context.options.cycle;
    end();
    return set;
}

void RestRefiner::begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made)
{
    _missing = {};
    _missing.sets = _context.options.cycle > 1 && !made.isEmpty();
    _missing.outline = !made.isEmpty() && isOutline(snapshot);
    _missing.places = !_missing.outline && isHeldSurface(snapshot, made);
    _evened.end();
    _walk.end();
    _isCurrent = _missing.sets || _missing.outline || _missing.places;
    if (_isCurrent || _context.options.monitorInterval > 0.0) _snapshot = snapshot;
    _restsAt_s = 0.0;
    if (_missing.places)
    {
        _joined = made;
        _restsAt_s = _context.clock.now_s() + _context.options.restAfter_s;
    }
    if (!_missing.sets) return;
    for (haptics::FieldSequence& other : _sets)
        other = {};
    _sets[static_cast<std::size_t>(set)] = made;
}

RestStep RestRefiner::attend(bool isPlaying)
{
    RestStep made;
    if (!isPlaying || !hasWork() || _context.clock.now_s() < _restsAt_s) return made;
    made.field = step();
    made.isOtherField = made.field.has_value();
    return made;
}

std::optional<double> RestRefiner::rest_s(bool isPlaying) const
{
    if (!isPlaying || !hasWork()) return std::nullopt;
    return std::max(_restsAt_s - _context.clock.now_s(), _walk.rest_s());
}

std::optional<haptics::FieldSequence> RestRefiner::step()
{
    try
    {
        if (_missing.outline) return makeOutline();
        if (_missing.sets)
        {
            if (makeNextSet()) return std::nullopt;
            _missing.sets = false;
            return joinSets();
        }
        if (_missing.places)
        {
            beginToEven();
            _missing.places = false;
            return std::nullopt;
        }
        if (_walk.hasWork()) return _walk.step(_hands.shadowed(_context.last->points));
        return _evened.step();
    }
    catch (const base::Stopped&)
    {
        throw; // not an error: it stays missing, so that the step can be repeated
    }
    catch (...)
    {
        _context.messages.say({base::MessageCode::FIELD_REST, base::whatWasThrown()});
        _missing = {};
        _evened.end();
        _walk.end();
        return std::nullopt;
    }
}

std::optional<haptics::FieldSequence> RestRefiner::makeOutline()
{
    const HologramResult& last = *_context.last;
    const haptics::ControlPoints& played = last.points;
    const std::vector<haptics::Outline> curves = outlines(played);
    if (curves.empty())
    {
        _missing.outline = false;
        return std::nullopt;
    }
    haptics::FieldSequence made = _composer.composeOutlines(curves,
                                                            played.absolute,
                                                            last.sequence.modulation,
                                                            _hands.shadowed(played),
                                                            _context.options.medium);
    ++_context.counters.solves;
    _missing.sets = _missing.outline = false;
    return made;
}

// Joins all sets unchanged, which can be played at once; they are evened out later.
haptics::FieldSequence RestRefiner::joinSets()
{
    std::vector<haptics::FieldSequence> sets(_sets.size());
    sets.swap(_sets);
    const bool oneEach = std::all_of(
        sets.begin(), sets.end(), [](const haptics::FieldSequence& set) { return set.isHeld(); });
    haptics::FieldSequence cycle =
        _composer.join(std::move(sets), {}, _context.options.array, _context.options.medium);
    _missing.places = oneEach && _context.options.even > 0;
    if (_missing.places) _joined = cycle;
    return cycle;
}

// False if a cap lowers the playing field to so few levels that the next one below is felt, or
// leaves transducers out, other ones of each field.
bool RestRefiner::canKeepShare() const
{
    constexpr std::size_t kFine = 100;
    constexpr double kLeast = 0.06; // some ten of 256 levels
    const std::size_t levels = _context.options.array.drive.amplitudeLevels.size();
    const double share = _context.last->report().capFactor;
    return share >= 1.0 || (share > kLeast && (levels == 0 || levels >= kFine));
}

void RestRefiner::beginToEven()
{
    const haptics::ControlPoints& played = _context.last->points;
    if (played.absolute) return;
    if (_joined.isHeld() && !canKeepShare()) return;
    auto places = _surface.places(_snapshot.objects, played, _context.options.cycle);
    if (!places)
    {
        _context.messages.say(
            {base::MessageCode::FIELD_UNEVEN,
             fmt::format("what is played is not evened out: its surfaces have more than {} places "
                         "{:g} wavelengths apart",
                         haptics::kMostPlaces,
                         haptics::kPlaceSpacings.back())});
        return;
    }
    const haptics::TransducerArray& array = _hands.shadowed(played);
    if (!_joined.isHeld())
        _evened.begin(_joined, places->places, array, _context.options.medium);
    else if (_context.options.restAfter_s > 0.0)
        _walk.begin(_joined, std::move(*places), array);
    else
        evenAtOnce(places->places, array);
}

// Of the first fields, and of what moves slowly: another evened field would be unrelated to the
// last one, and switching to it would be felt more than the unevenness.
void RestRefiner::evenAtOnce(const haptics::ControlPoints& places,
                             const haptics::TransducerArray& array)
{
    const Eigen::Matrix3Xd& now = _context.last->points.positions;
    const bool isFirst = _before.points.cols() == 0;
    const bool isNear =
        _before.points.cols() == now.cols() && now.cols() > 0 &&
        (now - _before.points).colwise().norm().maxCoeff() < 0.25 * _context.options.wavelength_m();
    _before.points = now;
    _joined.most = _context.last->report().capFactor;
    if (isNear && _before.isEvened &&
        _evened.resume(_joined, places, array, _context.options.medium))
        return;
    _before.isEvened =
        (isFirst || isNear) && _evened.begin(_joined, places, array, _context.options.medium);
}

void RestRefiner::report(HologramResult& result, bool isOtherField)
{
    if (result.sequence.evened && result.sequence.isHeld()) _walk.report(result, isOtherField);
}

// Computes one missing set of the cycle; returns false if none is missing.
bool RestRefiner::makeNextSet()
{
    const auto missing =
        std::find_if(_sets.begin(),
                     _sets.end(),
                     [](const haptics::FieldSequence& set) { return set.isEmpty(); });
    if (missing == _sets.end()) return false;
    const int set = static_cast<int>(missing - _sets.begin());
    AssembledPoints assembled = _assembler.assemble(_snapshot, set);
    _hands.keepWithinReach(assembled.points, assembled.skipped);
    if (assembled.points.size() == 0)
        throw base::InputError("fields in turn: one of the sets of points is empty; the others "
                               "are not played in turn");
    *missing = _composer.compose(
        set,
        assembled.points,
        modulationOf(
            _snapshot.objects, assembled.points, _context.options.modulation, _context.messages),
        _hands.shadowed(assembled.points),
        _context.options.medium);
    ++_context.counters.solves;
    if (missing->isEmpty()) throw base::InputError(missing->report.message);
    return true;
}

// True if all objects are edges that may be played as one field: no own spacing, paint or side, and
// the same modulation.
bool RestRefiner::isOutline(const SceneSnapshot& snapshot) const
{
    if (!_context.options.denseOutlines || _context.options.subsets > 1 ||
        snapshot.around.reach_m > 0.0 || _assembler.hasSmall())
        return false;
    const auto isCurve = [&](const HapticObject& object)
    {
        const HapticProperties& p = object.properties;
        const HapticProperties& first = snapshot.objects.front().properties;
        return p.sampling == haptics::Sampling::EDGES && p.spacing_m == 0.0 &&
               p.side == Side::BOTH && object.mesh && object.mesh->intensity.size() == 0 &&
               p.modulationFrequency_Hz == first.modulationFrequency_Hz &&
               p.modulationDepth == first.modulationDepth;
    };
    return !snapshot.objects.empty() &&
           std::all_of(snapshot.objects.begin(), snapshot.objects.end(), isCurve);
}

// True if \a made is one field of surfaces only, which may be evened out: ratios of pressures, of
// objects larger than a focus.
bool RestRefiner::isHeldSurface(const SceneSnapshot& snapshot,
                                const haptics::FieldSequence& made) const
{
    if (_context.options.even == 0 || !std::isfinite(_context.options.restAfter_s) ||
        _context.options.cycle > 1 || !made.isHeld() || made.parts.empty() || _assembler.hasSmall())
        return false;
    const haptics::ControlPoints& points = made.parts.front();
    const auto isSurface = [&](int object)
    {
        return snapshot.objects[static_cast<std::size_t>(object)].properties.sampling ==
               haptics::Sampling::SURFACE;
    };
    return !points.absolute && !points.object.empty() &&
           std::all_of(points.object.begin(), points.object.end(), isSurface);
}

// The outlines of all objects, array frame; none if a part of one is out of reach or clipped,
// because points, which are played instead, can be left out one by one, or if there are also single
// points.
std::vector<haptics::Outline> RestRefiner::outlines(const haptics::ControlPoints& played) const
{
    std::vector<haptics::Outline> all;
    double points = 0.0;
    for (const HapticObject& object : _snapshot.objects)
    {
        const double target = object.properties.pressureInPa || !played.absolute
                                  ? object.properties.pressure
                                  : object.properties.pressure * played.targets.maxCoeff();
        haptics::ReachedOutlines reached =
            haptics::reachedOutlines(*object.mesh,
                                     object.pose,
                                     target,
                                     _assembler.workspace(),
                                     _context.options.solverOptions.stop);
        points += reached.points;
        for (const haptics::Outline& outline : reached.inside)
            for (const auto& vertex : outline.vertices.colwise())
                if (isClipped(object.clips, vertex)) return {};
        if (reached.outside > 0 || reached.apart > 0 || points > base::kMostControlPoints)
            return {};
        std::move(reached.inside.begin(), reached.inside.end(), std::back_inserter(all));
    }
    return all;
}

} // namespace midair::bridge
