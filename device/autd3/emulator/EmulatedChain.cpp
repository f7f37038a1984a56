#include "device/autd3/emulator/EmulatedChain.h"

#include "device/DeviceUri.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace midair::device::emulation
{

namespace
{

constexpr double kLatest_s = 1e6;

Time_ns nanoseconds(double time_s)
{
    return static_cast<Time_ns>(std::llround(time_s * 1e9));
}

void takeVersion(DeviceUri& uri, const std::string& key, int (&version)[3])
{
    const std::string text = uri.takeText(key, "");
    if (text.empty()) return;
    int read[3] = {0, 0, 0};
    int end = 0;
    const int found =
        std::sscanf(text.c_str(), "%3d.%3d.%3d%n", &read[0], &read[1], &read[2], &end);
    bool good = found == 3 && static_cast<std::size_t>(end) == text.size();
    for (const int part : read)
        good = good && part >= 0 && part <= 255;
    if (!good) throw uri.error(fmt::format("{}={} should be a version such as 0.10.0", key, text));
    std::copy(read, read + 3, version);
}

// "reboot_at=5s&reboot_unit=3", each kind once; programs can add any number.
void takeEvent(DeviceUri& uri, ChainOptions& options, const char* name, ChainFaults::Kind kind)
{
    const std::string at = std::string(name) + "_at";
    const bool ofUnit = kind != ChainFaults::Kind::UNPLUG && kind != ChainFaults::Kind::REPLUG &&
                        kind != ChainFaults::Kind::HANG;
    const double time_s = uri.takeSeconds(at, kLatest_s);
    double unit = 0;
    if (ofUnit) unit = uri.takeNumber(std::string(name) + "_unit", 0, 0, options.units - 1);
    if (time_s < kLatest_s)
        options.faults.events.push_back({nanoseconds(time_s), kind, static_cast<int>(unit)});
}

constexpr std::size_t kMostFlights = 65536;
constexpr std::size_t kMostArrived = 4096;
constexpr Time_ns kFramingBytes = 86; // Ethernet, IPv6 and UDP round a payload
constexpr std::uint8_t kAssignId = 4;

UnitVersion versionOf(const int (&parts)[3])
{
    return {static_cast<std::uint8_t>(parts[0]),
            static_cast<std::uint8_t>(parts[1]),
            static_cast<std::uint8_t>(parts[2])};
}

ChainOptions inOrder(ChainOptions options)
{
    std::stable_sort(options.faults.events.begin(),
                     options.faults.events.end(),
                     [](const auto& a, const auto& b) { return a.at_ns < b.at_ns; });
    return options;
}

constexpr Time_ns kHoldover_ns = 1000 * kMillisecond_ns;

} // namespace

ChainOptions ChainOptions::realistic(int units)
{
    ChainOptions options;
    options.units = units;
    options.wirePerByte_ns = 80;
    options.perFrame_ns = 10'000;
    options.perWord_ns = 200; // twice 249 words in 0.1 ms
    options.settle_ns = 1'000 * kMillisecond_ns;
    options.boot_ns = 2'000 * kMillisecond_ns;
    options.drift_ppm = 20;
    options.clockError_ns = 125;
    return options;
}

ChainOptions takeChainOptions(DeviceUri& uri, const ChainOptions& defaults)
{
    ChainOptions options = defaults;
    ChainFaults& faults = options.faults;
    options.units = static_cast<int>(uri.takeNumber("units", options.units, 1, 64));
    options.protocolVersion = static_cast<int>(uri.takeNumber("version", 2, 0, 255));
    takeVersion(uri, "firmware", options.firmware);
    takeVersion(uri, "gateware", options.gateware);
    options.settle_ns = nanoseconds(uri.takeSeconds("settle", double(options.settle_ns) / 1e9));
    options.drift_ppm = static_cast<std::int64_t>(
        uri.takeNumber("drift_ppm", double(options.drift_ppm), -500, 500));
    options.tolerance_ns =
        nanoseconds(uri.takeSeconds("tolerance", double(options.tolerance_ns) / 1e9));
    faults.drop = uri.takeNumber("drop", 0, 0, 1);
    faults.duplicate = uri.takeNumber("duplicate", 0, 0, 1);
    faults.reorder = uri.takeNumber("reorder", 0, 0, 1);
    faults.garbage = uri.takeNumber("garbage", 0, 0, 1);
    faults.error = uri.takeNumber("error", 0, 0, 1);
    faults.errorResult = static_cast<std::uint8_t>(uri.takeNumber("error_result", 7, 1, 255));
    faults.latency_ns = nanoseconds(uri.takeSeconds("latency", 0));
    faults.jitter_ns = nanoseconds(uri.takeSeconds("jitter", 0));
    faults.seed = static_cast<unsigned>(uri.takeNumber("seed", 1, 0, 1e9));
    faults.lostAssignments = static_cast<int>(uri.takeNumber("lost_assignments", 0, 0, 1000));
    takeEvent(uri, options, "reboot", ChainFaults::Kind::REBOOT);
    takeEvent(uri, options, "sync_lost", ChainFaults::Kind::SYNC_LOST);
    takeEvent(uri, options, "sync_back", ChainFaults::Kind::SYNC_BACK);
    takeEvent(uri, options, "failsafe", ChainFaults::Kind::FAILSAFE);
    takeEvent(uri, options, "hot", ChainFaults::Kind::HOT);
    takeEvent(uri, options, "unplug", ChainFaults::Kind::UNPLUG);
    takeEvent(uri, options, "replug", ChainFaults::Kind::REPLUG);
    takeEvent(uri, options, "hang", ChainFaults::Kind::HANG);
    return options;
}

EmulatedChain::EmulatedChain(const ChainOptions& options, Time_ns now_ns) :
    _options(inOrder(options)),
    _began_ns(now_ns),
    _random(options.faults.seed),
    _watch(options.units, options.tolerance_ns),
    _places(static_cast<std::size_t>(options.units)),
    _now_ns(now_ns)
{
    for (int place = 0; place < options.units; ++place)
    {
        EmulatedUnit::Options unit;
        unit.protocolVersion = options.protocolVersion;
        unit.cpu = versionOf(options.firmware);
        unit.fpga = versionOf(options.gateware);
        unit.perFrame_ns = options.perFrame_ns;
        unit.perWord_ns = options.perWord_ns;
        unit.boot_ns = options.boot_ns;
        // Quartz rates differ, and units are switched on one after the other.
        unit.rate_ppm = place % 2 == 0 ? options.drift_ppm : -options.drift_ppm / 2;
        unit.started_ns = place * 1'737'113;
        unit.hasNext = place + 1 < options.units;
        Place& here = _places[static_cast<std::size_t>(place)];
        here.unit = std::make_unique<EmulatedUnit>(place, unit, _watch, now_ns);
        touched(place);
        const Time_ns error_ns = options.clockError_ns;
        if (error_ns > 0)
            here.clockError_ns = static_cast<Time_ns>(_random() % (2 * error_ns + 1)) - error_ns;
    }
}

EmulatedChain::~EmulatedChain() = default;

bool EmulatedChain::chance(double probability)
{
    return probability > 0 && std::uniform_real_distribution<double>(0, 1)(_random) < probability;
}

Time_ns EmulatedChain::late(Time_ns at_ns)
{
    const ChainFaults& faults = _options.faults;
    at_ns += faults.latency_ns;
    if (faults.jitter_ns > 0) at_ns += static_cast<Time_ns>(_random() % (faults.jitter_ns + 1));
    if (chance(faults.reorder)) at_ns += faults.reorder_ns;
    return at_ns;
}

void EmulatedChain::launch(Time_ns at_ns, Flight flight)
{
    if (_cable.flights.size() < kMostFlights)
        _cable.flights.emplace(at_ns, std::move(flight));
    else
        ++_counts.tooMany;
}

void EmulatedChain::send(
    int to, const std::uint8_t* bytes, std::size_t size, std::uint64_t peer, Time_ns now_ns)
{
    advance(now_ns);
    ++_counts.fromHost;
    _cable.free_ns = std::max(_cable.free_ns, now_ns) + wire_ns(size);
    const bool lost = _cable.isUnplugged || _cable.hangs || chance(_options.faults.drop);
    if (lost) ++_counts.dropped;
    if (lost || size > kUnitDatagramBytes) return;
    const int copies = chance(_options.faults.duplicate) ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy)
    {
        const Time_ns start_ns = late(_cable.free_ns);
        Flight flight{false, to, 0, peer, {bytes, bytes + size}};
        launch(start_ns, std::move(flight)); // each unit forwards it to the next
    }
    advance(now_ns);
}

