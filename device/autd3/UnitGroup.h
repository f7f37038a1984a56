#pragma once

#include "device/autd3/DatagramLink.h"
#include "device/autd3/protocol/FrameQueue.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace midair::device::autd3
{

/// The host's estimate of the units' common time, from the time stamps of answers, which are as old
/// as their return path is long.
///
/// Uses the least delayed stamp of the last second or so; the estimate lags the units' time by that
/// delay. Deadlines must be aimed a round trip later: that delay, and the way there.
class UnitClock
{
public:
    static constexpr double kWindow_s = 0.5; ///< two of these are kept
    /// A time stamp further ahead than this, ns, is ignored until kLeastAlike in a row agree.
    static constexpr double kMostAhead_ns = 0.2e9;
    static constexpr int kLeastAlike = 5;

    void reset() { *this = {}; }

    /// \a took_s: upper bound of the time from question to answer; < 0: unknown.
    void note(std::uint64_t unit_ns, double received_s, double took_s = -1)
    {
        const double difference_ns = static_cast<double>(unit_ns) - received_s * 1e9;
        const bool isAhead =
            _known && difference_ns - std::max(_now_ns, _before_ns) > kMostAhead_ns;
        if (isAhead && ++_ahead < kLeastAlike) return;
        _ahead = 0;
        if (received_s - _began_s >= kWindow_s)
        {
            const bool isOld = received_s - _began_s >= 2 * kWindow_s;
            _before_ns = isOld ? kNone : _now_ns;
            _now_ns = kNone;
            _began_s = received_s;
            if (_trip_s < kLongest_s) _tripBefore_s = std::exchange(_trip_s, kLongest_s);
        }
        if (took_s >= 0) _trip_s = std::min(_trip_s, took_s);
        _now_ns = std::max(_now_ns, difference_ns);
        _known = true;
    }

    bool isKnown() const { return _known; }
    /// Shortest recent round trip; 0: not known yet.
    double trip_s() const
    {
        const double trip_s = std::min(_trip_s, _tripBefore_s);
        return trip_s < kLongest_s ? trip_s : 0;
    }
    /// The units' time at \a host_s, ns; at least 0.
    double at_ns(double host_s) const
    {
        return std::max(0.0, host_s * 1e9 + std::max(_now_ns, _before_ns));
    }
    /// The host's time at \a unit_ns, s.
    double host_s(double unit_ns) const { return (unit_ns - std::max(_now_ns, _before_ns)) * 1e-9; }

private:
    static constexpr double kNone = -std::numeric_limits<double>::max();
    static constexpr double kLongest_s = 0.1; ///< longer ones are ignored: the unit is lost by then

    double _now_ns = kNone; ///< largest difference of the unit's and the host's time in this window
    double _before_ns = kNone;
    double _began_s = 0;
    double _trip_s = kLongest_s; ///< shortest in this window
    double _tripBefore_s = kLongest_s;
    int _ahead = 0; ///< consecutive time stamps too far ahead
    bool _known = false;
};

/// Reason for refusing a datagram.
enum class Refusal : std::uint8_t
{
    MALFORMED,      ///< not an answer of the protocol
    FOREIGN,        ///< from an address of none of our units
    STRAY,          ///< answers no open question, or one a second time
    WRONG_ID,       ///< from a unit's address, with another id or no result
    OTHER_PROTOCOL, ///< of another protocol version
    COUNT
};

/// Counts refused datagrams, and logs each kind at most every kLog_s.
///
/// Copies and late answers are normal in networks: strays are only counted.
class Refusals
{
public:
    static constexpr double kLog_s = 10;

    explicit Refusals(std::string device) : _device(std::move(device)) {}

    void add(Refusal refusal, const std::string& what, double now_s);
    std::uint64_t count(Refusal refusal) const { return _entries[index(refusal)].count; }
    std::uint64_t total() const; ///< without strays
    /// Returns "2 malformed, 1 foreign"; empty: only strays.
    std::string text() const;

private:
    /// State of one kind.
    struct Entry
    {
        std::uint64_t count = 0;
        std::uint64_t logged = 0; ///< count at the last log line
        double logged_s = 0;
    };
    static std::size_t index(Refusal refusal) { return static_cast<std::size_t>(refusal); }

    std::string _device;
    std::array<Entry, static_cast<std::size_t>(Refusal::COUNT)> _entries{};
};

/// A unit with an assigned id, and its state.
struct Unit
{
    Endpoint at;
    std::uint8_t id = kNoId; ///< its place along the cable, from 0
    std::uint8_t flags = 0;
    FrameQueue queue;
    std::string lost; ///< reason why it is lost; empty: it is present

    bool isLossTold = false;
    std::string suspicion;        ///< problem of its last answer; empty: none
    double heard_s = 0;           ///< time of its last answer
    double sent_s = 0;            ///< time of the last frame or heartbeat sent
    double pushed_s = 0;          ///< time of its last command
    double asked_s = 0;           ///< time of the first question since its last answer
    int asked = 0;                ///< number of questions since then
    std::uint16_t beat = 0;       ///< message number of the last heartbeat
    std::uint16_t unanswered = 0; ///< number of the first heartbeat that may still be answered, or
                                  ///< the next
    bool isBeatOpen = false;      ///< no answer since the last was sent
    std::array<double, 32> beats_s{}; ///< send times of the last ones, by number modulo their count
    double outOfStep_s = 0;           ///< time since when it doesn't follow the clock; 0: it does

    bool isThere() const { return lost.empty(); }
};

/// Traffic with open units: frames, heartbeats, answers, and detection of lost units.
///
/// Used by one thread at a time.
class UnitGroup
{
public:
    static constexpr double kLost_s = 0.1; ///< without an answer
    static constexpr int kLeastAsked = 3;  ///< questions before a unit is lost
    static constexpr double kResting_s = 0.1;
    static constexpr double kNever_s = std::numeric_limits<double>::max();

    /// Outcome of a command to unit \a unit.
    struct Outcome
    {
        int unit = 0;
        FrameQueue::Done done;
        std::uint64_t time_ns = 0; ///< the unit's time when it answered
    };
    /// Receives answers of kinds other than frames and heartbeats.
    using Other = std::function<void(const Endpoint&, const Answer&)>;

    /// Heartbeat intervals while nothing else is sent, s.
    struct Beats
    {
        double playing_s = 10e-3; ///< soon after a command
        double resting_s = 10e-3; ///< later than kResting_s after it
    };

    UnitGroup(DatagramLink& link, Refusals& refusals, std::vector<Unit> units, Beats beats);

    int size() const { return static_cast<int>(_units.size()); }
    Unit& unit(int k) { return _units[static_cast<std::size_t>(k)]; }
    const Unit& unit(int k) const { return _units[static_cast<std::size_t>(k)]; }
    bool isThere(int k) const { return unit(k).isThere(); }
    int count() const; ///< number of present units

    void
    push(int k, const Command& command, double repeat_s = FrameQueue::kRepeat_s, int copies = 1);

    /// Sends what is due: frames, repeats, and heartbeats to otherwise idle units.
    void pump(double now_s);
    /// Time when pump() is due without an answer.
    double due_s() const;
    /// Waits for an answer, as DatagramLink::receive() does, and takes all available ones. Without
    /// \a isPrompt they may have waited, so the clock ignores their time stamps.
    void receive(double until_s, bool isPrompt = true);
    /// Returns true if no frame is waiting.
    bool isIdle() const;
    /// Returns true if no unit received a command for kResting_s, except state requests.
    bool isResting() const;
    /// Marks units as lost that are silent, don't make progress, or have rebooted; returns true if
    /// there is a new one. Call it after receive().
    bool findLost(double now_s);
    void lose(int k, const std::string& why);
    /// Resets all answer deadlines after a pause of this program.
    void forgive(double now_s);

    /// Takes the outcomes since the last call, in order for each unit.
    std::vector<Outcome> takeOutcomes() { return std::exchange(_outcomes, {}); }
    void onOther(Other other) { _other = std::move(other); }

    const UnitClock& clock() const { return _clock; }
    UnitClock& clock() { return _clock; }
    DatagramLink& link() { return _link; }
    std::uint64_t repeats() const;
    /// Pause between repeats that don't wait for an answer: \a pause_s and a part of the round
    /// trip, so that there aren't many on a long path.
    double soon_s(double pause_s) const;

private:
    void take(const Endpoint& from, const std::vector<std::uint8_t>& bytes, double now_s);
    void takeReply(int k, const Answer& answer, double now_s);
    int find(const Endpoint& from) const;
    void note(Unit& unit, double now_s); ///< that something was sent to it
    void sendBeat(Unit& unit, double now_s);
    static bool isAnswered(const Unit& unit, std::uint16_t number);
    static bool isResting(const Unit& unit);
    static double beatTook_s(const Unit& unit, std::uint16_t number, double now_s);
    double beatDue_s(const Unit& unit) const;

    DatagramLink& _link;
    Refusals& _refusals;
    std::vector<Unit> _units;
    const Beats _beats;
    UnitClock _clock;
    bool _isPrompt = true;
    std::vector<Outcome> _outcomes;
    std::vector<FrameQueue::Done> _done;
    std::vector<std::uint8_t> _bytes;
    Other _other;
};

} // namespace midair::device::autd3
