// HologramPipeline: fields that are played in turn.
#include "device/DriveEncoder.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/propagation/AudibleChange.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <stdexcept>

namespace midair::bridge
{

HologramPipeline::~HologramPipeline()
{
    silenceDevice();
}

void HologramPipeline::prepareTurns()
{
    FieldMaker::Options options;
    options.subsets = _options.subsets;
    options.modulation = _options.modulation;
    if (_device) options.line = _line = LineRate(_device->ability());
    options.makeSolver = [this](bool absolute)
    {
        haptics::SolverOptions solver = _options.solverOptions;
        solver.absoluteTargets = absolute;
        auto made = _options.solverFactory(_options.solver, solver);
        if (!made) throw base::InputError("no solver \"" + _options.solver + "\"");
        return made;
    };
    options.makeSolver(false); // an unknown name is told now
    _maker = std::make_unique<FieldMaker>(std::move(options), _messages);
    _still.sets.resize(static_cast<std::size_t>(_options.cycle));
    if (!(_options.monitorInterval_s > 0.0)) return;
    haptics::FieldMonitor::Options monitor;
    monitor.interval_s = _options.monitorInterval_s;
    if (_options.solverOptions.lambdaRel >= 1e-5)
        monitor.certificate.lambdaRel = _options.solverOptions.lambdaRel;
    _monitor = std::make_unique<haptics::FieldMonitor>(monitor);
}

int HologramPipeline::nextSet()
{
    const int set = _still.next;
    _still.next = (set + 1) % _options.cycle;
    _still.current = false;
    return set;
}

// The thread that plays in turn is there only while it is needed.
void HologramPipeline::usePlayer(bool inTurn)
{
    const std::lock_guard<std::mutex> lock(_sending);
    if (!inTurn)
        _player.reset();
    else if (!_player && _device)
        _player = std::make_unique<FieldPlayer>(*_device);
    if (_player) _holds = false;
}

void HologramPipeline::handToPlayer(const std::vector<Eigen::VectorXcf>& fields)
{
    const std::lock_guard<std::mutex> lock(_sending);
    _options.solverOptions.stop.throwIfRequested(); // as in sendSignal()
    _player->play(fields, _modulation);
}

void HologramPipeline::playMade(const haptics::TransducerArray& array,
                                MadeFields& made,
                                HologramResult& result)
{
    _modulation = made.modulation;
    if (made.fields.size() == 1)
    {
        _q = made.fields.front();
        if (_options.cycle > 1 && _last && _last->played.size() == _q.size())
        {
            // The solver compares with its own last field, which was for another set.
            haptics::alignField(_q, _last->played, array.drive);
            const haptics::CycleSteps step = haptics::cycleSteps({_last->played, _q});
            result.report.meanPhaseStep_rad = step.meanPhaseStep_rad;
            result.report.driveChange = step.driveChange;
            result.report.audibleChange =
                step.driveChange * haptics::audibleShare(_options.solverOptions.updateRate_Hz);
        }
        usePlayer(_modulation.amplitudeRate_Hz > 0.0);
        play(array, result);
        return;
    }
    result.points = allOf(made.parts);
    result.achieved_Pa = achievedOf(array, made);
    playInTurn(array, made.fields, result);
}

Eigen::VectorXf HologramPipeline::achievedOf(const haptics::TransducerArray& array,
                                             const MadeFields& made) const
{
    Eigen::VectorXf achieved_Pa;
    for (std::size_t k = 0; k < made.parts.size(); ++k)
    {
        const Eigen::VectorXf part = haptics::pressureAt(made.parts[k].positions,
                                                         array,
                                                         _options.medium,
                                                         made.fields[k],
                                                         _options.solverOptions.threads,
                                                         _options.solverOptions.stop)
                                         .cwiseAbs();
        achieved_Pa.conservativeResize(achieved_Pa.size() + part.size());
        achieved_Pa.tail(part.size()) = part;
    }
    return achieved_Pa;
}

void HologramPipeline::playInTurn(const haptics::TransducerArray& array,
                                  const std::vector<Eigen::VectorXcf>& fields,
                                  HologramResult& result)
{
    std::vector<Eigen::VectorXcf> played = fields;
    if (_cap) result.capFactor = _cap->holdAll(whereCapHolds(array, result), played);
    noteCap(result);
    result.turn.clear();
    result.achieved_Pa *= static_cast<float>(result.capFactor);
    result.report.level_Pa *= result.capFactor;
    result.report.loudness *= result.capFactor;
    result.played.setZero(_options.array.size());
    if (result.capFactor <= 0.0) return silenceDevice();
    for (const Eigen::VectorXcf& q : played)
    {
        if (q.size() != _options.array.size() ||
            !device::encode(q.data(), static_cast<int>(q.size()), _signal))
            throw std::runtime_error(
                "solver gave activations that are not finite; nothing is played");
        result.turn.push_back(wouldPlay(_signal));
    }
    result.played = result.turn.front();
    result.fieldRate_Hz = _modulation.fieldRate_Hz;
    if (_line.isSlowerThan(_options.modulation.fieldRate_Hz))
        _messages.say("fields in turn follow each other at " +
                      base::shortNumber(_modulation.fieldRate_Hz) + " a second, not " +
                      base::shortNumber(_options.modulation.fieldRate_Hz) +
                      ": the device carries " + _line.text());
    const haptics::CycleSteps steps = haptics::cycleSteps(played);
    result.report.meanPhaseStep_rad = steps.meanPhaseStep_rad;
    result.report.driveChange = steps.driveChange;
    result.report.audibleChange =
        steps.driveChange * haptics::audibleShare(_modulation.fieldRate_Hz);
    usePlayer(true);
    if (_player) handToPlayer(played);
}

void HologramPipeline::remember(const SceneSnapshot& snapshot,
                                int set,
                                MadeFields& made,
                                const HologramResult& result)
{
    StillScene& still = _still;
    still.setsMissing = _options.cycle > 1;
    still.outlineMissing = isOutline(snapshot);
    still.submitted = false;
    still.current =
        _playing && !made.fields.empty() && (still.setsMissing || still.outlineMissing || _monitor);
    if (!still.current) return;
    still.snapshot = snapshot;
    for (StillScene::Set& other : still.sets)
        other.made.fields.clear();
    StillScene::Set& own = still.sets[static_cast<std::size_t>(set)];
    own.made = std::move(made);
    own.achieved_Pa = result.achieved_Pa;
    if (_monitor && _monitor->isWaiting()) submitToMonitor(result);
}

} // namespace midair::bridge
