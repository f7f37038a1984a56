#pragma once

#include "engine-bridge/hands/osc/OscHands.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// What came of the datagrams so far.
struct OscCounts
{
    std::uint64_t datagrams = 0;
    std::uint64_t hands = 0;     ///< that were taken
    std::uint64_t heads = 0;     ///< that were taken
    std::uint64_t malformed = 0; ///< datagrams that are not understood
    std::uint64_t late = 0;      ///< hands and heads older than, or as old as, one that is known
    std::uint64_t ofOthers = 0;  ///< hands and heads of a sender that another was before
    std::uint64_t unknown = 0;   ///< messages with another address
    std::uint64_t jointsLeftOut = 0; ///< that are called valid and can't be
};

/// The newest hands and head of a stream of datagrams, whoever receives these. What is hostile or
/// wrong is counted and ignored, and told once of each kind. All members may be called from any
/// thread.
class OscInbox
{
public:
    /// A hand, or the head, of which nothing has come for so long is lost.
    static constexpr double kLost_s = 0.1;

    /// \a name begins each message: "osc: port 9000".
    explicit OscInbox(std::string name) : _name(std::move(name)) { requireOsc(); }

    /// Takes a datagram that came at \a now_s (steady clock) from \a sender, any bytes that tell
    /// senders apart. As long as a side's hand isn't lost, it is that of the sender that had it
    /// first, and each must be newer than the one before.
    void take(const char* data, std::size_t size, const std::string& sender, double now_s);

    /// True if \a sender may give a hand at \a now_s, or the head where that is asked for: if not,
    /// its datagrams need not be read.
    bool mayBeOf(const std::string& sender, double now_s) const;
    /// Counts a datagram that was not read, as it is of another sender.
    void passOver();

    /// Puts the hands that are not lost at \a now_s into \a frame, with their age; returns false
    /// if there are none.
    bool latest(double now_s, HandFrame& frame) const;

    /// Puts the head, if it isn't lost at \a now_s, into \a head, with its age; returns false if it
    /// is. From now on datagrams are read for it.
    bool latestHead(double now_s, Head& head) const;

    /// Adds a message.
    void say(const std::string& message);
    /// The messages from number \a told on; sets \a told to the number of all messages.
    std::vector<std::string> messages(std::size_t& told) const;

    OscCounts counts() const;
    /// "1200 hands; ignored: 3 datagrams that are no hands, .."
    std::string status() const;

private:
    /// The newest of what one sender has at a time: a side's hand, the head.
    template<typename T>
    struct Newest
    {
        T what;
        double time_s = 0.0;     ///< the sender's clock; NaN: not told
        double arrived_s = -1e9; ///< steady clock
        std::string sender;

        bool isLost(double now_s) const { return !(now_s - arrived_s < kLost_s); }
    };

    template<typename T>
    bool take(Newest<T>& newest, const Newest<T>& next, const std::string& name)
        MIDAIR_REQUIRES(_mutex);
    void tellOnce(const char* what, const std::string& message);

    const std::string _name;
    mutable base::Mutex _mutex;
    std::array<Newest<Hand>, 2> _sides MIDAIR_GUARDED_BY(_mutex);
    Newest<Head> _head MIDAIR_GUARDED_BY(_mutex);
    mutable bool _isHeadAsked MIDAIR_GUARDED_BY(_mutex) = false;
    OscCounts _counts MIDAIR_GUARDED_BY(_mutex);
    base::MessageLog _messages;
};

} // namespace midair::bridge
