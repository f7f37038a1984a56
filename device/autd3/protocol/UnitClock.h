#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

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

} // namespace midair::device::autd3
