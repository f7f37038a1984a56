// What happens on a cable as time passes: who hears whom, whose clock is followed, planned faults.

#include "device/autd3/emulator/EmulatedChain.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

constexpr Time_ns kHoldover_ns = 1000 * kMillisecond_ns;

} // namespace

int EmulatedChain::grandmaster() const
{
    for (int place = 0; place < units(); ++place)
        if (_places[place].unit->isOn(_now_ns) && _places[place].unit->isGrandmaster() &&
            _places[place].unit->timeSetAt_ns() >= 0)
            return place;
    return -1;
}

bool EmulatedChain::hears(int place, int master, int reached, Time_ns now_ns) const
{
    const EmulatedUnit& unit = *_places[place].unit;
    return master >= 0 && !_places[place].isSyncLost && unit.isOn(now_ns) && unit.id() != kNoId &&
           std::max(place, master) < reached;
}

Time_ns EmulatedChain::lockAt_ns(int place, int master) const
{
    return std::max({_places[master].unit->timeSetAt_ns(),
                     _places[place].unit->assignedAt_ns(),
                     _places[place].syncBackAt_ns}) +
           _options.settle_ns;
}

void EmulatedChain::updateClocks(Time_ns now_ns)
{
    const int master = grandmaster();
    const Time_ns setAt_ns = master < 0 ? -1 : _places[master].unit->timeSetAt_ns();
    const bool setAnew = setAt_ns != _masterSetAt_ns && setAt_ns >= 0;
    _masterSetAt_ns = setAt_ns;
    const int reached = reach(now_ns);
    for (int place = 0; place < units(); ++place)
    {
        EmulatedUnit& unit = *_places[place].unit;
        const bool wasLocked = unit.isLocked();
        if (setAnew || _places[place].isSyncLost) unit.unlock(now_ns);
        if (hears(place, master, reached, now_ns))
        {
            _places[place].heardMaster_ns = now_ns;
            if (!unit.isLocked() && now_ns >= lockAt_ns(place, master))
            {
                EmulatedClock clock = _places[master].unit->clock();
                if (place != master) clock.reading_ns += _places[place].clockError_ns;
                unit.lock(clock, now_ns);
            }
        }
        else if (now_ns >= _places[place].heardMaster_ns + kHoldover_ns)
            unit.unlock(now_ns);
        if (setAnew || unit.isLocked() != wasLocked) touched(place);
    }
}

Time_ns EmulatedChain::clockEvent_ns() const
{
    Time_ns next_ns = kNever_ns;
    const int master = grandmaster();
    const int reached = reach(_now_ns);
    for (int place = 0; place < units(); ++place)
    {
        const bool locked = _places[place].unit->isLocked();
        const bool heard = hears(place, master, reached, _now_ns);
        if (heard && !locked) next_ns = std::min(next_ns, lockAt_ns(place, master));
        if (!heard && locked)
            next_ns = std::min(next_ns, _places[place].heardMaster_ns + kHoldover_ns);
    }
    return next_ns;
}

Time_ns EmulatedChain::nextEvent_ns() const
{
    Time_ns next_ns = clockEvent_ns();
    if (!_cable.flights.empty()) next_ns = std::min(next_ns, _cable.flights.begin()->first);
    if (_eventsDone < _options.faults.events.size())
        next_ns = std::min(next_ns, _began_ns + _options.faults.events[_eventsDone].at_ns);
    for (const Place& place : _places)
        next_ns = std::min(next_ns, place.next_ns);
    return next_ns;
}

void EmulatedChain::advance(Time_ns now_ns)
{
    for (Time_ns next_ns = nextEvent_ns(); next_ns <= now_ns; next_ns = nextEvent_ns())
        step(std::max(next_ns, _now_ns));
    _now_ns = std::max(_now_ns, now_ns);
}

