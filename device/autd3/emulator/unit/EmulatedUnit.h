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

/// What a unit sends back.
struct UnitAnswer
{
    Time_ns at_ns = 0;
    int id = kNoId;         ///< its id when it answers, which is its address
    std::uint64_t peer = 0; ///< whom it answers
    std::vector<std::uint8_t> bytes;
};

/// An AUTD3 unit: datagrams in, answers out, at times that are given. As strict as the hardware is
/// known to be; what a sender must not do is counted.
class EmulatedUnit
{
public:
    /// What kind of unit it is, and how fast.
    struct Options
    {
        int protocolVersion = 2;
        UnitVersion cpu;
        UnitVersion fpga;
        Time_ns perFrame_ns = 0;   ///< >= 0; the CPU's time for a command ..
        Time_ns perWord_ns = 0;    ///< >= 0; .. and for each 16-bit word of it
        Time_ns boot_ns = 0;       ///< >= 0; silent for so long after a reboot; is up at first
        std::int64_t rate_ppm = 0; ///< how fast its clock runs by itself
        Time_ns started_ns = 0;    ///< what that reads at power-up
        bool hasNext = false;      ///< another unit hangs behind it
    };

    EmulatedUnit(int place, const Options& options, FieldWatch& watch, Time_ns now_ns);

    void receive(const std::uint8_t* bytes,
                 std::size_t size,
                 bool toGroup,
                 std::uint64_t peer,
                 Time_ns now_ns);
    void advance(Time_ns now_ns);
    Time_ns nextEvent_ns() const;
    /// Appends what it has to answer, oldest first.
    void takeAnswers(std::vector<UnitAnswer>& answers);

    bool isOn(Time_ns now_ns) const { return now_ns >= _bootedAt_ns; }
    bool passesOn(Time_ns now_ns) const { return isOn(now_ns) && _open; }
    int id() const { return _id; }
    bool isGrandmaster() const { return _grandmaster; }
    bool isLocked() const { return _locked; }
    Time_ns assignedAt_ns() const { return _assignedAt_ns; }
    Time_ns timeSetAt_ns() const { return _timeSetAt_ns; } ///< -1: never
    const EmulatedClock& clock() const { return _clock; }
    void lock(const EmulatedClock& clock, Time_ns now_ns); ///< follows \a clock from now on
    void unlock(Time_ns now_ns);                           ///< runs by itself

    void reboot(Time_ns now_ns);
    void tripFailsafe(Time_ns now_ns);
    /// The next \a count commands in turn are not done and end with \a result.
    void failCommands(std::uint8_t result, int count);
    void setHot(bool hot) { _cpu.hot = hot; }

    const UnitCpu& cpu() const { return _cpu; }
    const UnitFpga& fpga() const { return _cpu.fpga(); }
    Time_ns fpgaTime(Time_ns now_ns) const { return _cpu.fpgaTime(now_ns); }
    std::vector<std::complex<float>> output(Time_ns now_ns);
    std::uint64_t trips() const { return _trips; } ///< of its failsafe; Clear forgets none
    std::uint64_t updateCommands() const { return _updateCommands; } ///< 70 to 78: never send them

private:
    /// A frame in the queue.
    struct Frame
    {
        std::uint16_t message = 0;
        std::uint8_t number = 0;
        std::uint8_t command = 0;
        Time_ns done_ns = 0;
        std::vector<std::uint8_t> payload;
    };
    /// What became of the last command that was done in turn: all answers to frames, and to
    /// heartbeats, have that, its data too.
    struct LastReply
    {
        std::uint8_t acknowledged = kNothingDone; ///< its number
        Result result = Result::DONE;
        std::vector<std::uint8_t> data;
    };
    static constexpr std::uint8_t kNothingDone = 0xFF; ///< since Reset
    static constexpr int kNoFrame = 0xFFFF;            ///< at power-up
    /// A datagram that it looks at.
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
    void trip(Time_ns now_ns);        ///< if it is time to
    void close(Time_ns now_ns);       ///< the gate
    void forgetTrips(Time_ns now_ns); ///< so that a cause that lasts trips it again
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
    int _id = kNoId;
    bool _open = false;
    bool _behind = false;
    bool _grandmaster = false;
    bool _locked = false;
    Time_ns _unlockedAt_ns = kNever_ns; ///< when it lost a lock that it had; kNever_ns: it didn't
    Time_ns _assignedAt_ns = 0;
    Time_ns _timeSetAt_ns = -1;
    Time_ns _losesIdAt_ns = kNever_ns;
    Time_ns _heardAt_ns = -1; ///< the last frame or heartbeat; -1: none yet
    std::uint64_t _host = 0;  ///< who sent it: commands that are done are told to that one
    bool _hasHost = false;    ///< since it has an id
    std::deque<Frame> _queue;
    Time_ns _busyUntil_ns = 0;
    std::uint8_t _next = 0; ///< number that is due
    LastReply _last;
    int _lastReceived = kNoFrame; ///< number and command of the last frame that was queued
    bool _hostSilent = false;     ///< its failsafe has tripped for that ..
    bool _unlockedLong = false;   ///< .. and for that
    Time_ns _tripsFrom_ns = 0;    ///< not before
    int _failing = 0;
    std::uint8_t _failure = 0;
    bool _maskedAll = false;
    std::uint64_t _updateCommands = 0;
    std::uint64_t _trips = 0;
    std::vector<UnitAnswer> _answers;
};

} // namespace midair::device::emulation
