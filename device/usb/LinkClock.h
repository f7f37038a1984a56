#pragma once

#include "device/usb/Protocol.h"

#include <algorithm>

namespace midair::device
{

/// Tells when something is due on a link: a keep-alive for the device's watchdog, a status query,
/// and giving up when the device doesn't answer. Times are those of base::steadySeconds().
class LinkClock
{
public:
    static constexpr double kStatusInterval_s = 0.25;
    static constexpr double kSilentDevice_s = 1.0; ///< without a valid answer the link is given up

    void start(double now_s)
    {
        _heard_s = _asked_s = _submitted_s = now_s;
        _questions = 0;
    }
    void onSubmit(double now_s) { _submitted_s = now_s; }
    void onQuestion(double now_s)
    {
        _asked_s = now_s;
        ++_questions;
    }
    void onAnswer(double now_s)
    {
        _heard_s = now_s;
        _questions = 0;
    }

    double heard_s() const { return _heard_s; }
    /// Returns true if no answer came for kSilentDevice_s in spite of several queries: a host that
    /// was stopped for a while hasn't received anything either.
    bool isDeviceSilent(double now_s) const
    {
        return now_s - _heard_s > kSilentDevice_s && _questions >= kMostQuestions;
    }
    bool isQuestionDue(double now_s) const { return now_s - _asked_s >= kStatusInterval_s; }
    bool isKeepAliveDue(double now_s) const
    {
        return now_s - _submitted_s >= protocol::kKeepAliveInterval_s;
    }
    double nextDue_s() const
    {
        return std::min(_submitted_s + protocol::kKeepAliveInterval_s,
                        _asked_s + kStatusInterval_s);
    }

private:
    static constexpr int kMostQuestions = 3;

    double _submitted_s = 0;
    double _asked_s = 0;
    double _heard_s = 0;
    int _questions = 0; ///< since the last answer
};

/// A MUTE that is repeated every kRetry_s until the device has answered it.
class PendingMute
{
public:
    static constexpr double kRetry_s = 0.02;

    /// Somebody wants a mute, at \a now_s; \a sequence is its number.
    void ask(std::uint32_t sequence, double now_s = 0)
    {
        _awaited = sequence;
        _asked_s = now_s;
    }
    void forget() { _awaited = 0; }
    void onSent(double now_s)
    {
        _sent = _awaited;
        _sent_s = now_s;
    }
    void onAnswer(std::uint32_t sequence)
    {
        if (!isAwaited() || sequence == 0 || protocol::newer(_awaited, sequence)) return;
        forget();
        _confirmed_s = _asked_s;
    }

    bool isAwaited() const { return _awaited != 0; }
    bool awaits(std::uint32_t sequence) const { return isAwaited() && _awaited == sequence; }
    std::uint32_t sequence() const { return _awaited; }
    bool isDue(double now_s) const
    {
        return isAwaited() && (_sent != _awaited || now_s - _sent_s >= kRetry_s);
    }
    double nextDue_s() const { return _sent_s + kRetry_s; }
    /// When that was asked for which the device confirmed last; 0: none.
    double confirmed_s() const { return _confirmed_s; }

private:
    std::uint32_t _awaited = 0; ///< sequence number of the MUTE not yet answered; 0: none
    std::uint32_t _sent = 0;    ///< sequence number of the last one sent
    double _sent_s = 0;
    double _asked_s = 0; ///< last
    double _confirmed_s = 0;
};

} // namespace midair::device
