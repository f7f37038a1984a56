#pragma once

namespace midair::samples
{

/// Watches whether a client still answers pings. Times are those of the steady clock, s.
class PingWatch
{
public:
    static constexpr double kPing_s = 0.5; ///< interval of pings
    static constexpr double kLost_s = 2.0; ///< without an answer the client is lost

    /// Begins with a client that has just been heard.
    void begin(double now_s) { _heard_s = _looked_s = _pinged_s = now_s; }
    void hear(double now_s) { _heard_s = now_s; }

    /// Returns true if the client is lost. A time in which nobody looked isn't counted, as its
    /// answers couldn't be heard.
    bool isLost(double now_s)
    {
        const double unseen_s = now_s - _looked_s;
        if (unseen_s > kPing_s) _heard_s += unseen_s;
        _looked_s = now_s;
        return now_s - _heard_s > kLost_s;
    }
    /// Returns true if a ping is due, and counts it.
    bool takePing(double now_s)
    {
        if (now_s - _pinged_s < kPing_s) return false;
        _pinged_s = now_s;
        return true;
    }

private:
    double _heard_s = 0.0;
    double _looked_s = 0.0;
    double _pinged_s = 0.0;
};

} // namespace midair::samples
