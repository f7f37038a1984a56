#pragma once

#include "device/autd3/emulator/unit/FieldWatch.h"
#include "device/autd3/emulator/unit/UnitCpu.h"

#include <deque>
#include <vector>

namespace midair::device::emulation
{

constexpr int kNoId = 255;
constexpr std::size_t kUnitQueue = 7;
constexpr std::size_t kUnitDatagramBytes = 1452;

/// Answer of a unit.
struct UnitAnswer
{
    Time_ns at_ns = 0;
    int id = kNoId;         ///< its id when answering, which determines its address
    std::uint64_t peer = 0; ///< recipient
    std::vector<std::uint8_t> bytes;
};

/// An AUTD3 unit: datagrams in, answers out, at given times. As strict as the hardware is known to
/// be; counts forbidden actions of a sender.
class EmulatedUnit
{
public:
    /// Kind and speed of a unit.
    struct Options
    {
        int protocolVersion = 2;
        UnitVersion cpu;
        UnitVersion fpga;
        Time_ns perFrame_ns = 0;   ///< >= 0; CPU time per command ..
        Time_ns perWord_ns = 0;    ///< >= 0; .. and per 16-bit word of it
        Time_ns boot_ns = 0;       ///< >= 0; silent for this time after a reboot; running initially
        std::int64_t rate_ppm = 0; ///< rate of its free-running clock
        Time_ns started_ns = 0;    ///< its clock's reading at power-up
        bool hasNext = false;      ///< another unit is connected behind it
    };

    EmulatedUnit(int place, const Options& options, FieldWatch& watch, Time_ns now_ns);

    void receive(const std::uint8_t* bytes,
                 std::size_t size,
                 bool toGroup,
                 std::uint64_t peer,
                 Time_ns now_ns);
    void advance(Time_ns now_ns);
    Time_ns nextEvent_ns() const;
    /// Appends its answers, oldest first.
    void takeAnswers(std::vector<UnitAnswer>& answers);

    bool isOn(Time_ns now_ns) const { return now_ns >= _bootedAt_ns; }
    bool passesOn(Time_ns now_ns) const { return isOn(now_ns) && _standing.isOpen; }
    int id() const { return _standing.id; }
    bool isGrandmaster() const { return _standing.isGrandmaster; }
    bool isLocked() const { return _following.isLocked; }
    Time_ns assignedAt_ns() const { return _standing.assignedAt_ns; }
    Time_ns timeSetAt_ns() const { return _standing.timeSetAt_ns; } ///< -1: never
    const EmulatedClock& clock() const { return _clock; }
    void lock(const EmulatedClock& clock, Time_ns now_ns); ///< follows \a clock from now on
    void unlock(Time_ns now_ns);                           ///< runs by itself

    void reboot(Time_ns now_ns);
    void tripFailsafe(Time_ns now_ns);
    /// Makes the next \a count commands fail with \a result.
    void failCommands(std::uint8_t result, int count);
    void setHot(bool hot) { _cpu.hot = hot; }

