#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"
#include "device/autd3/emulator/unit/EmulatedUnit.h"

#include <complex>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <random>
#include <vector>

namespace midair::device
{
class DeviceUri;
}

namespace midair::device::emulation
{

/// Faults of a cable with units. Probabilities (0 .. 1) are per datagram, in both directions; times
/// are since the beginning.
struct ChainFaults
{
    double drop = 0;
    double duplicate = 0;
    double reorder = 0;     ///< delayed by reorder_ns, so that others overtake it
    double garbage = 0;     ///< per answer: a damaged or foreign one comes before it
    double error = 0;       ///< per frame: its unit's next command fails
    Time_ns latency_ns = 0; ///< >= 0; each way
    Time_ns jitter_ns = 0;  ///< >= 0; maximum of the added random delay
    Time_ns reorder_ns = 2 * kMillisecond_ns;
    unsigned seed = 1;
    std::uint8_t errorResult = 0x07; ///< result of failing commands
    int lostAssignments = 0;         ///< number of lost first answers to AssignId

    /// Timed event of a unit; Event has the names.
    enum class Kind
    {
        REBOOT,
        SYNC_LOST, ///< its clock runs free from then on
        SYNC_BACK,
        FAILSAFE, ///< tripped in any case
        HOT,
        UNPLUG, ///< the host's cable; the unit is ignored
        REPLUG,
        HANG ///< the host's datagrams no longer arrive; answers do
    };
    struct Event
    {
        Time_ns at_ns = 0;
        Kind kind = Kind::REBOOT;
        int unit = 0;
    };
    std::vector<Event> events;
};

/// Emulated units and their cable.
struct ChainOptions
{
    int units = 1; ///< 1 .. 64
    int protocolVersion = 2;
    int firmware[3] = {0, 10, 0};  ///< of the CPU
    int gateware[3] = {0, 10, 0};  ///< of the FPGA
    Time_ns wirePerByte_ns = 0;    ///< 80 for a 100 Mbit/s cable; 0: no time
    Time_ns perFrame_ns = 0;       ///< CPU time of units per command ..
    Time_ns perWord_ns = 0;        ///< .. and per 16-bit word
    Time_ns settle_ns = 0;         ///< time until clocks follow, from SetTime or from getting an id
    Time_ns boot_ns = 0;           ///< time to boot a unit
    std::int64_t drift_ppm = 0;    ///< of the units' clocks against the host's, up to 1000
    Time_ns clockError_ns = 0;     ///< largest deviation of synchronised units from the grandmaster
    Time_ns tolerance_ns = 50'000; ///< longest duration of a field change
    ChainFaults faults;

    /// Typical values of units on a real cable, known or estimated.
    static ChainOptions realistic(int units);
};

/// Takes units, faults and other options from \a uri, with defaults \a defaults; throws
/// DeviceError.
ChainOptions takeChainOptions(DeviceUri& uri, const ChainOptions& defaults);

constexpr int kGroup = 256; ///< address of all units; other addresses are ids, or kNoId

/// Events on the cable.
struct ChainReport
{
    std::uint64_t fromHost = 0; ///< datagrams sent to units
    std::uint64_t toHost = 0;   ///< answers delivered to the host
    std::uint64_t dropped = 0;  ///< by faults, in both directions
    std::uint64_t tooMany = 0;  ///< discarded because 65,536 were in transit
    std::uint64_t unheard = 0;  ///< to an id that no reachable unit has
    std::uint64_t updateCommands = 0;
    std::uint64_t writesIntoBanks = 0; ///< UnitFpga::Intrusions of all units
    std::uint64_t writesIntoSlots = 0;
    UnitTelemetry telemetry; ///< sums over all units, since power-up or Clear
    std::uint64_t trips = 0; ///< of failsafes, since the beginning
    FieldWatchReport fields;
};

/// AUTD3 units on one cable, in virtual time: datagrams in, answers out. Models reachability, clock
/// synchronisation and faults.
class EmulatedChain
{
public:
    /// An answer delivered to the host.
    struct Answer
    {
        int from = kNoId; ///< its unit's id, or -1: a foreign sender
        std::uint64_t peer = 0;
        std::vector<std::uint8_t> bytes;
    };

    explicit EmulatedChain(const ChainOptions& options, Time_ns now_ns = 0);
    ~EmulatedChain();
    EmulatedChain(const EmulatedChain&) = delete;
    EmulatedChain& operator=(const EmulatedChain&) = delete;

