#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace midair::device
{

/// The line to a board: when its last byte leaves it, and what of all that was asked for has left
/// the computer. Has no lock: the owner guards it. Times are base::steadySeconds().
class BoardLine
{
public:
    /// When the last byte has left the line.
    double free_s() const { return _free_s; }

    /// \a bytes, which take the line \a onLine_s, were written at \a now_s. \a isAhead: behind what
    /// is still on the line; else the line was free.
    void noteBytes(std::size_t bytes, double now_s, double onLine_s, bool isAhead)
    {
        _written += bytes;
        _free_s = (isAhead ? std::max(now_s, _free_s) : now_s) + onLine_s;
    }
    /// The bytes so far are what was asked for at \a asked_s.
    void noteAsked(double asked_s) { _onItsWay.push_back({asked_s, _written}); }
    /// The same of what keeps the line busy, or takes it for longer than a field: it counts as
    /// sent.
    void noteSent(double asked_s) { _confirmed_s = std::max(_confirmed_s, asked_s); }
    /// What is on its way doesn't arrive: it was discarded, or the board is lost.
    void forget() { _onItsWay.clear(); }
    bool isAnyOnItsWay() const { return !_onItsWay.empty(); }

    /// When that was asked for which has left last.
    double confirmed_s() const { return _confirmed_s; }
    /// The computer has \a unsent bytes left.
    void noteUnsent(std::uint64_t unsent)
    {
        const std::uint64_t gone = _written - std::min(_written, unsent);
        for (; !_onItsWay.empty() && _onItsWay.front().end <= gone; _onItsWay.pop_front())
            noteSent(_onItsWay.front().asked_s);
    }

private:
    /// What was written, until it has left the computer: when it was asked for, and its last byte.
    struct OnItsWay
    {
        double asked_s = 0;
        std::uint64_t end = 0;
    };
    std::deque<OnItsWay> _onItsWay;
    std::uint64_t _written = 0; ///< bytes
    double _confirmed_s = 0;
    double _free_s = 0;
};

} // namespace midair::device
