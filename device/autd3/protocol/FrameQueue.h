#pragma once

#include "device/autd3/protocol/Messages.h"

#include <deque>
#include <functional>
#include <optional>
#include <vector>

namespace midair::device::autd3
{

/// Commands on their way to one unit: numbers, at most kWindow unanswered, and repeats until each
/// is acknowledged. Has no socket, no clock and no lock: the owner sends, tells the time, and hands
/// in answers. Times are base::steadySeconds().
class FrameQueue
{
public:
    static constexpr std::size_t kWindow = 7; ///< frames that a unit keeps
    static constexpr double kRepeat_s = 2e-3;
    /// Frames whose pause is kRepeat_s or longer wait longer where answers take long, up to this.
    static constexpr double kLongestRepeat_s = 30e-3;

    /// A command that was done, or refused.
    struct Done
    {
        std::uint8_t code = 0;              ///< of the command
        std::optional<std::uint8_t> result; ///< nullopt: its answer was lost, a later one came
        std::vector<std::uint8_t> data;     ///< of a read
        double took_s = -1; ///< until its own answer, at most; < 0: another's answer told of it
    };

    /// Sends a datagram; returns false if that isn't possible now.
    using Send = std::function<bool(const std::vector<std::uint8_t>&)>;

    /// Appends a command, which is sent \a copies times at once and repeated every \a repeat_s.
    void push(Command command, double repeat_s = kRepeat_s, int copies = 1);
    /// Drops commands that were not sent yet.
    void dropUnsent() { _waiting.clear(); }
    /// Drops those of them that write patterns; returns their number.
    int dropUnsentWrites();
    /// Forgets everything; the next number is 0, as after Reset. \a number: of the next message.
    void restart() { *this = FrameQueue(_message); }

    explicit FrameQueue(std::uint16_t firstMessage = 1) : _message(firstMessage) {}

    bool isIdle() const { return _flying.empty() && _waiting.empty(); }
    std::size_t unsent() const { return _waiting.size(); }
    std::size_t inFlight() const { return _flying.size(); }
    bool isInFlight(std::uint16_t number) const;
    /// Frames in flight count as sent first at \a now_s.
    void touch(double now_s);
    /// When the oldest frame in flight was sent first; \a otherwise if there is none.
    double oldest_s(double otherwise) const
    {
        return _flying.empty() ? otherwise : _flying.front().first_s;
    }

    /// Sends what is due; returns true if it sent anything.
    bool pump(double now_s, const Send& send);
    /// When pump() has something to do again without an answer; \a otherwise if never.
    double due_s(double otherwise) const;

    /// Takes an answer to message \a number at \a now_s. Returns false, and changes nothing, if no
    /// frame in flight has that number. Appends what it settles to \a done, in turn.
    bool take(const FrameReply& reply, std::uint16_t number, double now_s, std::vector<Done>& done);

    /// The number of a message other than a frame, from the same count.
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
    /// A frame that was sent and is not acknowledged.
    struct Flying
    {
        std::uint8_t code;
        std::uint8_t sequence;
        std::uint16_t number;
        std::vector<std::uint8_t> bytes;
        double repeat_s;
        double began_s; ///< when it was sent first
        double first_s; ///< the same, or later: touch()
        double sent_s;  ///< when it was sent last
        bool isCopied;  ///< it was sent more than once, so it may be answered so
    };

    bool repeat(double now_s, const Send& send);
    void noteAnswer(const Flying& frame, double now_s);

    std::deque<Waiting> _waiting;
    std::deque<Flying> _flying; ///< their sequence numbers follow each other
    std::uint8_t _sequence = 0;
    std::uint16_t _message;
    bool _isBehind = false; ///< the unit missed a frame: the window is sent again
    double _answer_s = 0;   ///< how long answers take: the longest of late, slowly forgotten
    int _inVain = 0;        ///< repeats since a frame that was sent once was answered
    std::uint64_t _repeats = 0;
};

} // namespace midair::device::autd3
