#include "engine-bridge/playing/FieldPlayer.h"

#include "device/DriveEncoder.h"
#include "device/GuardedDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace midair::bridge
{

namespace
{

std::chrono::steady_clock::time_point instant(double time_s)
{
    using namespace std::chrono;
    return steady_clock::time_point(
        duration_cast<steady_clock::duration>(duration<double>(time_s)));
}

} // namespace

FieldPlayer::FieldPlayer(device::ArrayDevice& device) : _device(device), _thread([this] { run(); })
{
}

FieldPlayer::~FieldPlayer()
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _quit = true;
    }
    _wake.notify_all();
    _thread.join();
}

void FieldPlayer::play(const std::vector<Eigen::VectorXcf>& cycle,
                       const haptics::ModulatorOptions& modulation)
{
    const haptics::Modulator modulator(modulation);
    if (cycle.empty())
        throw base::InputError("field player: there are no fields; there must be at least one");
    std::vector<device::DriveSignal> signals(cycle.size());
    for (std::size_t k = 0; k < cycle.size(); ++k)
    {
        if (cycle[k].size() != cycle[0].size())
            throw base::InputError("field player: field " + std::to_string(k) + " has " +
                                   std::to_string(cycle[k].size()) +
                                   " activations, the first one " +
                                   std::to_string(cycle[0].size()));
        if (!device::encode(cycle[k].data(), static_cast<int>(cycle[k].size()), signals[k]))
            throw base::InputError("field player: field " + std::to_string(k) +
                                   " has an activation that is not finite");
    }
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const bool goesOn = !_cycle.empty() && _modulator.changes(_cycle.size()) &&
                            modulator.changes(signals.size()) && modulation == _modulator.options();
        _cycle.swap(signals);
        ++_generation;
        if (!goesOn)
        {
            _modulator = modulator;
            _start_s = base::steadySeconds();
            _step = 0;
        }
    }
    _wake.notify_all();
}

void FieldPlayer::stop()
{
    std::unique_lock<std::mutex> lock(_mutex);
    _cycle.clear();
    ++_generation;
    _wake.notify_all();
    _idle.wait(lock, [this] { return !_sending; });
}

FieldPlayer::Counters FieldPlayer::counters() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _counters;
}

// Duty level L plays sin(pi L / 510): the level that plays `amplitude` times that, for each of the 256.
bool FieldPlayer::sendStep(std::unique_lock<std::mutex>& lock)
{
    const double period_s = 1.0 / _modulator.options().fieldRate_Hz;
    const std::uint64_t generation = _generation;
    const double due_s = _start_s + static_cast<double>(_step) * period_s;
    if (_wake.wait_until(lock, instant(due_s), [&] { return _quit || _generation != generation; }))
        return !_quit;
    const auto reached = static_cast<std::int64_t>((base::steadySeconds() - _start_s) / period_s);
    if (reached > _step)
    {
        _counters.leftOut += static_cast<std::uint64_t>(reached - _step);
        _step = reached;
    }
    const double time_s = static_cast<double>(_step) * period_s;
    const int fields = static_cast<int>(_cycle.size());
    const haptics::Modulator::Step step = _modulator.at(time_s, fields);
    device::scaleDuties(_cycle[static_cast<std::size_t>(step.field)], step.amplitude, _out);
    const bool changes = _modulator.changes(_cycle.size());
    ++_step;
    _sending = true;
    _counters.worstLateness_s =
        std::max(_counters.worstLateness_s, base::steadySeconds() - _start_s - time_s);
    lock.unlock();
    const bool taken = _device.send(_out);
    lock.lock();
    _sending = false;
    ++(taken ? _counters.sent : _counters.refused);
    _idle.notify_all();
    // What doesn't change is held by the device.
    if (!changes && taken) _wake.wait(lock, [&] { return _quit || _generation != generation; });
    return !_quit;
}

void FieldPlayer::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    for (;;)
    {
        _wake.wait(lock, [this] { return _quit || !_cycle.empty(); });
        if (_quit || !sendStep(lock)) return;
    }
}

} // namespace midair::bridge
