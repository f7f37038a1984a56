#include "engine-bridge/pipeline/HologramPipeline.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/rendering/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/MessageCode.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

HologramPipeline::HologramPipeline(HologramOptions options) : _options(std::move(options))
{
    std::string error;
    if (!_options.isValid(&error)) throw base::InputError(error);
    fillIn(_options);
    for (const base::Message& note : _options.notes)
        _messages.say(note);
    keepToLimits(_options, _messages);
    tellOfDeath();
    openOutput();
    _array = std::make_shared<haptics::TransducerArray>(_options.array);
    _assembler = std::make_unique<PointAssembler>(_options.array, assemblerOptions(), _messages);
    haptics::ComposerOptions composer = lineOptions();
    composer.makeSolver(); // so that an unknown name throws here
    _composer = std::make_unique<haptics::SequenceComposer>(std::move(composer), _messages);
    _refiner = std::make_unique<RestRefiner>(_options, *_assembler, *_composer, _around, _messages);
    _monitor = std::make_unique<PlayedFieldMonitor>(_options);
    makeContacts();
}

// Opens the device. A second try is made in another thread, so it has options of its own.
void HologramPipeline::openOutput()
{
    const auto open = [factory = _options.deviceFactory,
                       uri = _options.deviceUri,
                       layout = device::DeviceLayout{
                           _options.array.size(), _options.array.board, _options.array.dead}] {
        return factory(uri, layout);
    };
    _output = std::make_unique<ArrayOutput>(open, _messages, _options.reopen_s);
    setEars();
    useAbility();
}

// Sets the levels, the ringing, the line's rate and the cap to what the device can do.
void HologramPipeline::useAbility()
{
    const device::DriveAbility ability = _output->ability();
    _line = haptics::LineRate(ability.fieldsPerSecond,
                              ability.amplitudes.size() == 2,
                              ability.sequenceFields,
                              ability.sequenceClock_Hz);
    keepToLevels(_options, ability);
    setCaps();
}

void HologramPipeline::setStop(const base::StopToken& stop)
{
    _options.solverOptions.stop = stop;
    _assembler->setStop(stop);
    _composer->setStop(stop);
    _refiner->setStop(stop);
}

std::shared_ptr<const HologramResult> HologramPipeline::process(const SceneSnapshot& snapshot,
                                                                std::uint64_t superseded)
{
    _counters.snapshots += 1 + superseded;
    _counters.superseded += superseded;
    try
    {
        if (!_invalid.empty()) throw base::CodedError(base::MessageCode::SCENE_CLOSED, _invalid);
        _earsMoved = hasMovedEars(snapshot);
        const SceneSnapshot& scene = shared(snapshot);
        if (_last && !_changed && !_earsMoved && _output->isPlaying() &&
            _assembler->unmoved(scene) && _around.unmoved(scene.around))
        {
            ++_counters.skippedUnmoved;
            // Where such snapshots never end, attend() is never called.
            if (auto result = lookAfterDevice()) _last = std::move(result);
        }
        else
            _last = solveAndPlay(scene);
        _changed = false;
    }
    catch (const base::Stopped& stopped)
    {
        _last = silent(snapshot, haptics::StopReason::STOPPED, stopped.what());
    }
    catch (const base::CodedError& error)
    {
        _messages.say({error.code, error.what()});
        _last = silent(snapshot, haptics::StopReason::REFUSED, error.what());
    }
    catch (...)
    {
        const std::string why = base::whatWasThrown();
        _messages.say({base::MessageCode::FIELD_FAILED, why});
        _last = silent(snapshot, haptics::StopReason::REFUSED, why);
    }
    return _last;
}

std::shared_ptr<const HologramResult> HologramPipeline::silent(const SceneSnapshot& snapshot,
                                                               haptics::StopReason stop,
                                                               const std::string& why)
{
    _refiner->end();
    _contacts->clear();
    _playsContacts = false;
    _solved.resize(0);
    silence();
    auto result = begin(snapshot);
    result->handedOver_s = base::steadySeconds();
    result->latency_ms = (result->handedOver_s - snapshot.time_s) * 1e3;
    result->sequence.report.stop = stop;
    result->sequence.report.message = why;
    result->sequence.report.transducers = _options.array.size();
    result->sequence.fields = {Eigen::VectorXcf::Zero(_options.array.size())};
    finish(*result);
    return result;
}

std::shared_ptr<HologramResult> HologramPipeline::begin(const SceneSnapshot& snapshot) const
{
    auto result = std::make_shared<HologramResult>();
    result->frame = snapshot.frame;
    result->simulationTime_s = snapshot.simulationTime_s;
    result->worldToArray = snapshot.worldToArray;
    result->origins.reserve(snapshot.objects.size());
    for (const HapticObject& object : snapshot.objects)
        result->origins.push_back(object.origin);
    result->array = _array;
    result->medium = _options.medium;
    return result;
}

