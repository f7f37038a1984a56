#include "engine-bridge/pipeline/HologramPipeline.h"

#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/rendering/ObjectModulation.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/ThreadPool.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

// Throws for an unknown solver name.
haptics::ComposerOptions tried(haptics::ComposerOptions options)
{
    options.makeSolver();
    return options;
}

// Returns the number of the last message reported.
std::uint64_t tellMessages(const base::MessageLog& log, HologramResult& result)
{
    const std::uint64_t changes = log.changes();
    result.messages = log.all();
    result.told = log.messages();
    return changes;
}

} // namespace

HologramPipeline::HologramPipeline(HologramOptions options) :
    _context(std::move(options)),
    _motion(_context),
    _ears(_context),
    _output(_context, _ears),
    _assembler(*_context.array, assemblerOptions(), _context.messages),
    _composer(tried(lineOptions()), _context.messages),
    _hands(_context),
    _contacts(_context, _output, _hands),
    _rest(_context, _assembler, _composer, _output, _hands),
    _fingertip(_context, _rest.refiner, _rest.louder),
    _monitor(_context, _rest.refiner)
{
    _ears.setKeeps([this] { return _output.keepsToEars(); });
    tellReflectors("", _context.reflectors.problems);
}

std::shared_ptr<const HologramResult> HologramPipeline::process(const SceneSnapshot& snapshot,
                                                                std::uint64_t superseded)
{
    _context.counters.snapshots += 1 + superseded;
    _context.counters.superseded += superseded;
    _said.before = base::MessageLog::saidNow();
    _context.paths.resize(snapshot.objects.size());
    _context.areSensations.resize(snapshot.objects.size());
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        _context.paths[i] = snapshot.objects[i].path;
        _context.areSensations[i] = snapshot.objects[i].properties.sensation.isMeant;
    }
    try
    {
        if (_changes.problem)
            throw base::CodedError(_changes.problem->code, _changes.problem->text);
        if (_context.follow(snapshot)) useReflectors();
        const SceneSnapshot* scene = &snapshot;
        bool fits = _context.last && !_changes.areNew && device().isPlaying();
        for (PipelineStage* stage : _stages)
            fits = stage->arrive(scene) && fits;
        if (fits && _assembler.unmoved(*scene))
        {
            ++_context.counters.skippedUnmoved;
            // If such snapshots never end, attend() is never called.
            if (auto result = lookAfterDevice()) _context.last = finish(std::move(result));
        }
        else
            _context.last = solveAndPlay(*scene);
        _changes.areNew = false;
    }
    catch (const base::Stopped& stopped)
    {
        _context.last = silent(snapshot, haptics::StopReason::STOPPED, stopped.what());
    }
    catch (const base::CodedError& error)
    {
        _context.messages.say({error.code, error.what()});
        _context.last = silent(snapshot, haptics::StopReason::REFUSED, error.what());
    }
    catch (...)
    {
        const std::string why = base::whatWasThrown();
        _context.messages.say({base::MessageCode::FIELD_FAILED, why});
        _context.last = silent(snapshot, haptics::StopReason::REFUSED, why);
    }
    return _context.last;
}

std::shared_ptr<const HologramResult> HologramPipeline::silent(const SceneSnapshot& snapshot,
                                                               haptics::StopReason stop,
                                                               const std::string& why)
{
    for (PipelineStage* stage : _stages)
        stage->end();
    _solved.resize(0);
    silence();
    _context.messages.endField(_said.before);
    auto result = begin(snapshot);
    result->handedOver_s = _context.clock.now_s();
    result->latency_ms = (result->handedOver_s - snapshot.time_s) * 1e3;
    result->sequence.report.stop = stop;
    result->sequence.report.message = why;
    result->sequence.report.transducers = _context.options.array.size();
    result->sequence.fields = {Eigen::VectorXcf::Zero(_context.options.array.size())};
    return finish(std::move(result));
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
    result->array = _context.array;
    result->medium = _context.options.medium;
    return result;
}

