#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/JointCommit.h"
#include "device/usb/Protocol.h"
#include "device/usb/UsbTransferPool.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// Times the periodic actions of a link: keep-alives for the device's watchdog, status queries, and
/// giving up if the device doesn't answer. Times are base::steadySeconds().
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
    /// Returns true if no answer came for kSilentDevice_s despite several queries: a host that was
    /// suspended hasn't received anything either.
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

    /// Requests a mute at \a now_s; \a sequence is its number.
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
    /// Request time of the last confirmed mute; 0: none.
    double confirmed_s() const { return _confirmed_s; }

private:
    std::uint32_t _awaited = 0; ///< sequence number of the unanswered MUTE; 0: none
    std::uint32_t _sent = 0;    ///< sequence number of the last one sent
    double _sent_s = 0;
    double _asked_s = 0; ///< last
    double _confirmed_s = 0;
};

/// A connection to a plugged-in array, opened and greeted: it speaks osgMidair's protocol and
/// matches the layout.
class UsbLink : private UsbTransferPool::Listener
{
public:
    using Outcome = UsbTransferPool::Outcome;

    /// Receives the link's events, on the pool's event thread, with no lock held, from the greeting
    /// on.
    class Owner
    {
    public:
        virtual ~Owner() = default;
        /// The transfer of send() with \a token ended; 0: a packet other than a field.
        virtual void onSent(std::uint64_t token, Outcome outcome) = 0;
        virtual void onAnswer(const protocol::Packet& packet) = 0;
        /// No more answers until clearHalt().
        virtual void onReceiveFailed(Outcome outcome) = 0;
        /// Received bytes that are no packet; \a first: for the first time on this link.
        virtual void onNonsense(bool first) = 0;
    };

    /// Throws DeviceError as UsbTransferPool does, and if the array doesn't answer or has another
    /// protocol version, number of transducers or number of boards.
    UsbLink(const UsbAddress& address, const DeviceLayout& layout, Owner& owner);

    // Any thread may call these; those that send return false if no transfer is free or the array
    // is gone.

    bool hasFree() const { return _pool->hasFree(); }
    bool send(std::uint64_t token, const std::vector<std::uint8_t>& bytes)
    {
        return _pool->send(token, bytes);
    }
    bool send(protocol::Type type);       ///< sends a packet without payload
    bool mute(std::uint32_t sequence);    ///< uses the control endpoint, so it overtakes fields
    bool identify(int board, bool light); ///< uses the control endpoint; -1: all boards
    void cancelSends() { _pool->cancelSends(); }
    /// Clears a stall; returns false if that fails. Must not be called on the event thread.
    bool clearHalt() { return _pool->clearHalt(); }

    const std::string& name() const { return _pool->name(); }
    /// Not written after the greeting.
    const protocol::Info& info() const MIDAIR_NO_THREAD_ANALYSIS { return _info.info; }

private:
    void greet();
    /// Reads _info without the lock: it is not written after the greeting.
    void check(const DeviceLayout& layout) const MIDAIR_NO_THREAD_ANALYSIS;

    void onSent(std::uint64_t token, Outcome outcome) override;
    void onReceived(const std::uint8_t* bytes, std::size_t count) override;
    void onReceiveFailed(Outcome outcome) override;
    void noteFault(Outcome outcome);

    Owner& _owner;
    const std::uint32_t _nonce;     ///< sent in HELLO; the answering INFO has the same
    protocol::StreamParser _parser; ///< used by the event thread only
    std::uint32_t _nonsense = 0;    ///< bad packets reported; used by the event thread only
    base::Mutex _mutex;
    base::Condition _heard;
    bool _greeted MIDAIR_GUARDED_BY(_mutex) = false;
    Outcome _fault MIDAIR_GUARDED_BY(_mutex) = Outcome::DONE;
    protocol::Packet _info MIDAIR_GUARDED_BY(_mutex);
    std::unique_ptr<UsbTransferPool> _pool; ///< last, because its thread uses all other members
};

/// Traffic with an array on USB: fields, mutes, keep-alives, answers and faults, over a UsbLink
/// while one is attached; without one, fields are refused. The owner opens the link, and its thread
/// calls work().
class UsbConnection : public UsbLink::Owner, private JointCommit::Device
{
public:
    using Joint = FieldQueue::Joint;

    enum class State
    {
        AWAY,
        GREETING, ///< a link is being opened
        READY,    ///< takes fields, also while it recovers from a fault
        CLOSING   ///< refuses fields; final
    };

    UsbConnection(const DeviceLayout& layout, const std::string& name);
    ~UsbConnection() override;

    UsbConnection(const UsbConnection&) = delete;
    UsbConnection& operator=(const UsbConnection&) = delete;

    // Any thread may call these.