void EmulatedChain::step(Time_ns now_ns)
{
    _now_ns = now_ns;
    const std::vector<ChainFaults::Event>& events = _options.faults.events;
    while (_eventsDone < events.size() && _began_ns + events[_eventsDone].at_ns <= now_ns)
    {
        const ChainFaults::Event event = events[_eventsDone++];
        happen(event.kind, event.unit, now_ns);
    }
    for (int place = 0; place < units(); ++place)
        if (_places[place].next_ns <= now_ns)
        {
            _places[place].unit->advance(now_ns);
            touched(place);
        }
    if (!_cable.flights.empty() && _cable.flights.begin()->first <= now_ns)
    {
        Flight flight = std::move(_cable.flights.begin()->second);
        _cable.flights.erase(_cable.flights.begin());
        deliver(flight, now_ns);
    }
    collect(now_ns);
    updateClocks(now_ns);
}

void EmulatedChain::collect(Time_ns now_ns)
{
    for (int place = 0; place < units(); ++place)
    {
        _answers.clear();
        _places[place].unit->takeAnswers(_answers);
        for (UnitAnswer& answer : _answers)
            if (_places[place].unit->isOn(now_ns)) launchAnswer(place, answer);
    }
}

void EmulatedChain::happen(ChainFaults::Kind kind, int unit, Time_ns now_ns)
{
    if (unit < 0 || unit >= units()) return;
    switch (kind)
    {
    case ChainFaults::Kind::REBOOT:
        _places[unit].unit->reboot(now_ns);
        break;
    case ChainFaults::Kind::SYNC_LOST:
        _places[unit].isSyncLost = true;
        _places[unit].unit->unlock(now_ns);
        break;
    case ChainFaults::Kind::SYNC_BACK:
        _places[unit].isSyncLost = false;
        _places[unit].syncBackAt_ns = now_ns;
        break;
    case ChainFaults::Kind::FAILSAFE:
        _places[unit].unit->tripFailsafe(now_ns);
        break;
    case ChainFaults::Kind::HOT:
        _places[unit].unit->setHot(true);
        break;
    case ChainFaults::Kind::UNPLUG:
        _cable.isUnplugged = true;
        break;
    case ChainFaults::Kind::REPLUG:
        _cable.isUnplugged = false;
        break;
    case ChainFaults::Kind::HANG:
        _cable.hangs = true;
        break;
    }
    touched(unit);
}

void EmulatedChain::failCommands(int unit, std::uint8_t result, int count)
{
    _places[unit].unit->failCommands(result, count);
}

std::vector<std::complex<float>> EmulatedChain::output(Time_ns now_ns)
{
    advance(now_ns);
    std::vector<std::complex<float>> q;
    q.reserve(_places.size() * kUnitTransducers);
    for (const Place& place : _places)
    {
        const std::vector<std::complex<float>> part = place.unit->output(now_ns);
        q.insert(q.end(), part.begin(), part.end());
    }
    return q;
}

DriveSignal EmulatedChain::field(Time_ns now_ns)
{
    advance(now_ns);
    DriveSignal all;
    for (const Place& place : _places)
    {
        const auto& unit = place.unit;
        const bool sounds = unit->isOn(now_ns) && !unit->fpga().gated();
        const DriveSignal part =
            sounds ? unit->fpga().field(unit->fpgaTime(now_ns)) : silentSignal(kUnitTransducers);
        all.phase.insert(all.phase.end(), part.phase.begin(), part.phase.end());
        all.duty.insert(all.duty.end(), part.duty.begin(), part.duty.end());
    }
    return all;
}

ChainReport EmulatedChain::report(Time_ns now_ns) const
{
    ChainReport report = _counts;
    report.fields = _watch.report(now_ns);
    for (const Place& place : _places)
    {
        const auto& unit = place.unit;
        const UnitTelemetry& one = unit->cpu().telemetry;
        UnitTelemetry& all = report.telemetry;
        all.queueFull += one.queueFull;
        all.repeats += one.repeats;
        all.outOfTurn += one.outOfTurn;
        all.errors += one.errors;
        all.done += one.done;
        all.failsafe += one.failsafe;
        all.resync += one.resync;
        all.lockFailsafe += one.lockFailsafe;
        report.trips += unit->trips();
        report.updateCommands += unit->updateCommands();
        report.writesIntoBanks += unit->fpga().intrusions().banks;
        report.writesIntoSlots += unit->fpga().intrusions().slots;
    }
    return report;
}

} // namespace midair::device::emulation
