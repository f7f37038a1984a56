// What happens to a unit as time passes: its queue, its switches, its failsafe, its clock.

#include "device/autd3/emulator/unit/EmulatedUnit.h"

#include <algorithm>
#include <iterator>

namespace midair::device::emulation
{

namespace
{

constexpr std::uint8_t kReset = 0x00;
constexpr std::uint8_t kClear = 0x03;
constexpr std::uint8_t kFrameKind = 0;

bool isAllOff(const std::vector<std::uint8_t>& mask)
{
    for (std::size_t i = 0; i < mask.size(); ++i)
        if ((i + 1 < mask.size() ? mask[i] : mask[i] & 1U) != 0) return false;
    return true;
}

} // namespace

// The CPU counts its own milliseconds, so what is heard late in one has that much less.
Time_ns EmulatedUnit::failsafeAt_ns() const
{
    if (_heardAt_ns < 0 || _cpu.config().failsafe_ns == 0) return kNever_ns;
    const Time_ns since_ns = _heardAt_ns / kMillisecond_ns * kMillisecond_ns;
    return std::max(since_ns + _cpu.config().failsafe_ns, _tripsFrom_ns);
}

Time_ns EmulatedUnit::lockFailsafeAt_ns() const
{
    if (_unlockedAt_ns == kNever_ns || _cpu.config().lockFailsafe_ns == 0) return kNever_ns;
    return std::max(_unlockedAt_ns + _cpu.config().lockFailsafe_ns, _tripsFrom_ns);
}

Time_ns EmulatedUnit::nextEvent_ns() const
{
    Time_ns next_ns = std::min(_losesIdAt_ns, _cpu.fpgaWhen(fpga().due_ns()));
    if (!_queue.empty()) next_ns = std::min(next_ns, _queue.front().done_ns);
    if (!_hostSilent) next_ns = std::min(next_ns, failsafeAt_ns());
    if (!_unlockedLong) next_ns = std::min(next_ns, lockFailsafeAt_ns());
    return next_ns;
}

void EmulatedUnit::hear(std::uint64_t peer, Time_ns now_ns)
{
    _heardAt_ns = now_ns;
    _host = peer;
    _hasHost = true;
    _hostSilent = false;
}

void EmulatedUnit::forgetTrips(Time_ns now_ns)
{
    _hostSilent = _unlockedLong = false;
    _tripsFrom_ns = now_ns;
}

// Each cause trips it once; it stays so until ReleaseFailsafe or Clear, whatever becomes of that.
void EmulatedUnit::trip(Time_ns now_ns)
{
    if (!_hostSilent && failsafeAt_ns() <= now_ns)
    {
        _hostSilent = true;
        tripFailsafe(now_ns);
    }
    if (!_unlockedLong && lockFailsafeAt_ns() <= now_ns)
    {
        _unlockedLong = true;
        ++_cpu.telemetry.lockFailsafe;
        close(now_ns);
    }
}

void EmulatedUnit::advance(Time_ns now_ns)
{
    for (Time_ns next_ns = nextEvent_ns(); next_ns <= now_ns; next_ns = nextEvent_ns())
    {
        if (_losesIdAt_ns <= next_ns) loseId(next_ns);
        tellSwitches(next_ns);
        if (!_queue.empty() && _queue.front().done_ns <= next_ns)
        {
            const Frame frame = std::move(_queue.front());
            _queue.pop_front();
            finish(frame);
        }
        trip(next_ns);
    }
}

void EmulatedUnit::finish(const Frame& frame)
{
    if (frame.command == kReset)
    {
        _next = 0;
        _last = LastReply();
    }
    else if (frame.number == _next)
    {
        ++_next;
        const std::uint64_t intrusions = fpga().intrusions().banks;
        std::vector<std::uint8_t> data;
        const Result result = run(frame, data);
        if (result != Result::DONE) data.clear();
        _last = {frame.number, result, std::move(data)};
        if (result != Result::DONE) ++_cpu.telemetry.errors;
        ++_cpu.telemetry.done; // refused ones, too
        tellWatch(frame, intrusions);
    }
    else
        ++_cpu.telemetry.outOfTurn; // the answer is the last one's, with its data
    answerFrame(kFrameKind, frame.message, frame.done_ns);
}

Result EmulatedUnit::run(const Frame& frame, std::vector<std::uint8_t>& data)
{
    if (frame.command >= 0x70 && frame.command <= 0x78) ++_updateCommands;
    if (_failing > 0)
    {
        --_failing;
        return static_cast<Result>(_failure);
    }
    const Time_ns now_ns = frame.done_ns;
    const UnitMoment moment{now_ns,
                            _clock.at(now_ns),
                            _locked,
                            std::min(failsafeAt_ns(), lockFailsafeAt_ns()) <= now_ns};
    return _cpu.run(frame.command, frame.payload.data(), frame.payload.size(), moment, data);
}

void EmulatedUnit::tellWatch(const Frame& frame, std::uint64_t intrusionsBefore)
{
    if (_last.result != Result::DONE) return;
    const Time_ns now_ns = frame.done_ns;
    switch (frame.command)
    {
    case kClear:
        forgetTrips(now_ns);
        _maskedAll = false;
        _watch.cleared(_place, now_ns, fpga().content());
        break;
    case 0x05: // SetCpuConfig
        if (failsafeAt_ns() > now_ns) _hostSilent = false;
        if (lockFailsafeAt_ns() > now_ns) _unlockedLong = false;
        _tripsFrom_ns = now_ns;
        break;
    case 0x06: // ReleaseFailsafe
        _watch.closed(_place, now_ns, _maskedAll);
        break;
    case 0x12: // ActivatePatternBank
        tellSwitches(now_ns);
        _watch.changed(_place, now_ns, fpga().content()); // new registers
        break;
    case 0x41: // SetOutputMask
        _maskedAll = isAllOff(frame.payload);
        if (_maskedAll) _watch.closed(_place, now_ns, true);
        _watch.changed(_place, now_ns, fpga().content());
        if (!_maskedAll) _watch.closed(_place, now_ns, fpga().gated());
        break;
    case 0x40:
    case 0x42:
        _watch.changed(_place, now_ns, fpga().content());
        break;
    default:
        if (fpga().intrusions().banks != intrusionsBefore)
            _watch.changed(_place, now_ns, fpga().content());
        break;
    }
}

void EmulatedUnit::tellSwitches(Time_ns now_ns)
{
    BankTimeline::Switch made;
    if (_cpu.fpga().takeSwitch(_cpu.fpgaTime(now_ns), made))
        _watch.switched(_place, _cpu.fpgaWhen(made.at_ns), fpga().content(), made.replays);
}

void EmulatedUnit::takeAnswers(std::vector<UnitAnswer>& answers)
{
    std::move(_answers.begin(), _answers.end(), std::back_inserter(answers));
    _answers.clear();
}

void EmulatedUnit::loseId(Time_ns now_ns)
{
    _losesIdAt_ns = kNever_ns;
    _id = kNoId;
    _open = _behind = _grandmaster = false;
    _hasHost = false;
    _timeSetAt_ns = -1;
    _cpu.restoreConfig();
    unlock(now_ns);
    _unlockedAt_ns = kNever_ns;
    _unlockedLong = false;
    _tripsFrom_ns = now_ns;
}

void EmulatedUnit::lock(const EmulatedClock& clock, Time_ns now_ns)
{
    if (!_locked && _unlockedAt_ns != kNever_ns) ++_cpu.telemetry.resync;
    _locked = true;
    _unlockedAt_ns = kNever_ns;
    _unlockedLong = false;
    _clock = clock;
    _cpu.followClock(_clock, now_ns);
}

void EmulatedUnit::unlock(Time_ns now_ns)
{
    if (!_locked) return;
    _locked = false;
    _unlockedAt_ns = now_ns;
    _clock.setRate(now_ns, _options.rate_ppm);
    _cpu.followClock(_clock, now_ns);
}

void EmulatedUnit::reboot(Time_ns now_ns)
{
    advance(now_ns);
    const std::uint64_t updates = _updateCommands;
    std::vector<UnitAnswer> answers = std::move(_answers);
    // All but what it is made of is as at power-up.
    _cpu.restart();
    _clock = {now_ns, _options.started_ns, _options.rate_ppm};
    _cpu.startClock(_clock);
    _bootedAt_ns = now_ns + std::max(_options.boot_ns, kMillisecond_ns);
    _id = kNoId;
    _open = _behind = _grandmaster = _locked = _maskedAll = false;
    _hostSilent = _unlockedLong = _hasHost = false;
    _unlockedAt_ns = kNever_ns;
    _assignedAt_ns = 0;
    _timeSetAt_ns = _heardAt_ns = -1;
    _losesIdAt_ns = kNever_ns;
    _queue.clear();
    _busyUntil_ns = 0;
    _next = 0;
    _last = LastReply();
    _lastReceived = kNoFrame;
    _failing = 0;
    _updateCommands = updates;
    _answers = std::move(answers);
    _watch.rebooted(_place, now_ns, fpga().content());
}

void EmulatedUnit::tripFailsafe(Time_ns now_ns)
{
    ++_cpu.telemetry.failsafe;
    close(now_ns);
}

void EmulatedUnit::close(Time_ns now_ns)
{
    ++_trips;
    _cpu.closeGate(now_ns);
    _watch.closed(_place, now_ns, true);
}

void EmulatedUnit::failCommands(std::uint8_t result, int count)
{
    _failure = result;
    _failing = count;
}

std::vector<std::complex<float>> EmulatedUnit::output(Time_ns now_ns)
{
    advance(now_ns);
    if (!isOn(now_ns)) return std::vector<std::complex<float>>(kUnitTransducers);
    return _cpu.fpga().output(_cpu.fpgaTime(now_ns));
}

} // namespace midair::device::emulation