    /// See UsbArrayDevice.
    bool send(const DriveSignal& signal, const Joint& joint) MIDAIR_EXCLUDES(_mutex);
    /// Turns the array off at once and drops all fields; work() repeats the MUTE until the device
    /// confirms it.
    void mute() MIDAIR_EXCLUDES(_mutex);
    bool identify(int board, bool light) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        return _link != nullptr && _link->identify(board, light);
    }
    FieldCounters& counters() { return _counters; }  ///< all except those of fields
    std::string name() const MIDAIR_EXCLUDES(_mutex) ///< of the last link
    {
        const base::Lock lock(_mutex);
        return _name;
    }
    DeviceReport report() const MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        DeviceReport report = _counters.report();
        _queue.addTo(report);
        return report;
    }
    /// The last protocol::StatusFlags that the device sent.
    std::uint16_t flags() const MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        return _session.flags;
    }
    std::vector<std::complex<float>> played() const { return _playing.activations(); }
    double confirmed_s() const MIDAIR_EXCLUDES(_mutex) ///< from its answers, see ArrayDevice
    {
        const base::Lock lock(_mutex);
        return std::max(_queue.confirmed_s(), _mute.confirmed_s());
    }

    // Called by one thread, in this order: begin(); then attach(), or detach() if there is no link;
    // work() while attached.

    /// Call it before opening a link with this as its owner.
    void begin() MIDAIR_EXCLUDES(_mutex);
    /// \a isBack: count a reconnect.
    void attach(std::unique_ptr<UsbLink> link, bool isBack) MIDAIR_EXCLUDES(_mutex);
    /// Counts fields in flight as lost, and a loss for the reason \a why unless that is empty; the
    /// caller destroys the returned link.
    std::unique_ptr<UsbLink> detach(const std::string& why = {}) MIDAIR_EXCLUDES(_mutex);
    /// Does what is due until the link must be given up, and returns the reason, or an empty string
    /// after close().
    std::string work() MIDAIR_EXCLUDES(_mutex);
    /// Leaves all joints, mutes, waits at most \a atMost_s until the device confirms it, and makes
    /// work() return. Any thread.
    void close(double atMost_s) MIDAIR_EXCLUDES(_mutex);

private:
    using Outcome = UsbTransferPool::Outcome;

    /// State of one link: numbers, faults, and the device's self-description.
    struct Session
    {
        std::uint32_t sequence = 0;
        std::uint16_t flags = 0;       ///< last protocol::StatusFlags of the device
        Outcome fault = Outcome::DONE; ///< fault to recover from; DONE: none
        int faultsInRow = 0;
        LinkClock clock;
    };

    void onSent(std::uint64_t token, Outcome outcome) override;
    void onAnswer(const protocol::Packet& packet) override;
    void onReceiveFailed(Outcome outcome) override;
    void onNonsense(bool first) override;
    void commit(const JointCommit& joint) override;
    void drop(const JointCommit& joint) override;

    void become(State state) MIDAIR_REQUIRES(_mutex); ///< sets the state, unless it is CLOSING
    bool canHandOver() const MIDAIR_REQUIRES(_mutex);
    bool canSubmit() const MIDAIR_REQUIRES(_mutex)
    {
        return !_queue.isFull() && !_queue.isStaged() && canHandOver();
    }
    std::uint32_t nextSequence() MIDAIR_REQUIRES(_mutex);
    void submitField() MIDAIR_REQUIRES(_mutex);
    void submitCommit() MIDAIR_REQUIRES(_mutex);
    void handOver() MIDAIR_REQUIRES(_mutex);
    bool submitMute() MIDAIR_REQUIRES(_mutex);
    bool workOnce() MIDAIR_REQUIRES(_mutex); ///< does one due action; false: none was due
    std::string recover() MIDAIR_REQUIRES(_mutex);
    void takeStatus(const protocol::Packet& packet) MIDAIR_REQUIRES(_mutex);
    void noteFault(Outcome outcome) MIDAIR_REQUIRES(_mutex);
    void wakeWorker() MIDAIR_REQUIRES(_mutex);
    /// Calls action(link) with _mutex released, while no other thread uses the link or _bytes,
    /// except for a mute.
    template<typename Action>
    bool alone(Action&& action) MIDAIR_REQUIRES(_mutex);

    const std::vector<protocol::Range> _ranges;
    const std::shared_ptr<JointCommit::Seat> _seat;
    FieldCounters _counters; ///< all except those of fields; any thread
    HeldField _playing;      ///< last confirmed field; any thread

    mutable base::Mutex _mutex;
    base::Condition _wake;    ///< the worker
    base::Condition _changed; ///< an answer or a fault came, alone() ended, or the link is gone
    State _state MIDAIR_GUARDED_BY(_mutex) = State::AWAY;
    std::string _name MIDAIR_GUARDED_BY(_mutex);
    std::unique_ptr<UsbLink> _link MIDAIR_GUARDED_BY(_mutex);
    bool _busy MIDAIR_GUARDED_BY(_mutex) = false; ///< a thread is in alone()
    std::vector<std::uint8_t> _bytes; ///< for the thread in alone(), or with _mutex if it may be
    FieldQueue _queue MIDAIR_GUARDED_BY(_mutex);
    PendingMute _mute MIDAIR_GUARDED_BY(_mutex);
    Session _session MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
