#include "device/autd3/protocol/FrameQueue.h"

#include <algorithm>
#include <cmath>

namespace midair::device::autd3
{

namespace
{

// Answers to frames after a lost one arrive together: one repeat answers them all.
constexpr double kLeastRepeat_s = 0.3e-3;
constexpr double kPatience = 1.5;
constexpr double kForget = 0.05; // of the longest answer, per answer
constexpr int kMostDoublings = 4;

} // namespace

void FrameQueue::push(Command command, double repeat_s, int copies)
{
    _waiting.push_back({std::move(command), repeat_s, copies});
}

int FrameQueue::dropUnsentWrites()
{
    const std::size_t before = _waiting.size();
    _waiting.erase(std::remove_if(_waiting.begin(),
                                  _waiting.end(),
                                  [](const Waiting& one) { return one.command.writesPatterns(); }),
                   _waiting.end());
    return static_cast<int>(before - _waiting.size());
}

// A unit does nothing out of order, so the whole window follows its oldest frame.
bool FrameQueue::repeat(double now_s, const Send& send)
{
    for (Flying& frame : _flying)
    {
        if (!send(frame.bytes)) return false;
        frame.sent_s = now_s;
        frame.isCopied = true;
        ++_repeats;
    }
    // Short repeat intervals and out-of-order frames don't indicate slow answers.
    if (!_isBehind && !_flying.empty() && _flying.front().repeat_s >= kRepeat_s) ++_inVain;
    _isBehind = false;
    return true;
}

bool FrameQueue::pump(double now_s, const Send& send)
{
    bool sent = false;
    if (now_s >= due_s(now_s + 1) && !_flying.empty())
    {
        if (!repeat(now_s, send)) return sent;
        sent = true;
    }
    while (!_waiting.empty() && _flying.size() < kWindow)
    {
        const Waiting& next = _waiting.front();
        std::vector<std::uint8_t> bytes = frame(_message, _sequence, next.command);
        if (!send(bytes)) return sent;
        for (int i = 1; i < next.copies; ++i)
            send(bytes);
        _flying.push_back({next.command.code(),
                           _sequence++,
                           _message++,
                           std::move(bytes),
                           next.repeat_s,
                           now_s,
                           now_s,
                           now_s,
                           next.copies > 1});
        _waiting.pop_front();
        sent = true;
    }
    return sent;
}

double FrameQueue::due_s(double otherwise) const
{
    if (_flying.empty()) return otherwise;
    const Flying& oldest = _flying.front();
    if (_isBehind) return oldest.sent_s + std::min(kLeastRepeat_s, oldest.repeat_s);
    if (oldest.repeat_s < kRepeat_s) return oldest.sent_s + oldest.repeat_s;
    // Sending every frame twice would slow a slow path further: as in TCP (RFC 6298), the pause
    // exceeds the answer time, and doubles while nothing arrives.
    const double pause_s = std::ldexp(std::max(oldest.repeat_s, kPatience * _answer_s),
                                      std::min(_inVain, kMostDoublings));
    return oldest.sent_s + std::min(pause_s, kLongestRepeat_s);
}

// It is unknown which copy of a repeated frame is answered: the longer pause stays until a frame
// that was sent once is answered (RFC 6298, Karn); otherwise the answer time could never be
// measured.
void FrameQueue::noteAnswer(const Flying& frame, double now_s)
{
    if (frame.isCopied) return;
    _inVain = 0;
    const double took_s = now_s - frame.sent_s;
    _answer_s = std::max(took_s, _answer_s + kForget * (took_s - _answer_s));
}

bool FrameQueue::isInFlight(std::uint16_t number) const
{
    return std::any_of(_flying.begin(),
                       _flying.end(),
                       [&](const Flying& frame) { return frame.number == number; });
}

void FrameQueue::touch(double now_s)
{
    for (Flying& frame : _flying)
        frame.first_s = now_s;
}

bool FrameQueue::take(const FrameReply& reply,
                      std::uint16_t number,
                      double now_s,
                      std::vector<Done>& done)
{
    const auto asked = std::find_if(
        _flying.begin(), _flying.end(), [&](const Flying& f) { return f.number == number; });
    if (asked == _flying.end()) return false;
    const std::uint8_t askedFor = asked->sequence;
    const double took_s = now_s - asked->began_s;
    // Number of frames in flight that are done: an answer may be older than others that arrived
    // before.
    const auto count = static_cast<std::uint8_t>(reply.acknowledged - _flying.front().sequence + 1);
    if (count > 0 && count <= _flying.size())
    {
        // The data belongs to the acknowledged frame, whichever was asked.
        for (int i = 0; i < count; ++i)
        {
            Done one;
            one.code = _flying.front().code;
            if (i + 1 == count)
            {
                one.result = reply.result;
                one.data = reply.data;
            }
            if (_flying.front().sequence == askedFor) one.took_s = took_s;
            done.push_back(std::move(one));
            noteAnswer(_flying.front(), now_s);
            _flying.pop_front();
        }
    }
    // Not an answer to a copy of a finished frame.
    if (static_cast<std::int8_t>(askedFor - reply.acknowledged) > 0) _isBehind = true;
    if (_flying.empty()) _isBehind = false;
    return true;
}

} // namespace midair::device::autd3
