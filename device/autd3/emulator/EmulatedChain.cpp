#include "device/autd3/emulator/EmulatedChain.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

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

} // namespace

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
        // Quartzes differ, and units are switched on one after the other.
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
        launch(start_ns, std::move(flight)); // units pass it on from one to the next
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

// Each unit passes a datagram on whole. What is for one unit is not looked at by those before it,
// so it makes the way in one go.
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
        launch(now_ns + wire_ns(flight.bytes.size()), std::move(flight));
        return;
    }
    if (flight.place > 0) // it has come there
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
        launch(now_ns + place * wire_ns(flight.bytes.size()), std::move(flight));
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

// Another answer than the one that is due: cut, lengthened, changed in a byte, or from a stranger.
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
    case 2: // version, kind, message number: what tells it from an answer that is waited for
        garbage.bytes[_random() % 4] ^= static_cast<std::uint8_t>(1U + _random() % 255);
        break;
    default:
        garbage.address = -1;
        break;
    }
    launch(at_ns, std::move(garbage));
}

void EmulatedChain::inject(int from,
                           std::uint64_t peer,
                           const std::vector<std::uint8_t>& bytes,
                           Time_ns now_ns)
{
    launch(now_ns, {true, from, 0, peer, bytes});
}

bool EmulatedChain::receive(Answer& answer, Time_ns now_ns)
{
    advance(now_ns);
    if (_cable.arrived.empty()) return false;
    answer = std::move(_cable.arrived.front());
    _cable.arrived.pop_front();
    return true;
}

} // namespace midair::device::emulation
