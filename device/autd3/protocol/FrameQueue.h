#pragma once

#include "device/autd3/protocol/Messages.h"

#include <deque>
#include <functional>
#include <optional>
#include <vector>

namespace midair::device::autd3
{

/// Commands in transit to one unit: numbers, at most kWindow unanswered, and repeats until each is
/// acknowledged. Has no socket, clock or lock: the owner sends, passes the time, and hands in
/// answers. Times are base::steadySeconds().
class FrameQueue
{
public:
    static constexpr std::size_t kWindow = 7; ///< frames that a unit can queue
    static constexpr double kRepeat_s = 2e-3;
    /// Longest repeat interval of frames with a pause of at least kRepeat_s, for slow answers.
    static constexpr double kLongestRepeat_s = 30e-3;

    /// A command that was done or refused.
    struct Done
    {
        std::uint8_t code = 0;              ///< of the command
        std::optional<std::uint8_t> result; ///< nullopt: its answer was lost and a later one came
        std::vector<std::uint8_t> data;     ///< of a read
        double took_s = -1; ///< upper bound of its answer time; < 0: known only from another answer
    };

    /// Sends a datagram; returns false if not possible now.
    using Send = std::function<bool(const std::vector<std::uint8_t>&)>;

    /// Appends a command, which is sent \a copies times at once and repeated every \a repeat_s.
    void push(Command command, double repeat_s = kRepeat_s, int copies = 1);
    /// Drops unsent commands.
    void dropUnsent() { _waiting.clear(); }
    /// Drops unsent commands that write patterns; returns their number.
    int dropUnsentWrites();
    /// Resets the queue; the next number is 0, as after Reset. \a number: of the next message.
    void restart() { *this = FrameQueue(_message); }

    explicit FrameQueue(std::uint16_t firstMessage = 1) : _message(firstMessage) {}

    bool isIdle() const { return _flying.empty() && _waiting.empty(); }
    std::size_t unsent() const { return _waiting.size(); }
    std::size_t inFlight() const { return _flying.size(); }
    bool isInFlight(std::uint16_t number) const;
    /// Treats frames in flight as first sent at \a now_s.
    void touch(double now_s);
    /// Returns when the oldest frame in flight was first sent; \a otherwise if none.
    double oldest_s(double otherwise) const
    {
        return _flying.empty() ? otherwise : _flying.front().first_s;
    }

    /// Sends what is due; returns true if it sent anything.
    bool pump(double now_s, const Send& send);
    /// Returns when pump() is due again without an answer; \a otherwise if never.
    double due_s(double otherwise) const;

    /// Processes an answer to message \a number at \a now_s. Returns false, and changes nothing, if
    /// no frame in flight has that number. Appends settled commands to \a done, in order.
    bool take(const FrameReply& reply, std::uint16_t number, double now_s, std::vector<Done>& done);

    /// Returns the number for a message other than a frame, from the same counter.
    std::uint16_t nextMessage() { return _message++; }
    std::uint64_t repeats() const { return _repeats; }

private:
    /// A command that waits to be sent.
    struct Waiting
    {
        Command command;
        double repeat_s;
        int copies;
    };
    /// A sent frame without acknowledgement.
    struct Flying
    {
        std::uint8_t code;
        std::uint8_t sequence;
        std::uint16_t number;
        std::vector<std::uint8_t> bytes;
        double repeat_s;
        double began_s; ///< when it was sent first
        double first_s; ///< the same, or later after touch()
        double sent_s;  ///< when it was sent last
        bool isCopied;  ///< sent more than once, so answers may repeat, too
    };

    bool repeat(double now_s, const Send& send);
    void noteAnswer(const Flying& frame, double now_s);

    std::deque<Waiting> _waiting;
    std::deque<Flying> _flying; ///< with consecutive sequence numbers
    std::uint8_t _sequence = 0;
    std::uint16_t _message;
    bool _isBehind = false; ///< the unit missed a frame: the window is resent
    double _answer_s = 0;   ///< answer time: the longest recent one, slowly forgotten
    int _inVain = 0;        ///< repeats since the last answer to a frame that was sent once
    std::uint64_t _repeats = 0;
};

} // namespace midair::device::autd3
