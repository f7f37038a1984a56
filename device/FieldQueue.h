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

/// The fields that wait for a transfer or are on their way, and what became of all that were sent.
/// One waits, where a newer one replaces it; up to kMostFlying are on their way.
///
/// Every field that comes in is counted once when it leaves, so that sent = played + dropped + lost
/// + refused + pending at any time. No lock in here: who has the queue guards it.
class FieldQueue
{
public:
    using Joint = std::shared_ptr<JointCommit>;
    static constexpr std::size_t kMostFlying = 8;

    struct Field
    {
        Joint joint;            ///< null: none, or its commit is out
        bool released = false;  ///< waits for nobody in it any more
        bool committed = false; ///< its commit went out, with its data or after
        std::uint32_t sequence = 0;
        DriveSignal signal;
        double sentAt_s = 0;
        double submittedAt_s = 0;
        bool failed = false;   ///< its transfer ended badly
        bool repeated = false; ///< it is on its way for the second time
    };

    // What comes in.

    void refuse();         ///< a field that isn't taken
    void dropBeforehand(); ///< a field whose joint was given up before it came
    /// Puts a field where it waits; gives the joint of one that it overtakes. A field without a
    /// joint takes the place in the joint of the one that it overtakes: it is the same field, which
    /// a guard sends again with another gain.
    Joint put(const DriveSignal& signal, double sentAt_s, const Joint& joint);

    bool waits() const { return _waits; }
    bool isFull() const { return _flying.size() >= kMostFlying; }
    /// Whether the last one on its way has its commit still to come; a newer one's data would make
    /// that incomplete.
    bool isStaged() const { return !_flying.empty() && !_flying.back().committed; }
    /// Whether that commit waits for nobody in its joint.
    bool isCommitDue() const { return isStaged() && _flying.back().released; }
    std::uint64_t pending() const { return _flying.size() + (_waits ? 1 : 0); }

    /// The one that waits goes on its way.
    Field& takeOff(std::uint32_t sequence);
    Field& newest() { return _flying.back(); } ///< of those on their way
    /// The joint of the one that is staged, if that is \a sequence.
    Joint stagedAs(std::uint32_t sequence) const;
    /// All in \a joint have their piece; false when none of it is staged here.
    bool releaseFor(const JointCommit& joint);
    /// Drops what belongs to \a joint; false where nothing does.
    bool dropFor(const JointCommit& joint);

    // What becomes of those on their way.

    /// The device answered the commit of \a sequence, and with it all before; of those it played \a
    /// lastPlayed. Gives that field.
    std::optional<DriveSignal> settleUntil(std::uint32_t sequence, std::uint32_t lastPlayed);
    /// Loses the oldest when the device has been heard \a confirm_s after it went out without a
    /// word about it.
    bool loseUnconfirmed(double heardAt_s, double confirm_s);
    void fail(std::uint32_t sequence); ///< its transfer ended badly
    /// Of those whose transfers failed the newest waits again, once, for nobody else, unless a
    /// newer one waits. Gives the joint to be left.
    Joint repeatFailed();
    void dropWaiting();
    /// The oldest on its way never reached the device.
    void loseOldest();
    /// What waits is dropped; what is on its way is lost where the device is, else dropped. Gives
    /// the joints that were waited for.
    std::vector<Joint> settleAll(bool deviceIsLost);

    /// Fills in sent, played, dropped, lost, refused and pending.
    void addTo(DeviceReport& report) const;

private:
    bool holdsBackFor(const JointCommit& joint) const;

    bool _waits = false;
    Field _waiting;
    std::deque<Field>
        _flying; ///< submitted, not yet confirmed; the last one perhaps without its commit
    std::uint64_t _sent = 0;
    std::uint64_t _played = 0;
    std::uint64_t _dropped = 0;
    std::uint64_t _lost = 0;
    std::uint64_t _refused = 0;
};

} // namespace midair::device
