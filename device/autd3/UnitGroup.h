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

/// The units' common time as the host knows it: from the time stamps of answers, which are as old
/// as their way back was long.
///
/// The least delayed one of the last second or so counts; so the estimate is behind the units' time
/// by that delay. What is to be there in time has to be aimed a round trip later: that delay, and
/// the way there.
class UnitClock
{
public:
    static constexpr double kWindow_s = 0.5; ///< two of these are kept
    /// A time stamp that is further ahead is not believed, ns, until kLeastAlike in a row say so.
    static constexpr double kMostAhead_ns = 0.2e9;
    static constexpr int kLeastAlike = 5;

    void reset() { *this = {}; }

    /// \a took_s: from the question to this answer, at most; < 0: not known.
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
    /// The shortest round trip of late; 0 until one is known.
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
    static constexpr double kLongest_s = 0.1; ///< longer ones are none: a unit is lost by then

    double _now_ns = kNone; ///< the largest of unit's less host's time, in this window
    double _before_ns = kNone;
    double _began_s = 0;
    double _trip_s = kLongest_s; ///< the shortest, in this window
    double _tripBefore_s = kLongest_s;
    int _ahead = 0; ///< time stamps in a row that were
    bool _known = false;
};

/// Why a datagram is not taken.
enum class Refusal : std::uint8_t
{
    MALFORMED,      ///< no answer of the protocol
    FOREIGN,        ///< from an address that no unit of ours has
    STRAY,          ///< answers nothing that was asked, or a second time
    WRONG_ID,       ///< from a unit's address, with another id or no result
    OTHER_PROTOCOL, ///< of another version
    COUNT
};

/// Counts datagrams that are not taken, and logs each kind at most every kLog_s.
///
/// Copies and late answers are how a network is: of strays only the number is kept.
class Refusals
{
public:
    static constexpr double kLog_s = 10;

    explicit Refusals(std::string device) : _device(std::move(device)) {}

    void add(Refusal refusal, const std::string& what, double now_s);
    std::uint64_t count(Refusal refusal) const { return _entries[index(refusal)].count; }
    std::uint64_t total() const; ///< without strays
    /// "2 malformed, 1 foreign"; empty: none but strays.
    std::string text() const;

private:
    /// What one kind has come to.
    struct Entry
    {
        std::uint64_t count = 0;
        std::uint64_t logged = 0; ///< count when it was logged last
        double logged_s = 0;
    };
    static std::size_t index(Refusal refusal) { return static_cast<std::size_t>(refusal); }

    std::string _device;
    std::array<Entry, static_cast<std::size_t>(Refusal::COUNT)> _entries{};
};

/// A unit that was given its id, and what is known about it.
struct Unit
{
    Endpoint at;
    std::uint8_t id = kNoId; ///< its place along the cable, from 0
    std::uint8_t flags = 0;
    FrameQueue queue;
    std::string lost; ///< why nothing is sent to it any more; empty: it is there

    bool isLossTold = false;
    std::string suspicion;        ///< what is wrong with its last answer; empty: nothing
    double heard_s = 0;           ///< when it answered last
    double sent_s = 0;            ///< when it was last sent a frame or a heartbeat
    double pushed_s = 0;          ///< when it last got a command
    double asked_s = 0;           ///< when it was asked first since it answered last
    int asked = 0;                ///< times that it was asked since then
    std::uint16_t beat = 0;       ///< message number of the last heartbeat
    std::uint16_t unanswered = 0; ///< of the first one whose answer may still come, or the next
    bool isBeatOpen = false;      ///< none was answered since the last was sent
    std::array<double, 32>
        beats_s{};          ///< when the last ones were sent, by number modulo their count
    double outOfStep_s = 0; ///< since when it doesn't follow the clock; 0: it does

    bool isThere() const { return lost.empty(); }
};

/// The traffic with units that are open: frames, heartbeats, answers, and which unit is lost.
///
/// Used by one thread at a time.
class UnitGroup
{
public:
    static constexpr double kLost_s = 0.1; ///< without an answer
    static constexpr int kLeastAsked = 3;  ///< times, before a unit is lost
    static constexpr double kResting_s = 0.1;
    static constexpr double kNever_s = std::numeric_limits<double>::max();

    /// What became of a command to unit \a unit.
    struct Outcome
    {
        int unit = 0;
        FrameQueue::Done done;
        std::uint64_t time_ns = 0; ///< of the unit, when it answered
    };
    /// Gets answers of kinds other than frames and heartbeats.
    using Other = std::function<void(const Endpoint&, const Answer&)>;

    /// How often units hear from us while nothing else is sent, s.
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
    int count() const; ///< of units that are there

    void
    push(int k, const Command& command, double repeat_s = FrameQueue::kRepeat_s, int copies = 1);

    /// Sends what is due: frames, repeats, and heartbeats to those that nothing else is sent to.
    void pump(double now_s);
    /// When pump() has something to do without an answer.
    double due_s() const;
    /// Waits for an answer, as DatagramLink::receive() does, and takes all that are there. Not
    /// \a isPrompt: they may have waited, so that the clock learns nothing from them.
    void receive(double until_s, bool isPrompt = true);
    /// Returns true if no frame waits for anything.
    bool isIdle() const;
    /// Returns true if no unit has got a command for kResting_s, but to tell its state.
    bool isResting() const;
    /// Marks units as lost that are silent, don't go on, or have rebooted; returns true if there is
    /// a new one. To be called after receive().
    bool findLost(double now_s);
    void lose(int k, const std::string& why);
    /// Gives all units a new chance to answer: this program didn't run for a while.
    void forgive(double now_s);

    /// Moves out what was settled since the last call, in turn for each unit.
    std::vector<Outcome> takeOutcomes() { return std::exchange(_outcomes, {}); }
    void onOther(Other other) { _other = std::move(other); }

    const UnitClock& clock() const { return _clock; }
    UnitClock& clock() { return _clock; }
    DatagramLink& link() { return _link; }
    std::uint64_t repeats() const;
    /// A pause between repeats that don't wait for an answer, but aren't many where the way is
    /// long: \a pause_s and a part of the round trip.
    double soon_s(double pause_s) const;

private:
    void take(const Endpoint& from, const std::vector<std::uint8_t>& bytes, double now_s);
    void takeReply(int k, const Answer& answer, double now_s);
    int find(const Endpoint& from) const;
    void note(Unit& unit, double now_s); ///< that it is sent something
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
