#include "engine-bridge/pipeline/HologramPipeline.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/pipeline/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

namespace midair::bridge
{

HologramPipeline::HologramPipeline(HologramOptions options) : _options(std::move(options))
{
    std::string error;
    if (!_options.isValid(&error)) throw base::InputError(error);
    fillIn(_options);
    keepToLimits(_options, _messages);
    openOutput();
    PointAssembler::Options points;
    points.wavelength_m = _options.wavelength_m();
    points.motionTolerance_m = _options.motionTolerance * points.wavelength_m;
    points.maxPoints = _options.maxPoints;
    points.sets = _options.cycle;
    _assembler = std::make_unique<PointAssembler>(_options.array, points, _messages);
    haptics::ComposerOptions composer = composerOptions(_options);
    composer.line = _line;
    composer.makeSolver(); // so that an unknown name throws here
    _composer = std::make_unique<haptics::SequenceComposer>(std::move(composer), _messages);
    _refiner = std::make_unique<RestRefiner>(_options, *_assembler, *_composer, _around, _messages);
    _monitor = std::make_unique<PlayedFieldMonitor>(_options);
}

// Opens the device and sets the solver's levels, the line's rate and the cap to its ability.
void HologramPipeline::openOutput()
{
    const auto open = [this]
    {
        return _options.deviceFactory(_options.deviceUri,
                                      {_options.array.size(), _options.array.board});
    };
    _output = std::make_unique<ArrayOutput>(open, _messages);
    const device::DriveAbility ability = _output->ability();
    _line = haptics::LineRate(ability.fieldsPerSecond, ability.amplitudes.size() == 2);
    keepToLevels(_options, ability);
    const double cap_Pa = device::stricterPressure(_options.maxPressure, ability.maxPressure_Pa);
    if (!(cap_Pa > 0.0)) return;
    const auto wouldPlay = [this](const device::DriveSignal& signal)
    { return _output->wouldPlay(signal); };
    _cap = std::make_unique<PressureCap>(cap_Pa, wouldPlay, ability);
}

void HologramPipeline::setStop(const base::StopToken& stop)
{
    _options.solverOptions.stop = stop;
    _assembler->setStop(stop);
    _composer->setStop(stop);
}

std::shared_ptr<const HologramResult> HologramPipeline::process(const SceneSnapshot& snapshot,
                                                                std::uint64_t superseded)
{
    _counters.snapshots += 1 + superseded;
    _counters.superseded += superseded;
    try
    {
        if (_last && _output->isPlaying() && _assembler->unmoved(snapshot) &&
            _around.unmoved(snapshot.around))
            ++_counters.skippedUnmoved;
        else
            _last = solveAndPlay(snapshot);
    }
    catch (const base::Stopped& stopped)
    {
        _last = silent(snapshot, haptics::StopReason::STOPPED, stopped.what());
    }
    catch (const std::exception& error)
    {
        _messages.say(error.what());
        _last = silent(snapshot, haptics::StopReason::REFUSED, error.what());
    }
    return _last;
}

std::shared_ptr<const HologramResult> HologramPipeline::silent(const SceneSnapshot& snapshot,
                                                               haptics::StopReason stop,
                                                               const std::string& why)
{
    _refiner->end();
    silence();
    auto result = std::make_shared<HologramResult>();
    result->frame = snapshot.frame;
    result->latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
    result->sequence.report.stop = stop;
    result->sequence.report.message = why;
    result->sequence.report.transducers = _options.array.size();
    result->sequence.fields = {Eigen::VectorXcf::Zero(_options.array.size())};
    finish(*result);
    return result;
}

haptics::ControlPoints
HologramPipeline::assemble(const SceneSnapshot& snapshot, int set, HologramResult& result)
{
    AssembledPoints assembled = _assembler->assemble(snapshot, set);
    result.skipped = std::move(assembled.skipped);
    count(*_assembler, assembled, _counters);
    _around.begin(snapshot.around);
    _counters.outOfReach += _around.keepWithinReach(assembled.points, result.skipped);
    return std::move(assembled.points);
}

haptics::FieldSequence HologramPipeline::compose(const SceneSnapshot& snapshot,
                                                 int set,
                                                 const haptics::ControlPoints& points,
                                                 const haptics::TransducerArray& array)
{
    haptics::FieldSequence sequence;
    sequence.report.transducers = _options.array.size();
    if (points.size() == 0) return sequence;
    sequence =
        _composer->compose(set,
                           points,
                           modulationOf(snapshot.objects, points, _options.modulation, _messages),
                           array,
                           _options.medium);
    count(sequence.report, _counters);
    _updates.count(base::steadySeconds());
    if (!sequence.report.message.empty()) _messages.say(sequence.report.message);
    // The solver continued the last field of its own set, not the one that is played.
    if (_options.cycle > 1) continueLast(sequence);
    _refiner->begin(snapshot, set, sequence);
    return sequence;
}

std::shared_ptr<const HologramResult> HologramPipeline::solveAndPlay(const SceneSnapshot& snapshot)
{
    auto result = std::make_shared<HologramResult>();
    result->frame = snapshot.frame;
    const int set = _refiner->nextSet();
    _monitor->forget();
    const haptics::ControlPoints points = assemble(snapshot, set, *result);
    const haptics::TransducerArray& array =
        _around.shadowed(points, _options.array, _options.wavelength_m());
    haptics::FieldSequence sequence = compose(snapshot, set, points, array);
    cap(array, sequence, *result);
    play(std::move(sequence), *result);
    result->latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
    measure(array, *result);
    finish(*result);
    if (!_output->isPlaying())
        _refiner->end();
    else if (result->points.size() > 0)
        _monitor->submit(result->sequence, snapshot.objects, array);
    return result;
}

// A hand that shadows may be gone before the next field, so the cap must hold without it too.
void HologramPipeline::cap(const haptics::TransducerArray& array,
                           haptics::FieldSequence& sequence,
                           HologramResult& result)
{
    if (!_cap) return;
    result.maxPressure_Pa = _cap->max_Pa();
    if (sequence.isEmpty()) return;
    std::vector<const haptics::TransducerArray*> arrays{&array};
    if (&array != &_options.array) arrays.push_back(&_options.array);
    sequence.report.capFactor = _cap->hold({sequence.points().positions,
                                            arrays,
                                            _options.medium,
                                            sequence.modulation.amplitudeRate_Hz > 0.0,
                                            _options.solverOptions.threads,
                                            _options.solverOptions.stop},
                                           sequence);
    if (sequence.report.capFactor >= 1.0) return;
    ++_counters.capped;
    _messages.say(_cap->message(sequence.report.capFactor));
}

void HologramPipeline::play(haptics::FieldSequence sequence, HologramResult& result)
{
    result.points = sequence.points();
    if (sequence.isEmpty() || sequence.report.capFactor <= 0.0)
    {
        const bool failed = sequence.report.stop == haptics::StopReason::REFUSED;
        _output->silence(failed ? ArrayOutput::Silence::FAILED : ArrayOutput::Silence::WANTED);
        sequence.fields = {Eigen::VectorXcf::Zero(_options.array.size())};
    }
    else
    {
        _output->play(sequence, _options.array.size(), _options.solverOptions.stop);
        if (sequence.fields.size() > 1 && _line.isSlowerThan(_options.fieldRate))
            _messages.say(_line.message(sequence.modulation, _options.modulation));
    }
    result.sequence = std::move(sequence);
}

void HologramPipeline::continueLast(haptics::FieldSequence& sequence) const
{
    if (_last)
        haptics::continueFrom(
            _last->played(), _options.solverOptions.updateRate_Hz, _options.array.drive, sequence);
}

void HologramPipeline::measure(const haptics::TransducerArray& array, HologramResult& result) const
{
    measurePlayed(*_output, array, _options.medium, _options.solverOptions, result);
}

void HologramPipeline::finish(HologramResult& result)
{
    result.playing = _output->isPlaying();
    result.counters = _counters;
    result.updatesPerSecond = _updates.perSecond(base::steadySeconds());
    result.deviceStatus = _output->status();
    result.monitored = _monitor->latest();
    if (result.monitored) result.sequence.report.surface = result.monitored->surface;
    result.messages = _messages.all();
}

double HologramPipeline::rest_s() const
{
    if (!_output->isPlaying()) return kAttend_s;
    if (_refiner->hasWork()) return 0.0;
    return _monitor->isPending() ? kMonitorPoll_s : kAttend_s;
}

std::shared_ptr<const HologramResult> HologramPipeline::attend()
{
    if (!_last) return nullptr;
    try
    {
        if (_output->isPlaying() && _last->points.size() > 0)
        {
            if (auto result = refine()) return _last = result;
            if (auto result = askMonitor()) return _last = result;
        }
        if (auto result = lookAfterDevice()) return _last = result;
    }
    catch (const base::Stopped&)
    {
        // The thread that requested the stop silences the device, or replaces or ends this
        // pipeline.
    }
    catch (const std::exception& error)
    {
        _messages.say(error.what()); // what is played already goes on
        _refiner->end();
    }
    return nullptr;
}

std::shared_ptr<const HologramResult> HologramPipeline::refine()
{
    auto sequence = _refiner->step(_last->points, _last->sequence.modulation);
    _counters.solves += static_cast<std::uint64_t>(_refiner->takeSolves());
    if (!sequence) return nullptr;
    auto result = std::make_shared<HologramResult>(*_last);
    result->outline = sequence->isHeld();
    continueLast(*sequence);
    const haptics::TransducerArray& array =
        _around.shadowed(_last->points, _options.array, _options.wavelength_m());
    cap(array, *sequence, *result);
    play(std::move(*sequence), *result);
    _monitor->forget();
    measure(array, *result);
    finish(*result);
    return result;
}

std::shared_ptr<const HologramResult> HologramPipeline::askMonitor()
{
    if (!_monitor->isOn()) return nullptr;
    _monitor->submit(_last->sequence,
                     _refiner->snapshot().objects,
                     _around.shadowed(_last->points, _options.array, _options.wavelength_m()));
    const auto found = _monitor->takeNew();
    if (!found) return nullptr;
    if (!found->error.empty()) _messages.say(found->error);
    auto result = std::make_shared<HologramResult>(*_last);
    finish(*result);
    return result;
}

std::shared_ptr<const HologramResult> HologramPipeline::lookAfterDevice()
{
    const auto attention = _output->attend(_options.solverOptions.stop);
    if (attention == ArrayOutput::Attention::NOTHING) return nullptr;
    if (attention == ArrayOutput::Attention::RESENT) ++_counters.resent;
    auto result = std::make_shared<HologramResult>(*_last);
    measure(_around.shadowed(result->points, _options.array, _options.wavelength_m()), *result);
    finish(*result);
    return result;
}

} // namespace midair::bridge
