#include "engine-bridge/pipeline/PlayedFieldMonitor.h"

#include "haptics/points/FeltPlaces.h"
#include "haptics/solvers/PhaseObjective.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

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

PlayedFieldMonitor::PlayedFieldMonitor(const HologramOptions& options) : _options(options)
{
    optionsChanged();
}

void PlayedFieldMonitor::optionsChanged()
{
    if (_options.monitorInterval == _interval_s && _options.solverOptions.lambda == _lambda) return;
    _interval_s = _options.monitorInterval;
    _lambda = _options.solverOptions.lambda;
    _monitor.reset();
    _submitted = false;
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
                                const haptics::TransducerArray& array)
{
    if (!_monitor || _submitted || !_monitor->isWaiting()) return;
    auto field = std::make_shared<haptics::PlayedField>();
    for (std::size_t k = 0; k < std::min(played.parts.size(), played.fields.size()); ++k)
    {
        if (played.parts[k].size() == 0) continue;
        // No field of an evened cycle is for its own points, so there is nothing to certify.
        if (field->points.size() > 0 || played.evened)
        {
            haptics::append(field->others, played.parts[k]);
            continue;
        }
        field->points = played.parts[k];
        field->q = played.fields[k];
    }
    if (field->points.size() + field->others.size() == 0) return;
    field->array = std::make_shared<const haptics::TransducerArray>(array);
    field->medium = _options.medium;
    if (played.fields.size() > 1) field->cycle = played.fields;
    field->fieldRate_Hz = played.modulation.fieldRate_Hz;
    field->surfaces = feltSurfaces(
        objects, played.points(), _options.medium.wavelength(_options.array.frequency_Hz));
    field->number = ++_number;
    _submitted = true;
    _monitor->submit(std::move(field));
}

std::shared_ptr<const haptics::FieldMonitor::Result> PlayedFieldMonitor::latest() const
{
    return _monitor ? _monitor->latest() : nullptr;
}

std::shared_ptr<const haptics::FieldMonitor::Result> PlayedFieldMonitor::takeNew()
{
    auto found = latest();
    if (!found || found->number == _told) return nullptr;
    _told = found->number;
    return found;
}

} // namespace midair::bridge