Time_ns EmulatedChain::wire_ns(std::size_t size) const
{
    return (static_cast<Time_ns>(size) + kFramingBytes) * _options.wirePerByte_ns;
}

int EmulatedChain::reach(Time_ns now_ns) const
{
    int reached = 1;
    while (reached < units() && _places[reached - 1].unit->passesOn(now_ns))
        ++reached;
    return reached;
}

void EmulatedChain::arrive(int place, Flight& flight, Time_ns now_ns)
{
    EmulatedUnit& unit = *_places[place].unit;
    const bool toGroup = flight.address == kGroup;
    if (!toGroup && flight.bytes.size() > 4 && flight.bytes[1] == 0 &&
        chance(_options.faults.error))
        unit.failCommands(_options.faults.errorResult, 1);
    unit.receive(flight.bytes.data(), flight.bytes.size(), toGroup, flight.peer, now_ns);
    touched(place);
}

// Each unit forwards a datagram when it is complete. Units on the way ignore one for another unit,
// so it travels in one step.
void EmulatedChain::deliver(Flight& flight, Time_ns now_ns)
{
    if (flight.toHost)
    {
        if (_cable.isUnplugged || _cable.arrived.size() >= kMostArrived) return;
        ++_counts.toHost;
        _cable.arrived.push_back({flight.address, flight.peer, std::move(flight.bytes)});
        return;
    }
    if (flight.address == kGroup)
    {
        if (!_places[flight.place].unit->isOn(now_ns)) return;
        const bool passes = _places[flight.place].unit->passesOn(now_ns);
        arrive(flight.place, flight, now_ns);
        if (!passes || flight.place + 1 == units()) return;
        ++flight.place;
        // Computed before the move: the order of argument evaluation is unspecified.
        const auto onward_ns = now_ns + wire_ns(flight.bytes.size());
        launch(onward_ns, std::move(flight));
        return;
    }
    if (flight.place > 0) // it has arrived there
    {
        if (within(flight.place, now_ns) && _places[flight.place].unit->id() == flight.address)
            arrive(flight.place, flight, now_ns);
        return;
    }
    const int reached = reach(now_ns);
    int place = 0;
    while (place < reached && _places[place].unit->id() != flight.address)
        ++place;
    if (place == reached)
        ++_counts.unheard;
    else if (place == 0)
        arrive(0, flight, now_ns);
    else
    {
        flight.place = place;
        const auto onward_ns = now_ns + place * wire_ns(flight.bytes.size());
        launch(onward_ns, std::move(flight));
    }
}

