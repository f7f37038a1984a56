#include "engine-bridge/pipeline/PlayedFieldMonitor.h"

#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/solvers/PhaseObjective.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr const char* kHidden = "hidden"; // what a message of reflectors is about
constexpr double kPoll_s = 0.02;          // interval of attend() while the monitor works

std::vector<haptics::FeltSurface> feltSurfaces(const std::vector<HapticObject>& objects,
                                               const haptics::ControlPoints& points,
                                               double wavelength_m)
{
    std::vector<bool> felt(objects.size(), points.object.empty());
    for (const int object : points.object)
        felt[static_cast<std::size_t>(object)] = true;
    std::vector<haptics::FeltSurface> surfaces;
    for (std::size_t i = 0; i < felt.size(); ++i)
    {
        if (!felt[i]) continue;
        const HapticObject& object = objects[i];
        const double spacing_m =
            object.properties.spacing_m > 0.0 ? object.properties.spacing_m : wavelength_m;
        surfaces.push_back({object.mesh.get(),
                            object.pose,
                            object.properties.sampling,
                            haptics::kFeltReach * spacing_m});
    }
    return surfaces;
}

} // namespace

PlayedFieldMonitor::PlayedFieldMonitor(PipelineContext& context, const RestRefiner& refiner) :
    _context(context),
    _refiner(refiner)
{
    setOptions();
}

void PlayedFieldMonitor::setOptions()
{
    const HologramOptions& options = _context.options;
    if (options.monitorInterval == _interval_s && options.solverOptions.lambda == _lambda) return;
    _interval_s = options.monitorInterval;
    _lambda = options.solverOptions.lambda;
    _monitor.reset();
    _isSubmitted = false;
    _told = _number;
    if (!(_interval_s > 0.0)) return;
    haptics::FieldMonitor::Options monitor;
    monitor.interval_s = _interval_s;
    if (_lambda >= haptics::PhaseObjective::kSmallestLambdaRel)
        monitor.certificate.lambdaRel = _lambda;
    _monitor = std::make_unique<haptics::FieldMonitor>(monitor);
}

void PlayedFieldMonitor::submit(const haptics::FieldSequence& played,
                                const std::vector<HapticObject>& objects,
                                const std::shared_ptr<const haptics::TransducerArray>& array)
{
    if (!_monitor || _isSubmitted || !_monitor->isWaiting()) return;
    auto field = std::make_shared<haptics::PlayedField>();
    for (std::size_t k = 0; k < std::min(played.parts.size(), played.fields.size()); ++k)
    {
        if (played.parts[k].size() == 0) continue;
        // No field of an evened cycle belongs to its own points, so there is nothing to certify.
        if (field->points.size() > 0 || played.evened)
        {
            haptics::append(field->others, played.parts[k]);
            continue;
        }
        field->points = played.parts[k];
        field->q = played.fields[k];
        if (played.outside) field->points.outside_Pa = played.outside->at(field->q);
    }
    if (field->points.size() + field->others.size() == 0) return;
    field->array = array;
    field->medium = _context.options.medium;
    if (played.fields.size() > 1 || played.evened) field->cycle = played.fields;
    field->isEvened = played.evened;
    field->fieldRate_Hz = played.modulation.fieldRate_Hz;
    field->surfaces =
        feltSurfaces(objects,
                     played.points(),
                     _context.options.medium.wavelength(_context.options.array.frequency_Hz));
    field->number = ++_number;
    _isSubmitted = true;
    _monitor->submit(std::move(field));
}

void PlayedFieldMonitor::settle(const HologramResult& result,
                                const SceneSnapshot& snapshot,
                                const haptics::TransducerArray& /*array*/)
{
    if (result.playing && result.points.size() > 0)
        submit(result.sequence, snapshot.objects, result.array);
}

void PlayedFieldMonitor::replace()
{
    _isSubmitted = false;
    _reflectorRms.reset();
    _since_s = _context.clock.now_s();
}