haptics::ControlPoints
HologramPipeline::assemble(const SceneSnapshot& snapshot, int set, HologramResult& result)
{
    AssembledPoints assembled = _assembler.assemble(snapshot, set);
    result.skipped = std::move(assembled.skipped);
    count(_assembler, assembled, _context.counters);
    tellReflectors(
        "near",
        reflectorsNear(_context.reflectors.all, result.skipped, _context.options.wavelength_m()));
    _hands.begin(snapshot.around);
    result.objects = std::move(assembled.objects);
    for (const int object : assembled.points.object)
        ++result.objects[static_cast<std::size_t>(object)].outOfReach;
    _context.counters.outOfReach += _hands.keepWithinReach(assembled.points, result.skipped);
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
    sequence.report.transducers = _context.options.array.size();
    if (points.size() == 0) return sequence;
    sequence = _composer.compose(
        set,
        points,
        modulationOf(snapshot.objects, points, _context.options.modulation, _context.messages),
        array,
        _context.options.medium);
    count(sequence.report, _context.counters);
    _context.updates.count(_context.clock.now_s());
    tellReport(points, sequence);
    // The solver continued the last field of its own set, not the playing one.
    if (_context.options.cycle > 1) continueLast(sequence);
    _rest.refiner.begin(snapshot, set, sequence);
    return sequence;
}

// Silence in spite of a wanted field is a fault: the array has no level that low, or can't reach
// the points.
void HologramPipeline::tellReport(const haptics::ControlPoints& points,
                                  haptics::FieldSequence& sequence)
{
    using base::MessageCode;
    haptics::SolveReport& report = sequence.report;
    const bool isRefused = report.stop == haptics::StopReason::REFUSED;
    const bool isSilence = report.stop == haptics::StopReason::NOTHING_TO_DO &&
                           points.targets.maxCoeff() > 0.0 && isSilent(sequence.fields);
    if (isSilence) report.stop = haptics::StopReason::SILENCED;
    if (isSilence) report.message = "silent: " + report.message;
    if (report.message.empty()) return;
    const auto refusal =
        isOwnSolver(report.solver) ? MessageCode::FIELD_FAILED : MessageCode::SOLVER_REFUSED;
    _context.messages.say({isSilence   ? MessageCode::FIELD_SILENCED
                           : isRefused ? refusal
                                       : MessageCode::SOLVER_REPORT,
                           report.message});
}

void HologramPipeline::continueLast(haptics::FieldSequence& sequence) const
{
    if (_context.last)
        haptics::continueFrom(_context.last->played(),
                              _context.options.solverOptions.updateRate_Hz,
                              _context.options.array.drive,
                              sequence);
}

std::shared_ptr<const HologramResult> HologramPipeline::solveAndPlay(const SceneSnapshot& snapshot)
{
    auto result = begin(snapshot);
    const int set = _rest.refiner.nextSet();
    for (PipelineStage* stage : _stages)
        stage->replace();
    const haptics::ControlPoints points = assemble(snapshot, set, *result);
    const haptics::TransducerArray& array = _hands.shadowed(points);
    haptics::FieldSequence sequence = compose(snapshot, set, points, array);
    const auto age_ms = [&] { return (_context.clock.now_s() - snapshot.time_s) * 1e3; };
    const bool goesOn = isPlayedAlready(sequence, points);
    if (!goesOn) _context.messages.endField(_said.before);
    if (goesOn)
    {
        _output.playOn(sequence, points, array, *result);
        result->latency_ms = age_ms();
    }
    else
    {
        offer(sequence);
        result->latency_ms = age_ms();
        for (PipelineStage* stage : _stages)
            if (stage->takeOver(*result)) return finish(std::move(result));
        _output.play(array, std::move(sequence), *result);
        result->latency_ms = age_ms();
        _output.measure(array, *result);
        _output.rateFromLast(*result);
    }
    auto finished = finish(std::move(result), !goesOn);
    for (PipelineStage* stage : _stages)
        stage->settle(*finished, snapshot, array);
    return finished;
}

// Offers the field of whole objects to the stages; it may continue if there is nothing else.
void HologramPipeline::offer(const haptics::FieldSequence& whole)
{
    _context.level_Pa = whole.report.level_Pa;
    bool isAll = whole.isHeld();
    for (PipelineStage* stage : _stages)
        isAll = stage->compose(whole) && isAll;
    _solved.resize(0);
    if (isAll) _solved = whole.fields.front();
}