    /// Sends a datagram of the host \a peer to an id, kNoId or kGroup.
    void
    send(int to, const std::uint8_t* bytes, std::size_t size, std::uint64_t peer, Time_ns now_ns);
    /// Takes the next answer delivered by \a now_ns; false: none.
    bool receive(Answer& answer, Time_ns now_ns);
    void advance(Time_ns now_ns); ///< times never decrease
    Time_ns nextEvent_ns() const;
    /// Time for which the datagrams already sent occupy the first cable.
    Time_ns backlog_ns(Time_ns now_ns) const
    {
        return std::max<Time_ns>(0, _cable.free_ns - now_ns);
    }

    /// Immediate faults.
    void happen(ChainFaults::Kind kind, int unit, Time_ns now_ns);
    void failCommands(int unit, std::uint8_t result, int count)
    {
        _places[unit].unit->failCommands(result, count);
    }
    void setFaults(const ChainFaults& faults) { _options.faults = faults; }
    /// Delivers a datagram to the host from a foreign sender, or from unit \a from.
    void
    inject(int from, std::uint64_t peer, const std::vector<std::uint8_t>& bytes, Time_ns now_ns)
    {
        launch(now_ns, {true, from, 0, peer, bytes});
    }

    int units() const { return static_cast<int>(_places.size()); }
    const EmulatedUnit& unit(int place) const { return *_places[place].unit; }
    FieldWatch& watch() { return _watch; }
    /// Output of all transducers, unit by unit, relative to full drive.
    std::vector<std::complex<float>> output(Time_ns now_ns);
    /// Playing field, in our levels, without silencer and modulation; silence for closed gates.
    DriveSignal field(Time_ns now_ns);
    ChainReport report(Time_ns now_ns) const;

private:
    /// A datagram in transit.
    struct Flight
    {
        bool toHost = false;
        int address = kGroup; ///< or sender of the answer
        int place = 0;        ///< destination unit, if it is for the group
        std::uint64_t peer = 0;
        std::vector<std::uint8_t> bytes;
    };

    /// A place on the cable, its unit, and its connection to the grandmaster.
    struct Place
    {
        std::unique_ptr<EmulatedUnit> unit;
        Time_ns next_ns = 0;       ///< time of the unit's next event
        Time_ns clockError_ns = 0; ///< of a synchronised clock
        bool isSyncLost = false;
        Time_ns syncBackAt_ns = 0;
        Time_ns heardMaster_ns = 0; ///< last
    };
    /// The cable, and the host at its end.
    struct Cable
    {
        std::multimap<Time_ns, Flight> flights;
        std::deque<Answer> arrived;
        Time_ns free_ns = 0; ///< busy until then
        bool isUnplugged = false;
        bool hangs = false; ///< towards the units
    };

    int reach(Time_ns now_ns) const; ///< number of reachable units: all before them are open
    bool within(int place, Time_ns now_ns) const { return place < reach(now_ns); }
    void arrive(int place, Flight& flight, Time_ns now_ns);
    Time_ns wire_ns(std::size_t size) const; ///< time that a payload occupies a cable
    void touched(int place) { _places[place].next_ns = _places[place].unit->nextEvent_ns(); }
    int grandmaster() const;
    /// Among the first \a reached units; \a master < 0: none.
    bool hears(int place, int master, int reached, Time_ns now_ns) const;
    void updateClocks(Time_ns now_ns);
    Time_ns clockEvent_ns() const;
    Time_ns lockAt_ns(int place, int master) const;
    void step(Time_ns now_ns);
    void deliver(Flight& flight, Time_ns now_ns);
    void collect(Time_ns now_ns);
    void launch(Time_ns at_ns, Flight flight);
    void launchAnswer(int place, UnitAnswer& answer);
    void addGarbage(const Flight& answer, Time_ns at_ns);
    Time_ns late(Time_ns at_ns); ///< with latency, jitter and reordering
    bool chance(double probability);

    ChainOptions _options;
    const Time_ns _began_ns;
    std::minstd_rand _random;
    FieldWatch _watch;
    std::vector<Place> _places;
    Cable _cable;
    std::vector<UnitAnswer> _answers; ///< kept for its memory
    Time_ns _masterSetAt_ns = -1;
    Time_ns _now_ns = 0;
    std::size_t _eventsDone = 0;
    ChainReport _counts;
};

} // namespace midair::device::emulation
