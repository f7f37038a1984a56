#pragma once

#include "device/ArrayDevice.h"
#include "device/JointCommit.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace midair::device
{

/// Fields of a device that wait for its line or are on it, and counters of all fields sent. At most
/// one waits, and a newer one replaces it; up to kMostFlying are in flight, that is handed to a
/// transfer and not confirmed yet.
///
/// Every field is counted once when it leaves the queue, so sent = played + dropped + lost +
/// refused + pending at any time. Has no lock: the owner guards it.
class FieldQueue
{
public:
    using Joint = std::shared_ptr<JointCommit>;
    static constexpr std::size_t kMostFlying = 8;

    /// A field in the queue.
    struct Field
    {
        Joint joint;            ///< null: none, or its commit was sent
        bool released = false;  ///< all devices in the joint have their part
        bool committed = false; ///< its commit was sent, with its data or later
        std::uint32_t sequence = 0;
        DriveSignal signal;
        double sentAt_s = 0;      ///< steady clock, at send()
        double submittedAt_s = 0; ///< steady clock, when its last transfer was submitted
        bool failed = false;      ///< its transfer failed
        bool repeated = false;    ///< second attempt to send it
    };

    // Incoming fields.

    void refuse();         ///< counts a refused field
    void dropBeforehand(); ///< counts a field whose joint was given up before it arrived
    /// Puts a field into the waiting slot. If \a joint is not null, returns the joint of the
    /// replaced field. A field without a joint takes over that of the replaced one: it is the same
    /// field, which GuardedDevice sends again with another gain.
    Joint put(const DriveSignal& signal, double sentAt_s, const Joint& joint);

    bool waits() const { return _waits; }
    bool isFull() const { return _flying.size() >= kMostFlying; }
    /// Returns true if the commit of the newest field in flight has not been sent yet; data of a
    /// newer field would make it incomplete.
    bool isStaged() const { return !_flying.empty() && !_flying.back().committed; }
    /// Returns true if that commit may be sent: all devices in its joint are ready.
    bool isCommitDue() const { return isStaged() && _flying.back().released; }
    std::uint64_t pending() const { return _flying.size() + (_waits ? 1 : 0); }

    /// Moves the waiting field into flight as number \a sequence.
    Field& takeOff(std::uint32_t sequence);
    Field& newest() { return _flying.back(); } ///< the newest field in flight
    /// Returns the joint of the staged field if its number is \a sequence, otherwise null.
    Joint stagedAs(std::uint32_t sequence) const;
    /// Call it when all devices in \a joint have their part: its commit is due. Returns false if no
    /// field of \a joint is staged here.
    bool releaseFor(const JointCommit& joint);
    /// Drops the field of \a joint; returns false if there is none.
    bool dropFor(const JointCommit& joint);

    // Outgoing fields.

    /// Settles all fields up to \a sequence, whose commit the device answered: counts field \a
    /// lastPlayed as played and the others as lost. Returns the signal of the played field if it
    /// was in flight.
    std::optional<DriveSignal> settleUntil(std::uint32_t sequence, std::uint32_t lastPlayed);
    /// Counts the oldest field as lost, and returns true, if the device has answered other packets
    /// at \a heardAt_s, more than \a confirm_s after the field was submitted, without confirming
    /// the field.
    bool loseUnconfirmed(double heardAt_s, double confirm_s);
    void fail(std::uint32_t sequence); ///< marks a field whose transfer failed
    /// Removes fields with failed transfers. The newest field waits again, once and without its
    /// joint, unless a newer one waits. Returns the joint that the device must leave, or null.
    Joint repeatFailed();
    void dropWaiting();
    void dropFlying(); ///< of a device that was told to play something else instead
    /// Counts the oldest field in flight as lost.
    void loseOldest();
    /// Drops the waiting field; counts fields in flight as lost if \a deviceIsLost, otherwise as
    /// dropped. Returns the joints of uncommitted fields.
    std::vector<Joint> settleAll(bool deviceIsLost);

    /// Time when the newest played field was sent; 0: none.
    double confirmed_s() const { return _confirmed_s; }

    /// Adds the counters sent, played, dropped, lost, refused and pending to \a report.
    void addTo(DeviceReport& report) const;

private:
    bool holdsBackFor(const JointCommit& joint) const;

    bool _waits = false;
    Field _waiting;
    std::deque<Field> _flying; ///< in flight; the last one may be staged
    double _confirmed_s = 0;
    std::uint64_t _sent = 0;
    std::uint64_t _played = 0;
    std::uint64_t _dropped = 0;
    std::uint64_t _lost = 0;
    std::uint64_t _refused = 0;
};

} // namespace midair::device