// The array with shadows is the caller's until its next call, so that the result needs a copy.
void HologramPipeline::keepArray(const haptics::TransducerArray& array,
                                 HologramResult& result) const
{
    result.array = &array == &_options.array
                       ? _array
                       : std::make_shared<const haptics::TransducerArray>(array);
}

haptics::ControlPoints
HologramPipeline::assemble(const SceneSnapshot& snapshot, int set, HologramResult& result)
{
    AssembledPoints assembled = _assembler->assemble(snapshot, set);
    result.skipped = std::move(assembled.skipped);
    count(*_assembler, assembled, _counters);
    _around.begin(snapshot.around);
    result.objects = std::move(assembled.objects);
    for (const int object : assembled.points.object)
        ++result.objects[static_cast<std::size_t>(object)].outOfReach;
    _counters.outOfReach += _around.keepWithinReach(assembled.points, result.skipped);
    for (const int object : assembled.points.object)
        --result.objects[static_cast<std::size_t>(object)].outOfReach;
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
    tellReport(points, sequence);
    // The solver continued the last field of its own set, not the one that is played.
    if (_options.cycle > 1) continueLast(sequence);
    _refiner->begin(snapshot, set, sequence);
    return sequence;
}

std::shared_ptr<const HologramResult> HologramPipeline::solveAndPlay(const SceneSnapshot& snapshot)
{
    auto result = begin(snapshot);
    const int set = _refiner->nextSet();
    _monitor->forget();
    const haptics::ControlPoints points = assemble(snapshot, set, *result);
    const haptics::TransducerArray& array =
        _around.shadowed(points, _options.array, _options.wavelength_m());
    haptics::FieldSequence sequence = compose(snapshot, set, points, array);
    if (isPlayedAlready(sequence, points))
    {
        playOn(sequence, points, array, *result);
        result->latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
        finish(*result, false);
        _monitor->submit(result->sequence, snapshot.objects, array);
        return result;
    }
    _solved.resize(0);
    if (sequence.isHeld() && !_hasContacts) _solved = sequence.fields.front();
    if (_hasContacts) _whole = sequence;
    if (rendersContacts())
    {
        result->latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
        return playContacts(std::move(result));
    }
    _playsContacts = false;
    if (_hasContacts) result->touched = std::make_shared<const ContactScene>(_contacts->view());
    cap(array, sequence, *result);
    play(std::move(sequence), *result);
    result->latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
    measure(array, *result);
    rateFromLast(*result);
    finish(*result);
    if (!_output->isPlaying())
        _refiner->end();
    else if (result->points.size() > 0)
        _monitor->submit(result->sequence, snapshot.objects, array);
    return result;
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
        std::vector<device::DriveSignal> drives = std::move(_proven.drives);
        if (drives.empty())
            drives = drivesOf(sequence.fields, _options.array.size(), _options.array.dead);
        _output->play(std::move(drives), sequence.modulation, _options.solverOptions.stop);
        const bool isStored = _line.isSlowerThan(sequence.modulation.fieldRate_Hz);
        if (sequence.fields.size() > 1 && _line.isSlowerThan(_options.fieldRate) && !isStored)
            _messages.say({base::MessageCode::DEVICE_SLOW,
                           _line.message(sequence.modulation, _options.modulation)});
    }
    result.handedOver_s = base::steadySeconds();
    result.sequence = std::move(sequence);
}

// True if the solver has found nothing that moved, and all that follows would be as it was: caps,
// ears, levels and the device. What came and went is out of reach then, or of no effect.
bool HologramPipeline::isPlayedAlready(const haptics::FieldSequence& sequence,
                                       const haptics::ControlPoints& points) const
{
    if (sequence.report.stop != haptics::StopReason::SKIPPED || !sequence.isHeld() || !_last ||
        _changed || _earsMoved || _hasContacts || _playsContacts || _refiner->hasWork())
        return false;
    if (!_output->isPlaying() || _last->state != ArrayState::PLAYING ||
        _last->points.size() != points.size() || _last->points.absolute != points.absolute ||
        !(sequence.modulation == _last->sequence.modulation))
        return false;
    const double moved_m = (points.positions - _last->points.positions).colwise().norm().maxCoeff();
    return moved_m <= _options.motionTolerance * _options.wavelength_m() &&
           sequence.fields.front() == _solved;
}

