#include "engine-bridge/playing/FieldPlayer.h"

#include "device/DeviceLog.h"
#include "engine-bridge/playing/SequenceOfSteps.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr std::chrono::milliseconds kWatch(50); // interval of watchSequence()'s checks
constexpr double kRetry_s = 0.02;               // pause before a refused sequence is sent again

// Whether the device's clock has the modulator's rate.
bool keepsTime(const device::DriveAbility& ability, const haptics::Modulator& modulator)
{
    constexpr double kWhole = 1e-9; // relative: off by a field in hours or days
    if (ability.sequenceClock_Hz <= 0) return true;
    const double exact = ability.sequenceClock_Hz / modulator.options().fieldRate_Hz;
    const double whole = std::round(exact);
    return whole >= 1 && std::abs(exact - whole) <= kWhole * whole;
}

std::string whyStreamed(const device::DriveAbility& ability, const haptics::Modulator& modulator)
{
    if (!keepsTime(ability, modulator))
        return fmt::format("{:g} fields/s aren't {:g} Hz over a whole number",
                           modulator.options().fieldRate_Hz,
                           ability.sequenceClock_Hz);
    return fmt::format("it doesn't repeat within {} steps", ability.sequenceFields);
}

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

void FieldPlayer::play(std::vector<device::DriveSignal> signals,
                       const haptics::ModulatorOptions& modulation)
{
    const haptics::Modulator modulator(modulation);
    if (signals.empty())
        throw base::InputError("field player: there are no fields; there must be at least one");
    for (std::size_t k = 0; k < signals.size(); ++k)
        if (!signals[k].fits(signals[0].size()))
            throw base::InputError(
                fmt::format("field player: field {} is for {} transducers, the first one for {}",
                            k,
                            signals[k].size(),
                            signals[0].size()));
    std::shared_ptr<Whole> whole;
    const device::DriveAbility ability = _device.ability();
    if (modulator.changes(signals.size()) && ability.sequenceFields > 0)
    {
        const int most = keepsTime(ability, modulator) ? ability.sequenceFields : 0;
        whole = std::make_shared<Whole>(Whole{sequenceOfSteps(signals, modulator, most)});
        const bool isStreamed = whole->sequence.signals.empty();
        if (isStreamed) whole.reset();
        tellStreamed(isStreamed ? whyStreamed(ability, modulator) : "");
    }
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const bool goesOn = !_cycle.empty() && _modulator.changes(_cycle.size()) &&
                            modulator.changes(signals.size()) && modulation == _modulator.options();
        const double now_s = base::steadySeconds();
        _cycle.swap(signals);
        _whole = std::move(whole);
        ++_generation;
        if (goesOn && _byItself) // the thread didn't count the steps that the device played
            _step = nextStep(now_s);
        _byItself = false;
        if (!goesOn)
        {
            _modulator = modulator;
            _start_s = now_s;
            _step = 0;
        }
    }
    _wake.notify_all();
}

void FieldPlayer::tellStreamed(std::string why)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    if (why == _counters.streamed) return;
    if (!why.empty())
        device::logDeviceNote("fields in turn are sent one by one, since the device can't play "
                              "these by itself: " +
                              why);
    _counters.streamed = std::move(why);
}

void FieldPlayer::stop()
{
    std::unique_lock<std::mutex> lock(_mutex);
    _cycle.clear();
    _whole.reset();
    _byItself = false;
    ++_generation;
    _wake.notify_all();
    _idle.wait(lock, [this] { return !_sending; });
}

FieldPlayer::Counters FieldPlayer::counters() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _counters;
}

bool FieldPlayer::handOver(std::unique_lock<std::mutex>& lock, Whole* whole, std::int64_t step)
{
    if (whole == nullptr) signalOfStep(_cycle, _modulator, step, _out);
    _sending = true;
    lock.unlock();
    if (whole != nullptr)
    {
        std::vector<device::DriveSignal>& signals = whole->sequence.signals;
        const auto count = static_cast<std::int64_t>(signals.size());
        std::rotate(
            signals.begin(), signals.begin() + (step - whole->first) % count, signals.end());
        whole->first = step;
    }
    const bool taken =
        whole != nullptr ? _device.sendSequence(whole->sequence) : _device.sendUnled(_out);
    lock.lock();
    _sending = false;
    ++(taken ? _counters.sent : _counters.refused);
    _idle.notify_all();
    return taken;
}

// Steps sent one by one play again after a mute by themselves; a sequence has to be sent again.
void FieldPlayer::watchSequence(std::unique_lock<std::mutex>& lock, std::uint64_t silences)
{
    const std::uint64_t generation = _generation;
    const auto isReplaced = [&] { return _quit || _generation != generation; };
    while (!_wake.wait_for(lock, kWatch, isReplaced))
    {
        lock.unlock();
        const device::DeviceReport report = _device.report();
        lock.lock();
        if (isReplaced()) return;
        if (report.silences == silences && report.state == device::DeviceState::READY) continue;
        _byItself = false;
        _step = nextStep(base::steadySeconds());
        return;
    }
}

// A device may refuse a sequence that it can't time after all, such as one that lasts too long. Its
// line may carry the fields.
bool FieldPlayer::isStreamedInstead(std::unique_lock<std::mutex>& lock)
{
    const std::uint64_t generation = _generation;
    lock.unlock();
    const bool isReady = _device.report().state == device::DeviceState::READY;
    const double carried_Hz = _device.ability().fieldsPerSecond;
    lock.lock();
    if (_generation != generation || !isReady) return _generation != generation;
    if (carried_Hz <= 0.0 || _modulator.options().fieldRate_Hz > carried_Hz) return false;
    _whole.reset();
    lock.unlock();
    tellStreamed("it refuses them");
    lock.lock();
    return true;
}

bool FieldPlayer::sendStep(std::unique_lock<std::mutex>& lock)
{
    const std::uint64_t generation = _generation;
    const auto isReplaced = [&] { return _quit || _generation != generation; };
    const double due_s = _start_s + static_cast<double>(_step) * period_s();
    if (_wake.wait_until(lock, instant(due_s), isReplaced)) return !_quit;
    const auto reached = static_cast<std::int64_t>((base::steadySeconds() - _start_s) / period_s());
    if (reached > _step)
    {
        _counters.leftOut += static_cast<std::uint64_t>(reached - _step);
        _step = reached;
    }
    const double time_s = static_cast<double>(_step) * period_s();
    _counters.worstLateness_s =
        std::max(_counters.worstLateness_s, base::steadySeconds() - _start_s - time_s);
    const std::shared_ptr<Whole> whole = _whole;
    const bool changes = _modulator.changes(_cycle.size());
    const std::int64_t step = _step++;
    const std::uint64_t silences = whole ? _device.report().silences : 0;
    const bool taken = handOver(lock, whole.get(), step);
    if (isReplaced()) return !_quit;
    if (whole) _byItself = taken;
    if (whole && !taken && isStreamedInstead(lock)) return !_quit;
    if (whole && !taken) _step += static_cast<std::int64_t>(kRetry_s / period_s());
    if (taken && whole)
        watchSequence(lock, silences);
    else if (taken && !changes) // the device holds it
        _wake.wait(lock, isReplaced);
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
