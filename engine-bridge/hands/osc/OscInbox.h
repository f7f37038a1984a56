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

/// Counts of the datagrams so far.
struct OscCounts
{
    std::uint64_t datagrams = 0;
    std::uint64_t hands = 0;         ///< accepted
    std::uint64_t heads = 0;         ///< accepted
    std::uint64_t malformed = 0;     ///< invalid datagrams
    std::uint64_t late = 0;          ///< hands and heads not newer than the known one
    std::uint64_t ofOthers = 0;      ///< hands and heads of a second sender
    std::uint64_t unknown = 0;       ///< messages to another address
    std::uint64_t jointsLeftOut = 0; ///< marked as valid but impossible
};

/// The newest hands and head of a stream of datagrams, from any receiver. Hostile or invalid data
/// is counted, ignored, and reported once per kind. All members may be called from any thread.
class OscInbox
{
public:
    /// A hand or head without data for this time is lost.
    static constexpr double kLost_s = 0.1;

    /// \a name is the prefix of each message: "osc: port 9000".
    explicit OscInbox(std::string name) : _name(std::move(name)) { requireOsc(); }

    /// Takes a datagram that arrived at \a now_s (steady clock) from \a sender, any bytes that
    /// identify a sender. Until a side's hand is lost, only its first sender is accepted, and each
    /// must be newer than the last.
    void take(const char* data, std::size_t size, const std::string& sender, double now_s);

    /// True if \a sender may provide a hand at \a now_s, or the head if that is requested;
    /// otherwise its datagrams need not be read.
    bool mayBeOf(const std::string& sender, double now_s) const;
    /// Counts a datagram of another sender that was not read.
    void passOver();

    /// Stores the hands that are not lost at \a now_s in \a frame, with their age; returns false if
    /// there are none.
    bool latest(double now_s, HandFrame& frame) const;

    /// Stores the head, with its age, in \a head; returns false if it is lost at \a now_s. From now
    /// on datagrams are read for it.
    bool latestHead(double now_s, Head& head) const;

    /// Adds a message.
    void say(const std::string& message);
    /// Returns the messages from number \a told on; sets \a told to the number of all messages.
    std::vector<std::string> messages(std::size_t& told) const;

    OscCounts counts() const;
    /// "1200 hands; ignored: 3 invalid datagrams, .."
    std::string status() const;

private:
    /// The newest item of a side's hand or of the head, from one sender at a time.
    template<typename T>
    struct Newest
    {
        T what;
        double time_s = 0.0;     ///< the sender's clock; NaN: missing
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