// Takes over what is played and its figures. Where snapshots follow each other there is no
// attend(), so the device is looked after here.
void HologramPipeline::playOn(const haptics::FieldSequence& sequence,
                              haptics::ControlPoints points,
                              const haptics::TransducerArray& array,
                              HologramResult& result)
{
    // Where they were solved for, or many small steps would go unseen.
    points.positions = _last->points.positions;
    result.array = _last->array;
    result.maxPressure_Pa = _last->maxPressure_Pa;
    result.achieved_Pa = _last->achieved_Pa;
    result.handedOver_s = _last->handedOver_s;
    result.sequence = _last->sequence;
    result.sequence.parts = {points};
    result.points = std::move(points);
    haptics::SolveReport& report = result.sequence.report;
    if (report.capFactor < 1.0) ++_counters.capped;
    report.stop = sequence.report.stop;
    report.rowsBuilt = report.iterations = 0;
    report.matrix_ms = report.solve_ms = 0.0;
    report.meanPhaseStep_rad = report.driveChange = report.audibleChange = 0.0;
    report.levelJump = sequence.report.levelJump;
    report.ringingShare = sequence.report.ringingShare;
    const auto attention = _output->attend(_options.solverOptions.stop);
    if (attention == ArrayOutput::Attention::RESENT) ++_counters.resent;
    if (attention != ArrayOutput::Attention::NOTHING || !isMeasured()) measure(array, result);
}

void HologramPipeline::continueLast(haptics::FieldSequence& sequence) const
{
    if (_last)
        haptics::continueFrom(
            _last->played(), _options.solverOptions.updateRate_Hz, _options.array.drive, sequence);
}

void HologramPipeline::measure(const haptics::TransducerArray& array, HologramResult& result)
{
    keepArray(array, result);
    const std::vector<Eigen::VectorXcf> wanted = result.sequence.fields;
    if (measurePlayed(
            *_output, array, _options.medium, _options.solverOptions, _proven.held, result))
        return;
    const bool modulated = result.sequence.modulation.amplitudeRate_Hz > 0.0;
    tellOfSilence(where(array, result.points.positions, modulated), wanted, result.sequence.report);
}

// A solver knows neither the cap nor the fields of other solvers, as the sets of a cycle have them:
// its step and its jump of the level are those between its own fields.
void HologramPipeline::rateFromLast(HologramResult& result) const
{
    if (!_last) return;
    haptics::SolveReport& report = result.sequence.report;
    const double before_Pa = _last->report().level_Pa;
    const bool isJump = report.level_Pa > 0.0 && before_Pa > 0.0;
    report.levelJump =
        isJump ? std::max(report.level_Pa / before_Pa, before_Pa / report.level_Pa) : 0.0;
    const double rate_Hz = _options.solverOptions.updateRate_Hz;
    haptics::rateSwitch(_last->played(), rate_Hz, _options.array.ringing_s, result.sequence);
    const bool isCapped = report.capFactor < 1.0 || _last->report().capFactor < 1.0;
    if (isCapped && result.sequence.isHeld() && _last->sequence.isHeld())
        haptics::rateStep(_last->played(), rate_Hz, result.sequence);
}

ArrayState HologramPipeline::stateOf(const HologramResult& result)
{
    const ArrayState state = _output->state();
    const bool isNothing =
        state == ArrayState::PLAYING && (_isDead || result.isSilenced() || !_output->sounds());
    _output->judge(isNothing ? ArrayState::SILENT : state);
    return isNothing ? ArrayState::SILENT : state;
}

void HologramPipeline::finish(HologramResult& result, bool isOtherField)
{
    result.playing = _output->isPlaying();
    result.deviceOpen = _output->isOpen();
    result.counters = _counters;
    result.updatesPerSecond = _updates.perSecond(base::steadySeconds());
    result.deviceStatus = _output->status();
    result.state = stateOf(result);
    const double now_s = base::steadySeconds();
    const bool sounds = result.state == ArrayState::PLAYING;
    if (isOtherField || !_last || result.state != _last->state)
        _ears.play(sounds ? result.sequence.fields : std::vector<Eigen::VectorXcf>(), now_s);
    result.exposure = _ears.reading(now_s);
    if (!_last || result.state != _last->state) _output->tell(result.state);
    _output->tellOfDriver();
    result.monitored = _monitor->latest();
    if (result.monitored)
    {
        haptics::SolveReport& report = result.sequence.report;
        report.surface = result.monitored->surface;
        report.kelvinRms = result.monitored->kelvin.rms;
        report.kelvinLevel = result.monitored->kelvin.level;
    }
    result.messages = _messages.all();
    result.told = _messages.messages();
}

} // namespace midair::bridge
