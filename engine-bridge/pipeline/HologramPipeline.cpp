#include "engine-bridge/pipeline/HologramPipeline.h"

#include "device/DriveEncoder.h"
#include "device/GuardedDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace midair::bridge
{

namespace
{

constexpr int kMostFields = 64;
constexpr int kMostCycleSteps = 16;

} // namespace

bool HologramOptions::isValid(std::string* error) const
{
    auto fail = [error](const std::string& what)
    {
        if (error) *error = what;
        return false;
    };
    if (array.size() == 0)
        return fail("array \"" + array.name + "\" has no transducers, should have at least one");
    if (!medium.isValid(error)) return false;
    if (!(motionTolerance >= 0.0))
        return fail("motionTolerance is " + base::shortNumber(motionTolerance) +
                    " wavelengths, should be at least 0");
    if (maxPoints < 0)
        return fail("maxPoints is " + std::to_string(maxPoints) + ", should be at least 0");
    if (!(maxPressure_Pa >= 0.0 && maxPressure_Pa <= 1e6))
        return fail("maxPressure_Pa is " + base::shortNumber(maxPressure_Pa) +
                    ", should be 0 (none) to 1e6");
    if (!(maxAmplitude >= 0.0 && maxAmplitude <= 1.0))
        return fail("maxAmplitude is " + std::to_string(maxAmplitude) + ", should be 0 to 1");
    if (cycle < 1 || cycle > kMostFields)
        return fail("cycle is " + std::to_string(cycle) + " fields, should be 1 to 64");
    if (cycleSteps < 0 || cycleSteps > kMostCycleSteps)
        return fail("cycleSteps is " + std::to_string(cycleSteps) + ", should be 0 to 16");
    if (subsets < 1 || subsets > kMostFields)
        return fail("subsets is " + std::to_string(subsets) + ", should be 1 to 64");
    if (!(monitorInterval_s >= 0.0 && monitorInterval_s <= 1e6))
        return fail("monitorInterval_s is " + base::shortNumber(monitorInterval_s) +
                    ", should be 0 (never) to 1e6");
    if (!modulation.isValid(error)) return false;
    return solverOptions.isValid(error);
}

namespace
{

Eigen::VectorXcf vectorOf(const std::vector<std::complex<float>>& q)
{
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

} // namespace

HologramPipeline::HologramPipeline(HologramOptions options) : _options(std::move(options))
{
    std::string error;
    if (!_options.isValid(&error)) throw base::InputError(error);
    keepToLimits();
    if (!_options.solverFactory)
        _options.solverFactory = [](const std::string& name, const haptics::SolverOptions& o)
        { return haptics::makeSolver(name, o); };
    if (!_options.deviceFactory)
    {
        device::SafetyLimits limits;
        limits.maxPressure_Pa = _options.maxPressure_Pa;
        limits.maxAmplitude = _options.maxAmplitude;
        _options.deviceFactory = [limits, owner = _options.owner](
                                     const std::string& uri, const device::DeviceLayout& layout)
        {
            // Its first refused field would end the show.
            if (device::playsByItself(uri))
                throw device::DeviceError("device \"" + uri +
                                          "\": a recording takes no fields of a scene; play it "
                                          "with midair-device play FILE");
            return device::openLimitedDevice(uri, layout, limits, owner);
        };
    }
    if (_options.solver.empty() && !haptics::solverNames().empty())
        _options.solver = haptics::solverNames().front();
    PointAssembler::Options points;
    points.wavelength_m = _options.medium.wavelength(_options.array.frequency_Hz);
    points.motionTolerance_m = _options.motionTolerance * points.wavelength_m;
    points.maxPoints = _options.maxPoints;
    points.sets = _options.cycle;
    _assembler = std::make_unique<PointAssembler>(_options.array, points, _messages);
    openDevice();
    prepareTurns();
}

void HologramPipeline::openDevice()
{
    try
    {
        _device = _options.deviceFactory(_options.deviceUri,
                                         {_options.array.size(), _options.array.board});
    }
    catch (const std::exception& error)
    {
        _deviceError = error.what();
        _messages.say(_deviceError);
    }
    // The solver is to know what can be played at all.
    const device::DriveAbility ability = _device ? _device->ability() : device::DriveAbility();
    _options.array.drive.phaseLevels = ability.phaseLevels;
    _options.array.drive.amplitudeLevels =
        ability.amplitudes.empty() ? device::amplitudeLevels() : ability.amplitudes;
    const double cap_Pa = device::stricterPressure(_options.maxPressure_Pa, ability.maxPressure_Pa);
    if (cap_Pa > 0.0)
        _cap = std::make_unique<PressureCap>(
            cap_Pa,
            [this](const device::DriveSignal& signal) { return wouldPlay(signal); },
            ability);
}

std::shared_ptr<const HologramResult> HologramPipeline::process(const SceneSnapshot& snapshot,
                                                                std::uint64_t superseded)
{
    _counters.snapshots += 1 + superseded;
    _counters.superseded += superseded;
    try
    {
        if (_last && _playing && _assembler->unmoved(snapshot) && _around.unmoved(snapshot.around))
            ++_counters.skippedUnmoved;
        else
            _last = solveAndPlay(snapshot);
    }
    catch (const base::Stopped&)
    {
        _last = stopped(snapshot);
    }
    catch (const std::exception& error)
    {
        _last = refuse(snapshot, error.what());
    }
    return _last;
}

std::shared_ptr<const HologramResult> HologramPipeline::refuse(const SceneSnapshot& snapshot,
                                                               const std::string& why)
{
    silence();
    _messages.say(why);
    auto result = std::make_shared<HologramResult>();
    result->report.stop = haptics::StopReason::REFUSED;
    result->report.message = why;
    result->report.transducers = _options.array.size();
    result->played.setZero(_options.array.size());
    finish(snapshot, *result);
    return result;
}

std::shared_ptr<const HologramResult> HologramPipeline::solveAndPlay(const SceneSnapshot& snapshot)
{
    auto result = std::make_shared<HologramResult>();
    result->played.setZero(_options.array.size());
    const int set = nextSet();
    AssembledPoints assembled = _assembler->assemble(snapshot, set);
    result->points = std::move(assembled.points);
    result->skipped = std::move(assembled.skipped);
    result->absolute = assembled.absolute;
    _counters.sampled = _assembler->sampled();
    _counters.followed = _assembler->followed();
    _counters.outOfWorkspace += assembled.outOfWorkspace;
    _counters.overBudget += assembled.overBudget;
    _counters.crowded += assembled.crowded;
    _counters.unpainted += assembled.unpainted;
    _around.begin(snapshot.around);
    _counters.outOfReach += _around.keepWithinReach(result->points, result->skipped);
    _playing = true;
    if (result->points.size() == 0)
    {
        silenceDevice();
        result->report.stop = haptics::StopReason::NOTHING_TO_DO;
        result->report.transducers = _options.array.size();
        result->played.setZero(_options.array.size());
        finish(snapshot, *result);
        return result;
    }
    const haptics::TransducerArray& array = arrayFor(*result);
    MadeFields made = _maker->make(
        set, snapshot.objects, result->points, assembled.absolute, array, _options.medium);
    result->report = made.report;
    ++_counters.solves;
    const int built = made.report.rowsBuilt;
    _counters.rowsBuilt += static_cast<std::uint64_t>(built);
    _counters.rowsKept += static_cast<std::uint64_t>(std::max(0, made.report.points - built));
    _solveTimes_s.push_back(base::steadySeconds());
    if (!result->report.message.empty()) _messages.say(result->report.message);
    if (result->report.stop == haptics::StopReason::REFUSED)
        silence();
    else
        playMade(array, made, *result);
    finish(snapshot, *result);
    if (made.fields.size() < 2) measure(array, *result);
    remember(snapshot, set, made, *result);
    return result;
}

const haptics::TransducerArray& HologramPipeline::arrayFor(const HologramResult& result)
{
    return _around.shadowed(
        result.points, _options.array, _options.medium.wavelength(_options.array.frequency_Hz));
}

PressureCap::Where HologramPipeline::whereCapHolds(const haptics::TransducerArray& array,
                                                   const HologramResult& result) const
{
    // A hand that shadows may be gone before the next field, so the cap holds without it too.
    std::vector<const haptics::TransducerArray*> arrays{&array};
    if (&array != &_options.array) arrays.push_back(&_options.array);
    return {result.points.positions,
            arrays,
            _options.medium,
            _modulation.amplitudeRate_Hz > 0.0,
            _options.solverOptions.threads,
            _options.solverOptions.stop};
}

void HologramPipeline::noteCap(HologramResult& result)
{
    if (result.capFactor >= 1.0) return;
    ++_counters.capped;
    const std::string cap = base::shortNumber(_cap->max_Pa()) + " Pa at any control point";
    _messages.say(result.capFactor > 0.0
                      ? "the field is held down to the cap of " + cap
                      : "silent: the device's levels can't keep to the cap of " + cap);
}

void HologramPipeline::holdToCap(const haptics::TransducerArray& array, HologramResult& result)
{
    CappedField field = _cap->hold(whereCapHolds(array, result), _signal);
    result.capFactor = field.factor;
    result.played = std::move(field.played);
    result.achieved_Pa = std::move(field.achieved_Pa);
    if (field.factor < 1.0) rate(result.points, result.achieved_Pa, result.absolute, result.report);
    noteCap(result);
}

void HologramPipeline::play(const haptics::TransducerArray& array, HologramResult& result)
{
    const int m = _options.array.size();
    if (_q.size() != m)
        throw std::logic_error("solver gave " + std::to_string(_q.size()) + " activations for " +
                               std::to_string(m) + " transducers");
    if (!device::encode(_q.data(), m, _signal))
        throw std::runtime_error("solver gave activations that are not finite; nothing is played");
    if (_cap) holdToCap(array, result);
    if (result.capFactor <= 0.0) return silenceDevice();
    if (_player)
    {
        // The field at its full amplitude is what is shown; a step that the device refuses is followed by the next.
        std::vector<std::complex<float>> q;
        device::decode(_signal, q);
        handToPlayer({vectorOf(q)});
    }
    // A field that the device did not take is tried again: with the next snapshot, moved or not, and by attend().
    else if (_device && !sendSignal())
        _messages.say(refusal());
}

bool HologramPipeline::sendSignal()
{
    const std::lock_guard<std::mutex> lock(_sending);
    // Whoever asked for it may have silenced the device already.
    _options.solverOptions.stop.throwIfRequested();
    _before = _device->report();
    _playing = _device->send(_signal);
    // A device that is there and refuses all the same is not asked again and again.
    _holds = _playing || _device->report().state != device::DeviceState::READY;
    if (!_playing) _device->silence();
    return _playing;
}

// Of a device that is gone it says what happened to it, which is said once.
std::string HologramPipeline::refusal() const
{
    const device::DeviceReport report = _device->report();
    if (report.state == device::DeviceState::MUTED) return "device: muted";
    const std::string why = report.message.empty() ? _device->status() : report.message;
    return (report.state == device::DeviceState::LOST ? "device: " : "device refused a field: ") +
           why;
}

Eigen::VectorXcf HologramPipeline::wouldPlay(const device::DriveSignal& signal) const
{
    if (_device) return vectorOf(_device->wouldPlay(signal));
    std::vector<std::complex<float>> q;
    device::decode(signal, q);
    return vectorOf(q);
}

// What the device tells that it plays; where it hasn't told yet, what it is going to.
Eigen::VectorXcf HologramPipeline::playedNow() const
{
    const bool told = _device && !(_playing && (_player || _device->report().pending > 0));
    return told ? vectorOf(_device->played()) : wouldPlay(_signal);
}

// achieved_Pa of what is played, which the cap has computed already where the device plays what it was to.
void HologramPipeline::measure(const haptics::TransducerArray& array, HologramResult& result) const
{
    if (result.report.stop == haptics::StopReason::REFUSED || result.capFactor <= 0.0)
        result.played.setZero(_options.array.size());
    else
    {
        const Eigen::VectorXcf played = playedNow();
        if (played == result.played && result.achieved_Pa.size() > 0) return;
        result.played = played;
    }
    result.achieved_Pa = haptics::pressureAt(result.points.positions,
                                             array,
                                             _options.medium,
                                             result.played,
                                             _options.solverOptions.threads,
                                             _options.solverOptions.stop)
                             .cwiseAbs();
}

std::shared_ptr<const HologramResult> HologramPipeline::attend()
{
    try
    {
        return lookAfterDevice();
    }
    catch (const base::Stopped&)
    {
        // Whoever asked for it silences the device, or replaces or ends this.
        return nullptr;
    }
}

std::shared_ptr<const HologramResult> HologramPipeline::lookAfterDevice()
{
    if (auto result = goOn()) return result;
    // What is modulated is sent again and again anyway.
    if (!_last || !_device || _player || !_holds) return nullptr;
    const device::DeviceReport now = _device->report();
    const bool ready = now.state == device::DeviceState::READY;
    const bool lost = now.lost != _before.lost || now.faults != _before.faults ||
                      now.reconnects != _before.reconnects;
    const bool again = ready && now.pending == 0 && (lost || !_playing);
    if (!again && (ready || !_playing)) return nullptr;
    auto result = std::make_shared<HologramResult>(*_last);
    _playing = false;
    if (again && sendSignal())
        ++_counters.resent;
    else
        _messages.say(refusal());
    result->playing = _playing;
    result->counters = _counters;
    result->deviceStatus = _device->status();
    result->messages = _messages.all();
    measure(arrayFor(*result), *result);
    _last = result;
    return result;
}

void HologramPipeline::finish(const SceneSnapshot& snapshot, HologramResult& result)
{
    result.frame = snapshot.frame;
    result.playing = _playing;
    result.maxPressure_Pa = _cap ? _cap->max_Pa() : 0.0;
    result.latency_ms = (base::steadySeconds() - snapshot.time_s) * 1e3;
    result.counters = _counters;
    result.updatesPerSecond = updatesPerSecond();
    result.deviceStatus = _device ? _device->status() : "not open: " + _deviceError;
    if (_monitor) result.monitored = _monitor->latest();
    if (result.monitored) result.report.surface = result.monitored->surface;
    result.messages = _messages.all();
}

double HologramPipeline::updatesPerSecond()
{
    const double now = base::steadySeconds();
    while (!_solveTimes_s.empty() && _solveTimes_s.front() < now - 1.0)
        _solveTimes_s.pop_front();
    return static_cast<double>(_solveTimes_s.size());
}

} // namespace midair::bridge
