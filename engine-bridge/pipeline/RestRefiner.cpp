#include "engine-bridge/pipeline/RestRefiner.h"

#include "engine-bridge/pipeline/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SurfaceSampler.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

// Spacing of the points at which an outline is checked for places out of reach; the points that it
// is solved for are denser.
constexpr double kOutlineLook_wavelengths = 0.5;

} // namespace

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

const haptics::TransducerArray& RestRefiner::arrayFor(const haptics::ControlPoints& points)
{
    return _around.shadowed(
        points, _options.array, _options.medium.wavelength(_options.array.frequency_Hz));
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
                    curves, played.absolute, modulation, arrayFor(played), _options.medium);
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
        arrayFor(assembled.points),
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

// The outlines of all objects of the scene, array frame; none if a part of one can't be reached.
std::vector<haptics::Outline> RestRefiner::outlines(const haptics::ControlPoints& played) const
{
    const double wavelength_m = _options.medium.wavelength(_options.array.frequency_Hz);
    const double look_m = kOutlineLook_wavelengths * wavelength_m;
    std::vector<haptics::Outline> all;
    double points = 0.0;
    for (const HapticObject& object : _snapshot.objects)
    {
        const double target = object.properties.pressureInPa || !played.absolute
                                  ? object.properties.pressure
                                  : object.properties.pressure * played.targets.maxCoeff();
        for (haptics::Outline& outline :
             haptics::featureOutlines(*object.mesh,
                                      haptics::SamplerOptions().creaseAngle_rad,
                                      wavelength_m,
                                      _options.solverOptions.stop))
        {
            outline.vertices = (object.pose * outline.vertices).eval();
            outline.target = target;
            // Checked before outline.points() allocates them.
            points += haptics::pointsAlong({outline}, look_m);
            if (points > base::kMostControlPoints || !_assembler.areInside(outline.points(look_m)))
                return {};
            all.push_back(std::move(outline));
        }
    }
    return all;
}

} // namespace midair::bridge
