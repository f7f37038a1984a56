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
    if (_host.heardAt_ns < 0 || _cpu.config().failsafe_ns == 0) return kNever_ns;
    const Time_ns since_ns = _host.heardAt_ns / kMillisecond_ns * kMillisecond_ns;
    return std::max(since_ns + _cpu.config().failsafe_ns, _failsafe.from_ns);
}

Time_ns EmulatedUnit::lockFailsafeAt_ns() const
{
    if (_following.lostAt_ns == kNever_ns || _cpu.config().lockFailsafe_ns == 0) return kNever_ns;
    return std::max(_following.lostAt_ns + _cpu.config().lockFailsafe_ns, _failsafe.from_ns);
}

Time_ns EmulatedUnit::nextEvent_ns() const
{
    Time_ns next_ns = std::min(_standing.losesIdAt_ns, _cpu.fpgaWhen(fpga().due_ns()));
    if (!_inbox.queue.empty()) next_ns = std::min(next_ns, _inbox.queue.front().done_ns);
    if (!_failsafe.isHostSilent) next_ns = std::min(next_ns, failsafeAt_ns());
    if (!_failsafe.isUnlockedLong) next_ns = std::min(next_ns, lockFailsafeAt_ns());
    return next_ns;
}

void EmulatedUnit::hear(std::uint64_t peer, Time_ns now_ns)
{
    _host.heardAt_ns = now_ns;
    _host.peer = peer;
    _host.isKnown = true;
    _failsafe.isHostSilent = false;
}

void EmulatedUnit::forgetTrips(Time_ns now_ns)
{
    _failsafe.isHostSilent = _failsafe.isUnlockedLong = false;
    _failsafe.from_ns = now_ns;
}

// Each cause trips it once; it stays so until ReleaseFailsafe or Clear, whatever becomes of that.
void EmulatedUnit::trip(Time_ns now_ns)
{
    if (!_failsafe.isHostSilent && failsafeAt_ns() <= now_ns)
    {
        _failsafe.isHostSilent = true;
        tripFailsafe(now_ns);
    }
    if (!_failsafe.isUnlockedLong && lockFailsafeAt_ns() <= now_ns)
    {
        _failsafe.isUnlockedLong = true;
        ++_cpu.telemetry.lockFailsafe;
        close(now_ns);
    }
}

void EmulatedUnit::advance(Time_ns now_ns)
{
    for (Time_ns next_ns = nextEvent_ns(); next_ns <= now_ns; next_ns = nextEvent_ns())
    {
        if (_standing.losesIdAt_ns <= next_ns) loseId(next_ns);
        tellSwitches(next_ns);
        if (!_inbox.queue.empty() && _inbox.queue.front().done_ns <= next_ns)
        {
            const Frame frame = std::move(_inbox.queue.front());
            _inbox.queue.pop_front();
            finish(frame);
        }
        trip(next_ns);
    }
}

void EmulatedUnit::finish(const Frame& frame)
{
    if (frame.command == kReset)
    {
        _inbox.next = 0;
        _inbox.last = LastReply();
    }
    else if (frame.number == _inbox.next)
    {
        ++_inbox.next;
        const std::uint64_t intrusions = fpga().intrusions().banks;
        std::vector<std::uint8_t> data;
        const Result result = run(frame, data);
        if (result != Result::DONE) data.clear();
        _inbox.last = {frame.number, result, std::move(data)};
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
    if (frame.command >= 0x70 && frame.command <= 0x78) ++_counts.updateCommands;
    if (_failing.commands > 0)
    {
        --_failing.commands;
        return static_cast<Result>(_failing.result);
    }
    const Time_ns now_ns = frame.done_ns;
    const UnitMoment moment{now_ns,
                            _clock.at(now_ns),
                            _following.isLocked,
                            std::min(failsafeAt_ns(), lockFailsafeAt_ns()) <= now_ns};
    return _cpu.run(frame.command, frame.payload.data(), frame.payload.size(), moment, data);
}

void EmulatedUnit::tellWatch(const Frame& frame, std::uint64_t intrusionsBefore)
{
    if (_inbox.last.result != Result::DONE) return;
    const Time_ns now_ns = frame.done_ns;
    switch (frame.command)
    {
    case kClear:
        forgetTrips(now_ns);
        _isMasked = false;
        _watch.cleared(_place, now_ns, fpga().content());
        break;
    case 0x05: // SetCpuConfig
        if (failsafeAt_ns() > now_ns) _failsafe.isHostSilent = false;
        if (lockFailsafeAt_ns() > now_ns) _failsafe.isUnlockedLong = false;
        _failsafe.from_ns = now_ns;
        break;
    case 0x06: // ReleaseFailsafe
        _watch.closed(_place, now_ns, _isMasked);
        break;
    case 0x12: // ActivatePatternBank
        tellSwitches(now_ns);
        _watch.changed(_place, now_ns, fpga().content()); // new registers
        break;
    case 0x41: // SetOutputMask
        _isMasked = isAllOff(frame.payload);
        if (_isMasked) _watch.closed(_place, now_ns, true);
        _watch.changed(_place, now_ns, fpga().content());
        if (!_isMasked) _watch.closed(_place, now_ns, fpga().gated());
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
    _standing = {};
    _host.isKnown = false;
    _cpu.restoreConfig();
    unlock(now_ns);
    _following.lostAt_ns = kNever_ns;
    _failsafe.isUnlockedLong = false;
    _failsafe.from_ns = now_ns;
}

void EmulatedUnit::lock(const EmulatedClock& clock, Time_ns now_ns)
{
    if (!_following.isLocked && _following.lostAt_ns != kNever_ns) ++_cpu.telemetry.resync;
    _following.isLocked = true;
    _following.lostAt_ns = kNever_ns;
    _failsafe.isUnlockedLong = false;
    _clock = clock;
    _cpu.followClock(_clock, now_ns);
}

void EmulatedUnit::unlock(Time_ns now_ns)
{
    if (!_following.isLocked) return;
    _following.isLocked = false;
    _following.lostAt_ns = now_ns;
    _clock.setRate(now_ns, _options.rate_ppm);
    _cpu.followClock(_clock, now_ns);
}

// All but what it is made of, and what was counted, is as at power-up; answers on their way go on.
void EmulatedUnit::reboot(Time_ns now_ns)
{
    advance(now_ns);
    _cpu.restart();
    _clock = {now_ns, _options.started_ns, _options.rate_ppm};
    _cpu.startClock(_clock);
    _bootedAt_ns = now_ns + std::max(_options.boot_ns, kMillisecond_ns);
    _isMasked = false;
    _standing = {};
    _following = {};
    _host = {};
    _inbox = {};
    _failsafe.isHostSilent = _failsafe.isUnlockedLong = false;
    _failing = {};
    _watch.rebooted(_place, now_ns, fpga().content());
}

void EmulatedUnit::tripFailsafe(Time_ns now_ns)
{
    ++_cpu.telemetry.failsafe;
    close(now_ns);
}

void EmulatedUnit::close(Time_ns now_ns)
{
    ++_counts.trips;
    _cpu.closeGate(now_ns);
    _watch.closed(_place, now_ns, true);
}

void EmulatedUnit::failCommands(std::uint8_t result, int count)
{
    _failing.result = result;
    _failing.commands = count;
}

std::vector<std::complex<float>> EmulatedUnit::output(Time_ns now_ns)
{
    advance(now_ns);
    if (!isOn(now_ns)) return std::vector<std::complex<float>>(kUnitTransducers);
    return _cpu.fpga().output(_cpu.fpgaTime(now_ns));
}

} // namespace midair::device::emulation