// True if the solver found nothing that moved, and all later steps would give the same result:
// caps, ears, levels and device. Objects that came or went are out of reach or have no effect.
bool HologramPipeline::isPlayedAlready(const haptics::FieldSequence& sequence,
                                       const haptics::ControlPoints& points) const
{
    if (sequence.report.stop != haptics::StopReason::SKIPPED || !sequence.isHeld() ||
        !_context.last || _changes.areNew)
        return false;
    for (const PipelineStage* stage : _stages)
        if (!stage->mayPlayOn()) return false;
    if (!device().isPlaying() || _context.last->state != ArrayState::PLAYING ||
        _context.last->points.size() != points.size() ||
        _context.last->points.absolute != points.absolute ||
        !(sequence.modulation == _context.last->sequence.modulation))
        return false;
    const double moved_m =
        (points.positions - _context.last->points.positions).colwise().norm().maxCoeff();
    return moved_m <= _context.options.motionTolerance * _context.options.wavelength_m() &&
           sequence.fields.front() == _solved;
}

std::shared_ptr<const HologramResult> HologramPipeline::finish(std::shared_ptr<HologramResult> made,
                                                               bool isOtherField)
{
    HologramResult& result = *made;
    result.playing = device().isPlaying();
    result.deviceOpen = device().isOpen();
    result.counters = _context.counters;
    result.updatesPerSecond = _context.updates.perSecond(_context.clock.now_s());
    result.deviceStatus = device().reading().status;
    result.state = _output.stateOf(result);
    for (PipelineStage* stage : _stages)
        stage->report(result, isOtherField);
    if (!_context.last || result.state != _context.last->state) device().tell(result.state);
    device().tellOfDriver();
    device().endWhatIsOver();
    _said.told = tellMessages(_context.messages, result);
    return made;
}

double HologramPipeline::rest_s() const
{
    const bool isPlaying = device().isPlaying();
    for (const PipelineStage* stage : _stages)
        if (const auto rest_s = stage->rest_s(isPlaying)) return std::min(*rest_s, kAttend_s);
    return kAttend_s;
}

std::shared_ptr<const HologramResult> HologramPipeline::attend()
{
    if (!_context.last) return nullptr;
    try
    {
        RestStep step;
        if (!_changes.areNew) step = attendStages();
        if (!step.result && !step.isAll) step.result = lookAfterDevice();
        device().endWhatIsOver();
        if (!step.result && _context.messages.changes() == _said.told) return nullptr;
        if (!step.result)
        {
            auto same = std::make_shared<HologramResult>(*_context.last);
            _said.told = tellMessages(_context.messages, *same);
            return _context.last = same;
        }
        const bool goesOn = step.isAll && !step.isOtherField; // the device repeats its fields
        return _context.last = finish(std::move(step.result), !goesOn);
    }
    catch (const base::Stopped&)
    {
        // The thread that requested the stop silences the device, or replaces or ends this
        // pipeline.
    }
    catch (...)
    {
        _context.messages.say(
            {base::MessageCode::FIELD_REST, base::whatWasThrown()}); // the old field goes on
        _rest.end();
    }
    return nullptr;
}

// Returns the step of the first stage that produced something or blocks later ones.
RestStep HologramPipeline::attendStages()
{
    const bool isPlaying = device().isPlaying() && _context.last->points.size() > 0;
    for (PipelineStage* stage : _stages)
    {
        RestStep step = stage->attend(isPlaying);
        if (step.isOtherField)
        {
            _solved.resize(0);
            for (PipelineStage* other : _stages)
                other->replace();
        }
        if (step.field) step.result = playRefined(std::move(*step.field));
        if (step.result || step.isAll) return step;
    }
    return {};
}

std::shared_ptr<HologramResult> HologramPipeline::playRefined(haptics::FieldSequence sequence)
{
    _context.level_Pa = sequence.report.level_Pa;
    for (PipelineStage* stage : _stages)
        stage->compose(sequence);
    auto result = std::make_shared<HologramResult>(*_context.last);
    result->outline = sequence.report.solver == haptics::kOutlineSolver;
    continueLast(sequence);
    const haptics::TransducerArray& array = _hands.shadowed(_context.last->points);
    _output.play(array, std::move(sequence), *result);
    _output.measure(array, *result);
    _output.rateFromLast(*result);
    return result;
}

