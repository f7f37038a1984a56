#include "device/autd3/emulator/unit/BankTimeline.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

constexpr Time_ns kTimeStep_ns = 3125; // a timed switch is cut to it

Time_ns nextMultiple(Time_ns time_ns, Time_ns step_ns)
{
    return (time_ns / step_ns + 1) * step_ns;
}

Time_ns edgeFrom(Time_ns time_ns)
{
    return (time_ns + kPeriod_ns - 1) / kPeriod_ns * kPeriod_ns;
}

} // namespace

void BankTimeline::clear(std::uint32_t slots)
{
    *this = BankTimeline();
    for (int bank = 0; bank < 2; ++bank)
        _written[bank].slots = _valid[bank].slots = slots;
}

void BankTimeline::play(int bank, Time_ns at_ns, bool forEver)
{
    _last = {edgeFrom(at_ns), bank, bank == _bank};
    _switched = true;
    _bank = bank;
    _start_ns = at_ns;
    _forEver = forEver;
    _waits = false;
}

Result BankTimeline::activate(int bank,
                              Activation mode,
                              std::uint64_t value,
                              Time_ns fpga_ns,
                              Time_ns cpu_ns,
                              const Rules& rules)
{
    const bool forEver = _written[bank].rounds == 0;
    if (forEver != (mode == Activation::NOW)) return Result::MODE;
    const auto time_ns = static_cast<Time_ns>(std::min(value, std::uint64_t(kNever_ns / 2)));
    if (mode == Activation::TIME && time_ns - cpu_ns < rules.margin_ns) return Result::TIME;
    const auto fits = [&](int heard)
    { return _written[heard].divider >= static_cast<std::uint32_t>(rules.steps); };
    // Until a switch with rounds comes about, the other bank is heard.
    if (!fits(bank) || (!forEver && !fits(_bank))) return Result::SILENCER;
    _valid = _written;
    if (forEver)
    {
        _requested = bank;
        play(bank, fpga_ns, true);
        return Result::DONE;
    }
    if (bank == _requested) return Result::DONE; // and nothing happens
    _requested = bank;
    _waits = true;
    _due_ns = mode == Activation::TIME
                  ? time_ns / kTimeStep_ns * kTimeStep_ns
                  : nextMultiple(fpga_ns, _valid[bank].slot_ns() * Time_ns(_valid[bank].slots));
    return Result::DONE;
}

bool BankTimeline::takeSwitch(Time_ns fpga_ns, Switch& made)
{
    if (!_switched && _waits && _due_ns <= fpga_ns) play(_requested, _due_ns, false);
    if (!_switched) return false;
    _switched = false;
    made = _last;
    return true;
}

bool BankTimeline::reaches(int steps) const
{
    const auto fits = [&](int heard)
    { return _valid[heard].divider >= static_cast<std::uint32_t>(steps); };
    return fits(_requested) && (_valid[_requested].rounds == 0 || fits(_bank));
}

std::uint32_t BankTimeline::slotAt(Time_ns fpga_ns) const
{
    const BankRegisters& registers = playing();
    const auto step = std::uint64_t(fpga_ns / registers.slot_ns());
    if (_forEver) return static_cast<std::uint32_t>(step % registers.slots);
    if (endedAt(fpga_ns)) return registers.slots - 1;
    const Time_ns played = Time_ns(step) - _start_ns / registers.slot_ns();
    return played < 0 ? 0 : static_cast<std::uint32_t>(std::uint64_t(played) % registers.slots);
}

bool BankTimeline::endedAt(Time_ns fpga_ns) const
{
    if (_forEver) return false;
    const BankRegisters& registers = playing();
    return fpga_ns / registers.slot_ns() - _start_ns / registers.slot_ns() >=
           Time_ns(registers.slots) * registers.rounds;
}

} // namespace midair::device::emulation
