#include "engine-bridge/playing/FieldPlayer.h"

#include "device/DeviceLog.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/Punctual.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

// Relative tolerance for a whole number of steps: an error of this share of a period drifts by one
// period in 10^9 of them, which takes hours for fields and days for a modulation.
constexpr double kWhole = 1e-9;

// Steps per period of the amplitude modulation, 1 without one; 0 if that is not a whole number or
// more than most.
std::int64_t stepsOfModulation(const haptics::ModulatorOptions& options, int most)
{
    if (options.amplitudeRate_Hz <= 0.0) return 1;
    const double exact = options.fieldRate_Hz / options.amplitudeRate_Hz;
    const double steps = std::round(exact);
    if (steps < 1.0 || steps > most || std::abs(exact - steps) > kWhole * steps) return 0;
    return static_cast<std::int64_t>(steps);
}

constexpr double kWatch_s = 0.05; // interval of watchSequence()'s checks
constexpr double kForever_s = std::numeric_limits<double>::infinity();
constexpr double kRetry_s = 0.02; // pause before a refused sequence is sent again

// Whether the device's clock has the modulator's rate.
bool keepsTime(const device::DriveAbility& ability, const haptics::Modulator& modulator)
{
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

} // namespace

void signalOfStep(const std::vector<device::DriveSignal>& cycle,
                  const haptics::Modulator& modulator,
                  std::int64_t step,
                  device::DriveSignal& out)
{
    const double time_s = static_cast<double>(step) * (1.0 / modulator.options().fieldRate_Hz);
    const haptics::Modulator::Step played = modulator.at(time_s, static_cast<int>(cycle.size()));
    device::scaleDuties(cycle[static_cast<std::size_t>(played.field)], played.amplitude, out);
}

device::DriveSequence sequenceOfSteps(const std::vector<device::DriveSignal>& cycle,
                                      const haptics::Modulator& modulator,
                                      int most)
{
    device::DriveSequence sequence;
    sequence.rate_Hz = modulator.options().fieldRate_Hz;
    const std::int64_t modulation = stepsOfModulation(modulator.options(), most);
    const auto fields = static_cast<std::int64_t>(cycle.size());
    if (modulation == 0 || fields == 0 || fields > most) return sequence;
    const std::int64_t steps = std::lcm(modulation, fields);
    if (steps > most) return sequence;
    sequence.signals.resize(static_cast<std::size_t>(steps));
    for (std::int64_t step = 0; step < steps; ++step)
        signalOfStep(cycle, modulator, step, sequence.signals[static_cast<std::size_t>(step)]);
    return sequence;
}

FieldPlayer::FieldPlayer(device::ArrayDevice& device, const base::Clock& clock) :
    _device(device),
    _clock(clock),
    _thread([this] { run(); })
{
}

FieldPlayer::~FieldPlayer()
{
    {
        const base::Lock lock(_mutex);
        _quit = true;
    }
    _wake.notifyAll();
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
        const base::Lock lock(_mutex);
        Playing& now = _playing;
        const bool goesOn = !now.cycle.empty() && now.modulator.changes(now.cycle.size()) &&
                            modulator.changes(signals.size()) &&
                            modulation == now.modulator.options();
        const double now_s = _clock.now_s();
        now.cycle.swap(signals);
        now.whole = std::move(whole);
        ++now.generation;
        if (goesOn && now.byItself) // the thread didn't count the steps played by the device
            now.step = now.nextStep(now_s);
        now.byItself = false;
        if (!goesOn)
        {
            now.modulator = modulator;
            now.start_s = now_s;
            now.step = 0;
        }
    }
    _wake.notifyAll();
}

void FieldPlayer::tellStreamed(std::string why)
{
    const base::Lock lock(_mutex);
    if (why == _counters.streamed) return;
    if (!why.empty())
        device::logDeviceNote("fields in turn are sent one by one, because the device can't play "
                              "this sequence by itself: " +
                              why);
    _counters.streamed = std::move(why);
}

void FieldPlayer::stop()
{
    base::Lock lock(_mutex);
    _playing.cycle.clear();
    _playing.whole.reset();
    _playing.byItself = false;
    ++_playing.generation;
    _wake.notifyAll();
    while (_sending)
        _idle.wait(lock);
}