void EmulatedChain::launchAnswer(int place, UnitAnswer& answer)
{
    Flight flight{true, answer.id, place, answer.peer, std::move(answer.bytes)};
    if (flight.bytes[1] == kAssignId && _options.faults.lostAssignments > 0)
    {
        --_options.faults.lostAssignments;
        ++_counts.dropped;
        return;
    }
    if (!within(place, answer.at_ns)) return;
    const Time_ns there_ns = answer.at_ns + (place + 1) * wire_ns(flight.bytes.size());
    if (chance(_options.faults.garbage)) addGarbage(flight, there_ns);
    if (chance(_options.faults.drop))
    {
        ++_counts.dropped;
        return;
    }
    if (chance(_options.faults.duplicate)) launch(late(there_ns), flight);
    launch(late(there_ns), std::move(flight));
}

// An extra answer: truncated, lengthened, with a changed byte, or from a foreign sender.
void EmulatedChain::addGarbage(const Flight& answer, Time_ns at_ns)
{
    Flight garbage = answer;
    switch (_random() % 4)
    {
    case 0:
        garbage.bytes.resize(_random() % (garbage.bytes.size() + 1));
        break;
    case 1:
        garbage.bytes.resize(garbage.bytes.size() + 1 + _random() % 64,
                             static_cast<std::uint8_t>(_random()));
        break;
    case 2: // version, kind, message number: distinguishes it from an expected answer
        garbage.bytes[_random() % 4] ^= static_cast<std::uint8_t>(1U + _random() % 255);
        break;
    default:
        garbage.address = -1;
        break;
    }
    launch(at_ns, std::move(garbage));
}

bool EmulatedChain::receive(Answer& answer, Time_ns now_ns)
{
    advance(now_ns);
    if (_cable.arrived.empty()) return false;
    answer = std::move(_cable.arrived.front());
    _cable.arrived.pop_front();
    return true;
}

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
