#include "engine-bridge/HologramPipeline.h"

#include "device/DriveEncoder.h"
#include "haptics/InputError.h"
#include "haptics/PressureField.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace midair::bridge
{

double steadySeconds()
{
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

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
        return fail("motionTolerance is " + std::to_string(motionTolerance) +
                    " wavelengths, should be at least 0");
    if (maxPoints < 0)
        return fail("maxPoints is " + std::to_string(maxPoints) + ", should be at least 0");
    if (!modulation.isValid(error)) return false;
    return solverOptions.isValid(error);
}

HologramPipeline::HologramPipeline(HologramOptions options) : _options(std::move(options))
{
    std::string error;
    if (!_options.isValid(&error)) throw haptics::InputError(error);
    if (!_options.solverFactory)
        _options.solverFactory = [](const std::string& name, const haptics::SolverOptions& o)
        { return haptics::makeSolver(name, o); };
    if (!_options.deviceFactory)
        _options.deviceFactory = [](const std::string& uri, const device::DeviceLayout& layout)
        { return device::openDevice(uri, layout); };
    if (_options.solver.empty() && !haptics::solverNames().empty())
        _options.solver = haptics::solverNames().front();
    PointAssembler::Options points;
    points.wavelength_m = _options.medium.wavelength(_options.array.frequency_Hz);
    points.motionTolerance_m = _options.motionTolerance * points.wavelength_m;
    points.maxPoints = _options.maxPoints;
    _assembler = std::make_unique<PointAssembler>(_options.array, points, _messages);
    solver(false); // an unknown name is told now
    openDevice();
}

HologramPipeline::~HologramPipeline()
{
    silenceDevice();
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
    if (_device && _options.modulation.amplitudeRate_Hz > 0.0)
        _player = std::make_unique<FieldPlayer>(*_device);
    // The solver is to know what can be played at all.
    const device::DriveAbility ability = _device ? _device->ability() : device::DriveAbility();
    _options.array.drive.phaseLevels = ability.phaseLevels;
    _options.array.drive.amplitudeLevels =
        ability.amplitudes.empty() ? device::amplitudeLevels() : ability.amplitudes;
}

haptics::HologramSolver& HologramPipeline::solver(bool absolute)
{
    auto& solver = absolute ? _absoluteSolver : _relativeSolver;
    if (!solver)
    {
        haptics::SolverOptions options = _options.solverOptions;
        options.absoluteTargets = absolute;
        solver = _options.solverFactory(_options.solver, options);
        if (!solver) throw haptics::InputError("no solver \"" + _options.solver + "\"");
    }
    return *solver;
}

void HologramPipeline::silenceDevice()
{
    if (_player) _player->stop(); // or it would play on over the silence
    if (_device) _device->silence();
}

void HologramPipeline::silence()
{
    _playing = false;
    silenceDevice();
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
    AssembledPoints assembled = _assembler->assemble(snapshot);
    result->points = std::move(assembled.points);
    result->skipped = std::move(assembled.skipped);
    result->absolute = assembled.absolute;
    _counters.sampled = _assembler->sampled();
    _counters.followed = _assembler->followed();
    _counters.outOfWorkspace += assembled.outOfWorkspace;
    _counters.overBudget += assembled.overBudget;
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
    const haptics::TransducerArray& array = _around.shadowed(
        result->points, _options.array, _options.medium.wavelength(_options.array.frequency_Hz));
    result->report = solver(assembled.absolute).solve(result->points, array, _options.medium, _q);
    ++_counters.solves;
    _solveTimes_s.push_back(steadySeconds());
    if (!result->report.message.empty()) _messages.say(result->report.message);
    if (result->report.stop == haptics::StopReason::REFUSED) silence();
    // A field that the device did not take is tried again with the next snapshot, moved or not.
    else if (!play(_q, result->played))
        _playing = false;
    finish(snapshot, *result);
    result->achieved_Pa = haptics::pressureAt(result->points.positions,
                                              array,
                                              _options.medium,
                                              result->played,
                                              _options.solverOptions.threads)
                              .cwiseAbs();
    return result;
}

bool HologramPipeline::play(const Eigen::VectorXcf& q, Eigen::VectorXcf& played)
{
    const int m = _options.array.size();
    if (q.size() != m)
        throw std::logic_error("solver gave " + std::to_string(q.size()) + " activations for " +
                               std::to_string(m) + " transducers");
    if (!device::encode(q.data(), m, _signal))
        throw std::runtime_error("solver gave activations that are not finite; nothing is played");
    bool taken = true;
    std::vector<std::complex<float>> activations;
    if (_player)
    {
        // The field at its full amplitude is what is shown; a step that the device refuses is followed by the next.
        _player->play({q}, _options.modulation);
        device::decode(_signal, activations);
    }
    else if (_device)
    {
        taken = _device->send(_signal);
        if (!taken)
        {
            _messages.say("device refused a field: " + _device->status());
            _device->silence();
        }
        activations = _device->played();
    }
    else
        device::decode(_signal, activations);
    played = Eigen::Map<const Eigen::VectorXcf>(activations.data(),
                                                static_cast<Eigen::Index>(activations.size()));
    return taken;
}

void HologramPipeline::finish(const SceneSnapshot& snapshot, HologramResult& result)
{
    result.frame = snapshot.frame;
    result.playing = _playing;
    result.latency_ms = (steadySeconds() - snapshot.time_s) * 1e3;
    result.counters = _counters;
    result.updatesPerSecond = updatesPerSecond();
    result.deviceStatus = _device ? _device->status() : "not open: " + _deviceError;
    result.messages = _messages.all();
}

double HologramPipeline::updatesPerSecond()
{
    const double now = steadySeconds();
    while (!_solveTimes_s.empty() && _solveTimes_s.front() < now - 1.0)
        _solveTimes_s.pop_front();
    return static_cast<double>(_solveTimes_s.size());
}

} // namespace midair::bridge