std::shared_ptr<HologramResult> HologramPipeline::lookAfterDevice()
{
    if (!_output.attend(_changes.areNew)) return nullptr;
    auto result = std::make_shared<HologramResult>(*_context.last);
    _output.measure(_hands.shadowed(result->points), *result);
    return result;
}

// How a HologramPipeline changes its options while its device stays open.

PointAssembler::Options HologramPipeline::assemblerOptions() const
{
    PointAssembler::Options points;
    points.wavelength_m = _context.options.wavelength_m();
    points.motionTolerance_m = _context.options.motionTolerance * points.wavelength_m;
    points.maxPoints = _context.options.maxPoints;
    points.sets = _context.options.cycle;
    points.loudness = _context.options.solverOptions.loudness;
    points.medium = _context.options.medium;
    points.render = _context.options.contacts.shares.render;
    return points;
}

haptics::ComposerOptions HologramPipeline::lineOptions() const
{
    haptics::ComposerOptions composer = composerOptions(_context.options);
    composer.line = _output.line();
    return composer;
}

void HologramPipeline::setStop(const base::StopToken& stop)
{
    _context.options.solverOptions.stop = stop;
    _assembler.setStop(stop);
    _composer.setStop(stop);
    _rest.setOptions();
}

void HologramPipeline::reconfigure(HologramOptions options)
{
    _changes.areNew = true;
    for (const base::Message& note : options.notes)
        _context.messages.say(note);
    if (isStricter(options)) silence();
    try
    {
        useOptions(std::move(options));
        _changes.problem.reset();
    }
    catch (const base::CodedError& error)
    {
        _changes.problem = base::Message(error.code, error.what());
    }
    catch (...)
    {
        _changes.problem = base::Message(base::MessageCode::SCENE_CLOSED, base::whatWasThrown());
    }
    if (_changes.problem)
    {
        _rest.end();
        silence();
    }
}

void HologramPipeline::useOptions(HologramOptions options)
{
    options.array = _context.options.array;
    options.deviceUri = _context.options.deviceUri;
    options.deviceFactory = _context.options.deviceFactory;
    options.owner = _context.options.owner;
    options.solverOptions.stop = _context.options.solverOptions.stop;
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    fillIn(options);
    if (!options.solverOptions.pool && std::min(options.solverOptions.threads, base::coreCount()) ==
                                           _context.options.solverOptions.threads)
        options.solverOptions.pool = _context.options.solverOptions.pool;
    keepToLimits(options, _context.messages);
    if (!options.solverFactory(options.solver, options.solverOptions))
        throw noSolver(options.solver);

    const bool otherSolver = options.solver != _context.options.solver;
    _context.options = std::move(options);
    _output.setCaps();
    useParts(otherSolver);
}

// Passes the options to everything that was made from the previous ones.
void HologramPipeline::useParts(bool otherSolver)
{
    _assembler.setOptions(*_context.array, assemblerOptions());
    _composer.setOptions(lineOptions(), otherSolver);
    for (PipelineStage* stage : _stages)
        stage->setOptions();
}

// The composer's solvers make their rows anew when they get the array.
void HologramPipeline::useReflectors()
{
    _changes.areNew = true;
    _assembler.setOptions(*_context.array, assemblerOptions());
    for (PipelineStage* stage : _stages)
        stage->setReflectors();
    tellReflectors("", _context.reflectors.problems);
    _output.keepCaps();
}

void HologramPipeline::tellReflectors(const std::string& about,
                                      const std::vector<std::string>& problems)
{
    std::vector<base::Message> told;
    told.reserve(problems.size());
    for (const std::string& problem : problems)
        told.emplace_back(base::MessageCode::REFLECTOR_LIMITED, problem);
    _context.messages.sayNow({base::MessageCode::REFLECTOR_LIMITED, 0, about}, told);
}

bool HologramPipeline::isOpenedNow()
{
    if (!device().tryAgain()) return false;
    _output.useAbility();
    useParts(false);
    _changes.areNew = true;
    return true;
}

} // namespace midair::bridge