    const UnitCpu& cpu() const { return _cpu; }
    const UnitFpga& fpga() const { return _cpu.fpga(); }
    Time_ns fpgaTime(Time_ns now_ns) const { return _cpu.fpgaTime(now_ns); }
    std::vector<std::complex<float>> output(Time_ns now_ns);
    std::uint64_t trips() const
    {
        return _counts.trips;
    } ///< of its failsafe; Clear doesn't reset
      ///< them
    /// 70 to 78: never send them.
    std::uint64_t updateCommands() const { return _counts.updateCommands; }

private:
    /// Identity on the cable, from AssignId until it loses its id.
    struct Standing
    {
        int id = kNoId;
        bool isOpen = false;  ///< passes on
        bool hasNext = false; ///< and a unit is connected
        bool isGrandmaster = false;
        Time_ns assignedAt_ns = 0;
        Time_ns timeSetAt_ns = -1;
        Time_ns losesIdAt_ns = kNever_ns;
    };
    /// Synchronisation of its clock with the grandmaster's.
    struct Following
    {
        bool isLocked = false;
        Time_ns lostAt_ns = kNever_ns; ///< time when it lost a lock; kNever_ns: no lock to lose
    };
    /// The host, which receives the results of commands.
    struct Host
    {
        Time_ns heardAt_ns = -1; ///< time of the last frame or heartbeat; -1: none yet
        std::uint64_t peer = 0;
        bool isKnown = false; ///< since it has an id
    };
    /// A frame in the queue.
    struct Frame
    {
        std::uint16_t message = 0;
        std::uint8_t number = 0;
        std::uint8_t command = 0;
        Time_ns done_ns = 0;
        std::vector<std::uint8_t> payload;
    };
    /// Result of the last command done in sequence, with its data: all answers to frames and
    /// heartbeats contain it.
    struct LastReply
    {
        std::uint8_t acknowledged = kNothingDone; ///< its number
        Result result = Result::DONE;
        std::vector<std::uint8_t> data;
    };
    static constexpr std::uint8_t kNothingDone = 0xFF; ///< since Reset
    static constexpr int kNoFrame = 0xFFFF;            ///< at power-up
    /// Frames in sequence, and the reply to the last.
    struct Inbox
    {
        std::deque<Frame> queue;
        Time_ns busyUntil_ns = 0;
        std::uint8_t next = 0; ///< next expected number
        LastReply last;
        int lastReceived = kNoFrame; ///< number and command of the last frame that was queued
    };
    /// Each cause trips it once.
    struct Failsafe
    {
        bool isHostSilent = false;   ///< it has tripped for that ..
        bool isUnlockedLong = false; ///< .. and for that
        Time_ns from_ns = 0;         ///< not before
    };
    /// Number of commands to fail, and their result.
    struct Failing
    {
        int commands = 0;
        std::uint8_t result = 0;
    };
    /// Since the beginning; reboots don't reset them.
    struct Counts
    {
        std::uint64_t updateCommands = 0;
        std::uint64_t trips = 0;
    };
    /// A datagram in process.
    struct Request
    {
        std::uint8_t kind = 0;
        std::uint16_t message = 0;
        bool toGroup = false;
        std::uint64_t peer = 0;
        base::ByteReader body;
    };

    void answerStatus(const Request& request,
                      int status,
                      const std::vector<std::uint8_t>& more,
                      Time_ns now_ns);
    void answerFrame(std::uint8_t kind, std::uint16_t message, Time_ns now_ns);
    void handle(Request& request, Time_ns now_ns);
    void assignId(Request& request, Time_ns now_ns);
    void unblock(const Request& request, Time_ns now_ns);
    void setTime(Request& request, Time_ns now_ns);
    void takeFrame(Request& request, Time_ns now_ns);
    void hear(std::uint64_t peer, Time_ns now_ns);
    void trip(Time_ns now_ns);        ///< if it is due
    void close(Time_ns now_ns);       ///< the gate
    void forgetTrips(Time_ns now_ns); ///< so that a lasting cause trips it again
    void finish(const Frame& frame);
    Result run(const Frame& frame, std::vector<std::uint8_t>& data);
    void tellWatch(const Frame& frame, std::uint64_t intrusionsBefore);
    void tellSwitches(Time_ns now_ns);
    Time_ns failsafeAt_ns() const;
    Time_ns lockFailsafeAt_ns() const;
    void loseId(Time_ns now_ns);
    std::uint8_t flags() const;
    std::vector<std::uint8_t> info(Time_ns now_ns) const;

    const int _place; ///< on the cable, from 0
    const Options _options;
    FieldWatch& _watch;
    UnitCpu _cpu;
    EmulatedClock _clock;
    Time_ns _bootedAt_ns = 0;
    bool _isMasked = false; ///< all of it
    Standing _standing;
    Following _following;
    Host _host;
    Inbox _inbox;
    Failsafe _failsafe;
    Failing _failing;
    Counts _counts;
    std::vector<UnitAnswer> _answers;
};

} // namespace midair::device::emulation
