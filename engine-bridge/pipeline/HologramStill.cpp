// HologramPipeline: what is made, played and measured while nothing moves.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/surface/FeatureChains.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

// From nothing, a curve's field takes these starts; a few tenths of a second for what comes up here.
constexpr int kOutlineStarts = 4;
constexpr int kOutlineFinalists = 2;
// As far from a point as the sampler lets a spot of the surface be, in spacings.
constexpr double kFeltReach = 1.1;
constexpr double kMonitorPoll_s = 0.02;

} // namespace

double HologramPipeline::rest_s() const
{
    const bool current = _still.current && _playing;
    if (current && (_still.setsMissing || _still.outlineMissing)) return 0.0;
    const bool asked = _monitor && (_still.number > _still.shown || !_still.submitted);
    return current && asked ? kMonitorPoll_s : kAttend_s;
}

std::shared_ptr<const HologramResult> HologramPipeline::goOn()
{
    if (!_last || !_playing || !_still.current) return nullptr;
    try
    {
        if (_still.outlineMissing) return _last = playOutlines();
        if (_still.setsMissing) return makeNextSet() ? nullptr : _last = playAllSets();
    }
    catch (const base::Stopped&)
    {
        throw; // made another time, if at all
    }
    catch (const std::exception& error)
    {
        // What is played already goes on.
        _messages.say(error.what());
        _still.setsMissing = _still.outlineMissing = false;
        return nullptr;
    }
    return askMonitor();
}

// One set of the cycle that isn't there yet; false where all are.
bool HologramPipeline::makeNextSet()
{
    StillScene& still = _still;
    for (std::size_t set = 0; set < still.sets.size(); ++set)
    {
        StillScene::Set& next = still.sets[set];
        if (!next.made.fields.empty()) continue;
        HologramResult scratch;
        AssembledPoints assembled = _assembler->assemble(still.snapshot, static_cast<int>(set));
        scratch.points = std::move(assembled.points);
        scratch.skipped = std::move(assembled.skipped);
        _around.keepWithinReach(scratch.points, scratch.skipped);
        if (scratch.points.size() == 0)
            throw base::InputError("fields in turn: one of the sets of points is empty; the "
                                   "others are not played in turn");
        const haptics::TransducerArray& array = arrayFor(scratch);
        next.made = _maker->make(static_cast<int>(set),
                                 still.snapshot.objects,
                                 scratch.points,
                                 assembled.absolute,
                                 array,
                                 _options.medium);
        ++_counters.solves;
        if (next.made.fields.empty()) throw base::InputError(next.made.report.message);
        next.achieved_Pa = achievedOf(array, next.made);
        return true;
    }
    return false;
}

std::shared_ptr<const HologramResult> HologramPipeline::playAllSets()
{
    StillScene& still = _still;
    auto result = std::make_shared<HologramResult>(*_last);
    std::vector<Eigen::VectorXcf> fields;
    std::vector<haptics::ControlPoints> parts;
    std::vector<haptics::SolveReport> reports;
    result->achieved_Pa.resize(0);
    result->capFactor = 1.0;
    for (const StillScene::Set& set : still.sets)
    {
        fields.insert(fields.end(), set.made.fields.begin(), set.made.fields.end());
        parts.insert(parts.end(), set.made.parts.begin(), set.made.parts.end());
        reports.push_back(set.made.report);
        const Eigen::Index n = result->achieved_Pa.size();
        result->achieved_Pa.conservativeResize(n + set.achieved_Pa.size());
        result->achieved_Pa.tail(set.achieved_Pa.size()) = set.achieved_Pa;
    }
    result->points = allOf(parts);
    result->report = haptics::together(reports);
    const haptics::DriveResolution& drive = _options.array.drive;
    if (fields.size() == still.sets.size())
    {
        haptics::orderFields(fields);
        haptics::alignFields(fields, drive);
        fields = haptics::smoothedFields(fields, _options.cycleSteps, drive);
    }
    else
        haptics::alignFields(fields, drive); // the order of subsets and of instants counts
    playInTurn(arrayFor(*result), fields, *result);
    still.setsMissing = false;
    still.submitted = false;
    result->playing = _playing;
    result->counters = _counters;
    result->messages = _messages.all();
    return result;
}

bool HologramPipeline::isOutline(const SceneSnapshot& snapshot) const
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

// Of all objects of the still scene, array frame; none where a part of one can't be felt.
std::vector<haptics::Outline> HologramPipeline::stillOutlines() const
{
    const double wavelength_m = _options.medium.wavelength(_options.array.frequency_Hz);
    std::vector<haptics::Outline> outlines;
    double points = 0.0;
    for (const HapticObject& object : _still.snapshot.objects)
    {
        const double target = object.properties.pressureInPa || !_last->absolute
                                  ? object.properties.pressure
                                  : object.properties.pressure * _last->points.targets.maxCoeff();
        for (haptics::Outline& outline :
             haptics::featureOutlines(*object.mesh,
                                      haptics::SamplerOptions().creaseAngle_rad,
                                      wavelength_m,
                                      _options.solverOptions.stop))
        {
            outline.vertices = (object.pose * outline.vertices).eval();
            outline.target = target;
            // Before anything is placed along it.
            points += haptics::pointsAlong({outline}, 0.5 * wavelength_m);
            if (points > base::kMostControlPoints ||
                !_assembler->areInside(outline.points(0.5 * wavelength_m)))
                return {};
            outlines.push_back(std::move(outline));
        }
    }
    return outlines;
}