FieldPlayer::Counters FieldPlayer::counters() const
{
    const base::Lock lock(_mutex);
    return _counters;
}

bool FieldPlayer::awaitAnother(base::Lock& lock, std::uint64_t generation, double until_s)
{
    while (!isReplaced(generation) && _clock.now_s() < until_s)
        _clock.wait(_wake, lock, until_s);
    return isReplaced(generation);
}

bool FieldPlayer::handOver(Whole* whole, std::int64_t step)
{
    if (whole == nullptr) signalOfStep(_playing.cycle, _playing.modulator, step, _out);
    _sending = true;
    _mutex.unlock();
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
    _mutex.lock();
    _sending = false;
    ++(taken ? _counters.sent : _counters.refused);
    _idle.notifyAll();
    return taken;
}

// After a mute, steps sent one by one resume by themselves; a sequence has to be sent again.
void FieldPlayer::watchSequence(base::Lock& lock, std::uint64_t silences)
{
    const std::uint64_t generation = _playing.generation;
    while (!awaitAnother(lock, generation, _clock.now_s() + kWatch_s))
    {
        _mutex.unlock();
        const device::DeviceReport report = _device.report();
        _mutex.lock();
        if (isReplaced(generation)) return;
        if (report.silences == silences && report.state == device::DeviceState::READY) continue;
        _playing.byItself = false;
        _playing.step = _playing.nextStep(_clock.now_s());
        return;
    }
}

// A device may refuse a sequence that it can't time after all, for example one that lasts too long.
// Its line may carry the single fields.
bool FieldPlayer::isStreamedInstead()
{
    const std::uint64_t generation = _playing.generation;
    _mutex.unlock();
    const bool isReady = _device.report().state == device::DeviceState::READY;
    const double carried_Hz = _device.ability().fieldsPerSecond;
    _mutex.lock();
    if (_playing.generation != generation || !isReady) return _playing.generation != generation;
    if (carried_Hz <= 0.0 || _playing.modulator.options().fieldRate_Hz > carried_Hz) return false;
    _playing.whole.reset();
    _mutex.unlock();
    tellStreamed("it refuses them");
    _mutex.lock();
    return true;
}

bool FieldPlayer::sendStep(base::Lock& lock)
{
    Playing& now = _playing;
    const std::uint64_t generation = now.generation;
    const double period_s = now.period_s();
    const double due_s = now.start_s + static_cast<double>(now.step) * period_s;
    if (awaitAnother(lock, generation, due_s)) return !_quit;
    const auto reached = static_cast<std::int64_t>((_clock.now_s() - now.start_s) / period_s);
    if (reached > now.step)
    {
        _counters.leftOut += static_cast<std::uint64_t>(reached - now.step);
        now.step = reached;
    }
    const double time_s = static_cast<double>(now.step) * period_s;
    _counters.worstLateness_s =
        std::max(_counters.worstLateness_s, _clock.now_s() - now.start_s - time_s);
    const std::shared_ptr<Whole> whole = now.whole;
    const bool changes = now.modulator.changes(now.cycle.size());
    const std::int64_t step = now.step++;
    const std::uint64_t silences = whole ? _device.report().silences : 0;
    const bool taken = handOver(whole.get(), step);
    if (isReplaced(generation)) return !_quit;
    if (whole) now.byItself = taken;
    if (whole && !taken && isStreamedInstead()) return !_quit;
    if (whole && !taken) now.step += static_cast<std::int64_t>(kRetry_s / period_s);
    if (taken && whole)
        watchSequence(lock, silences);
    else if (taken && !changes) // the device holds it
        awaitAnother(lock, generation, kForever_s);
    return !_quit;
}

void FieldPlayer::run()
{
    base::wakePunctually();
    base::Lock lock(_mutex);
    for (;;)
    {
        while (!_quit && _playing.cycle.empty())
            _clock.wait(_wake, lock, kForever_s);
        if (_quit || !sendStep(lock)) return;
    }
}

} // namespace midair::bridge