void PlayedFieldMonitor::setReflectors()
{
    if (_context.reflectors.all.empty())
        _context.messages.sayNow({base::MessageCode::REFLECTOR_LIMITED, 0, kHidden}, {});
}

bool PlayedFieldMonitor::areReflectorsUnrated() const
{
    return !_reflectorRms && !_context.reflectors.all.empty() && _context.last &&
           _context.last->foci == 0 && std::isfinite(_context.options.restAfter_s);
}

// Each reflector takes two matrices, so it waits until the field rests. The rms is the report's,
// which for targets in Pa counts the level, too.
RestStep PlayedFieldMonitor::rateReflectors()
{
    const HologramResult& last = *_context.last;
    const HologramOptions& options = _context.options;
    const haptics::ReflectorFigures figures =
        haptics::reflectorFigures(last.sequence,
                                  *last.array,
                                  last.medium,
                                  options.solverOptions.threads,
                                  options.solverOptions.stop);
    const double rms = last.report().rms;
    _reflectorRms = std::sqrt(rms * rms + figures.expectedRms * figures.expectedRms -
                              figures.rms * figures.rms);
    const int hidden = haptics::hiddenTransducers(last.points.positions, *last.array, last.medium);
    std::vector<base::Message> told;
    if (hidden > haptics::kToldHidden * last.array->size())
        told.emplace_back(
            base::MessageCode::REFLECTOR_LIMITED,
            fmt::format("reflectors hide {} of {} transducers from most points; their sound is "
                        "weak there, and no other transducers stand in for it",
                        hidden,
                        last.array->size()));
    _context.messages.sayNow({base::MessageCode::REFLECTOR_LIMITED, 0, kHidden}, told);
    RestStep step;
    step.result = std::make_shared<HologramResult>(last);
    return step;
}

RestStep PlayedFieldMonitor::attend(bool isPlaying)
{
    if (!isPlaying) return {};
    if (areReflectorsUnrated() && _context.clock.now_s() >= _since_s + _context.options.restAfter_s)
        return rateReflectors();
    if (!_monitor) return {};
    const HologramResult& last = *_context.last;
    submit(last.sequence, _refiner.snapshot().objects, last.array);
    const auto found = _monitor->latest();
    if (!found || found->number == _told) return {};
    _told = found->number;
    std::vector<base::Message> failure;
    if (!found->error.empty())
        failure.emplace_back(base::MessageCode::MONITOR_FAILED, found->error);
    _context.messages.sayNow({base::MessageCode::MONITOR_FAILED}, failure);
    RestStep step;
    step.result = std::make_shared<HologramResult>(last);
    return step;
}

std::optional<double> PlayedFieldMonitor::rest_s(bool isPlaying) const
{
    if (isPlaying && areReflectorsUnrated())
        return std::max(0.0, _since_s + _context.options.restAfter_s - _context.clock.now_s());
    const bool isPending = _monitor && (_number > _told || !_isSubmitted);
    if (isPlaying && isPending) return kPoll_s;
    return std::nullopt;
}

void PlayedFieldMonitor::report(HologramResult& result, bool /*isOtherField*/)
{
    result.sequence.report.reflectorCount = static_cast<int>(_context.reflectors.all.size());
    result.sequence.report.reflectorRms = _reflectorRms.value_or(0.0);
    result.monitored = _monitor ? _monitor->latest() : nullptr;
    // A field that is evened out has neither the surface figures of the one before nor a
    // certificate.
    if (result.monitored && result.monitored->isEvened != result.sequence.evened)
        result.monitored.reset();
    if (!result.monitored) return;
    haptics::SolveReport& report = result.sequence.report;
    report.surface = result.monitored->surface;
    report.kelvinRms = result.monitored->kelvin.rms;
    report.kelvinLevel = result.monitored->kelvin.level;
}

} // namespace midair::bridge