std::shared_ptr<const HologramResult> HologramPipeline::playOutlines()
{
    StillScene& still = _still;
    still.outlineMissing = false;
    const std::vector<haptics::Outline> outlines = stillOutlines();
    if (outlines.empty()) return _last;
    if (!_outlines)
    {
        haptics::OutlineOptions options;
        options.starts = kOutlineStarts;
        options.finalists = kOutlineFinalists;
        options.threads = _options.solverOptions.threads;
        options.pool = _options.solverOptions.pool;
        options.stop = _options.solverOptions.stop;
        options.seed = _options.solverOptions.seed;
        _outlines = std::make_unique<haptics::OutlineHologram>(options);
    }
    const haptics::TransducerArray& array = arrayFor(*_last);
    Eigen::VectorXcf q;
    const haptics::OutlineReport found = _outlines->solve(outlines, array, _options.medium, q);
    ++_counters.solves;
    auto result = std::make_shared<HologramResult>(*_last);
    result->points = _outlines->points();
    result->outline = true;
    result->capFactor = 1.0;
    haptics::SolveReport& report = result->report;
    report.solver = "outline";
    report.points = result->points.size();
    report.iterations = found.corrections;
    report.rowsBuilt = report.points;
    report.matrix_ms = 0.0;
    report.solve_ms = found.solve_ms;
    report.leftOut = 0;
    report.stop = haptics::StopReason::STALLED;
    fitLevel(array, q, *result);
    _q = q;
    haptics::alignField(_q, _last->played, array.drive);
    usePlayer(_modulation.amplitudeRate_Hz > 0.0);
    play(array, *result);
    measure(array, *result);
    rate(result->points, result->achieved_Pa, result->absolute, report);
    StillScene::Set set;
    set.made.fields = {_q};
    set.made.parts = {result->points};
    set.made.modulation = _modulation;
    set.made.report = report;
    set.achieved_Pa = result->achieved_Pa;
    still.sets.front() = std::move(set);
    still.setsMissing = still.submitted = false;
    result->playing = _playing;
    result->counters = _counters;
    result->messages = _messages.all();
    return result;
}

// Curves are solved for at full amplitude: pressures in Pa and the options' loudness take it down.
void HologramPipeline::fitLevel(const haptics::TransducerArray& array,
                                Eigen::VectorXcf& q,
                                const HologramResult& result) const
{
    double share = std::min(_options.solverOptions.loudness, 1.0);
    const Eigen::VectorXd y = haptics::pressureAt(result.points.positions,
                                                  array,
                                                  _options.medium,
                                                  q,
                                                  _options.solverOptions.threads,
                                                  _options.solverOptions.stop)
                                  .cwiseAbs()
                                  .cast<double>();
    const double level = haptics::fittedLevel(y, result.points.targets);
    if (result.absolute && level > 0.0) share = std::min(share, 1.0 / level);
    if (share < 1.0) haptics::scaleField(q, static_cast<float>(share), array.drive);
}

void HologramPipeline::submitToMonitor(const HologramResult& result)
{
    auto played = std::make_shared<haptics::PlayedField>();
    for (const StillScene::Set& set : _still.sets)
        for (std::size_t k = 0; k < set.made.parts.size() && !set.made.fields.empty(); ++k)
            if (played->points.size() == 0)
            {
                played->points = set.made.parts[k];
                played->q = set.made.fields[k];
                if (result.capFactor < 1.0) played->q *= static_cast<float>(result.capFactor);
            }
            else
                haptics::append(played->others, set.made.parts[k]);
    if (played->points.size() == 0) return;
    played->array = std::make_shared<const haptics::TransducerArray>(arrayFor(result));
    played->medium = _options.medium;
    played->cycle = result.turn;
    const double wavelength_m = _options.medium.wavelength(_options.array.frequency_Hz);
    std::vector<bool> felt(_still.snapshot.objects.size(), result.points.object.empty());
    for (const int object : result.points.object)
        felt[static_cast<std::size_t>(object)] = true;
    for (std::size_t i = 0; i < felt.size(); ++i)
    {
        if (!felt[i]) continue;
        const HapticObject& object = _still.snapshot.objects[i];
        const double spacing_m =
            object.properties.spacing_m > 0.0 ? object.properties.spacing_m : wavelength_m;
        played->surfaces.push_back(
            {object.mesh, object.pose, object.properties.sampling, kFeltReach * spacing_m});
    }
    played->number = ++_still.number;
    _still.submitted = true;
    _monitor->submit(std::move(played));
}

std::shared_ptr<const HologramResult> HologramPipeline::askMonitor()
{
    if (!_monitor) return nullptr;
    if (!_still.submitted && _monitor->isWaiting()) submitToMonitor(*_last);
    const auto found = _monitor->latest();
    if (!found || found->number == _still.shown) return nullptr;
    _still.shown = found->number;
    if (!found->error.empty()) _messages.say(found->error);
    auto result = std::make_shared<HologramResult>(*_last);
    result->monitored = found;
    result->report.surface = found->surface;
    result->messages = _messages.all();
    return _last = result;
}

} // namespace midair::bridge
