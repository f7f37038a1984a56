#pragma once

#include <algorithm>
#include <limits>

namespace midair::bridge
{

/// When a driver's silence() is to be called: as soon as it is wanted, again and again while it
/// fails, and seldom while the driver is lost. Has no lock: the owner guards it. All times are
/// those of steadySeconds().
class DueSilence
{
public:
    static constexpr double kSoon_s = 0.1; ///< pause after a failure
    /// The pause from failure kSoonTries on, and while the driver is lost.
    static constexpr double kLater_s = 1.0;
    static constexpr int kSoonTries = 10;
    static constexpr int kLastTries = 5; ///< failures after which a driver is closed all the same

    void want() { _isWanted = true; }
    /// The next one waits for no pause, as the driver was just lost, is back or is closed.
    void wantNow()
    {
        _isWanted = true;
        _from_s = 0.0;
        _failures = 0;
    }

    bool isWanted() const { return _isWanted; }
    bool isDue(double now_s) const { return _isWanted && now_s >= _from_s; }
    /// Time until it is due, >= 0; infinite if none is wanted.
    double rest_s(double now_s) const
    {
        return _isWanted ? std::max(0.0, _from_s - now_s) : std::numeric_limits<double>::infinity();
    }
    bool isGivenUp() const { return _failures >= kLastTries; } ///< for a driver that is closed

    /// To be called before silence(), so that one that is wanted meanwhile is another one.
    void begin() { _isWanted = false; }
    /// silence() has returned. \a isSeldom: the driver is lost, and the next one has time.
    void succeed(double now_s, bool isSeldom)
    {
        _failures = 0;
        _from_s = isSeldom ? now_s + kLater_s : 0.0;
    }
    /// silence() has thrown: it is wanted again.
    void fail(double now_s, bool isSeldom)
    {
        _isWanted = true;
        _from_s = now_s + (isSeldom || ++_failures >= kSoonTries ? kLater_s : kSoon_s);
    }

private:
    bool _isWanted = false;
    double _from_s = 0.0; ///< not before
    int _failures = 0;    ///< in a row, while the driver isn't lost
};

} // namespace midair::bridge
