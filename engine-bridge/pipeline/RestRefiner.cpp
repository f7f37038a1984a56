#include "engine-bridge/pipeline/RestRefiner.h"

#include "engine-bridge/pipeline/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/points/ReachedOutlines.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace midair::bridge
{

RestRefiner::RestRefiner(const HologramOptions& options,
                         PointAssembler& assembler,
                         haptics::SequenceComposer& composer,
                         ReachAndShadow& around,
                         base::MessageLog& messages) :
    _options(options),
    _assembler(assembler),
    _composer(composer),
    _around(around),
    _messages(messages),
    _sets(static_cast<std::size_t>(options.cycle))
{
}

int RestRefiner::nextSet()
{
    const int set = _next;
    _next = (set + 1) % _options.cycle;
    end();
    return set;
}

void RestRefiner::begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made)
{
    _setsMissing = _options.cycle > 1 && !made.isEmpty();
    _outlineMissing = !made.isEmpty() && isOutline(snapshot);
    _current = _setsMissing || _outlineMissing;
    if (_current || _options.monitorInterval > 0.0) _snapshot = snapshot;
    if (!_setsMissing) return;
    for (haptics::FieldSequence& other : _sets)
        other = {};
    _sets[static_cast<std::size_t>(set)] = made;
}

int RestRefiner::takeSolves()
{
    return std::exchange(_solves, 0);
}

std::optional<haptics::FieldSequence> RestRefiner::step(const haptics::ControlPoints& played,
                                                        const haptics::ModulatorOptions& modulation)
{
    if (!hasWork()) return std::nullopt;
    try
    {
        if (_outlineMissing)
        {
            const std::vector<haptics::Outline> curves = outlines(played);
            if (!curves.empty())
            {
                haptics::FieldSequence made = _composer.composeOutlines(
                    curves,
                    played.absolute,
                    modulation,
                    _around.shadowed(played, _options.array, _options.wavelength_m()),
                    _options.medium);
                ++_solves;
                _setsMissing = _outlineMissing = false;
                return made;
            }
            _outlineMissing = false;
            return std::nullopt;
        }
        if (makeNextSet()) return std::nullopt;
        _setsMissing = false;
        std::vector<haptics::FieldSequence> sets(_sets.size());
        sets.swap(_sets);
        return _composer.join(
            std::move(sets), Eigen::Matrix3Xd(3, 0), _options.array, _options.medium);
    }
    catch (const base::Stopped&)
    {
        throw; // not an error: the flags stay, so that the step can be done again
    }
    catch (const std::exception& error)
    {
        _messages.say(error.what());
        _setsMissing = _outlineMissing = false;
        return std::nullopt;
    }
}

// Makes one set of the cycle that is missing; returns false if none is.
bool RestRefiner::makeNextSet()
{
    const auto missing =
        std::find_if(_sets.begin(),
                     _sets.end(),
                     [](const haptics::FieldSequence& set) { return set.isEmpty(); });
    if (missing == _sets.end()) return false;
    const int set = static_cast<int>(missing - _sets.begin());
    AssembledPoints assembled = _assembler.assemble(_snapshot, set);
    _around.keepWithinReach(assembled.points, assembled.skipped);
    if (assembled.points.size() == 0)
        throw base::InputError("fields in turn: one of the sets of points is empty; the others "
                               "are not played in turn");
    *missing = _composer.compose(
        set,
        assembled.points,
        modulationOf(_snapshot.objects, assembled.points, _options.modulation, _messages),
        _around.shadowed(assembled.points, _options.array, _options.wavelength_m()),
        _options.medium);
    ++_solves;
    if (missing->isEmpty()) throw base::InputError(missing->report.message);
    return true;
}

// True if all objects are edges that may be played as one field: no own spacing, paint or side, and
// the same modulation.
bool RestRefiner::isOutline(const SceneSnapshot& snapshot) const
{
    if (!_options.denseOutlines || _options.subsets > 1 || snapshot.around.reach_m > 0.0)
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

// The outlines of all objects of the scene, array frame; none if a part of one can't be reached,
// since points, which are played instead, can be left out one by one.
std::vector<haptics::Outline> RestRefiner::outlines(const haptics::ControlPoints& played) const
{
    std::vector<haptics::Outline> all;
    double points = 0.0;
    for (const HapticObject& object : _snapshot.objects)
    {
        const double target = object.properties.pressureInPa || !played.absolute
                                  ? object.properties.pressure
                                  : object.properties.pressure * played.targets.maxCoeff();
        haptics::ReachedOutlines reached = haptics::reachedOutlines(
            *object.mesh, object.pose, target, _assembler.workspace(), _options.solverOptions.stop);
        points += reached.points;
        if (reached.outside > 0 || points > base::kMostControlPoints) return {};
        std::move(reached.inside.begin(), reached.inside.end(), std::back_inserter(all));
    }
    return all;
}

} // namespace midair::bridge
