#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/HeldField.h"
#include "device/JointCommit.h"
#include "device/usb/LinkClock.h"
#include "device/usb/UsbLink.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// The traffic with an array on the USB: fields, mutes, keep-alives, answers and faults, over a
/// UsbLink while one is attached; without one, fields are refused. The owner opens the link, and
/// its thread calls work().
class UsbConnection : public UsbLink::Owner, private JointCommit::Device
{
public:
    using Joint = FieldQueue::Joint;

    enum class State
    {
        AWAY,
        GREETING, ///< a link is being opened
        READY,    ///< takes fields, also while it recovers from a fault
        CLOSING   ///< takes no fields any more; final
    };

    UsbConnection(const DeviceLayout& layout, const std::string& name);
    ~UsbConnection() override;

    UsbConnection(const UsbConnection&) = delete;
    UsbConnection& operator=(const UsbConnection&) = delete;

    // These may be called from any thread.

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
    FieldCounters& counters() { return _counters; }  ///< all but those of fields
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
    double confirmed_s() const MIDAIR_EXCLUDES(_mutex) ///< what its answers say, see ArrayDevice
    {
        const base::Lock lock(_mutex);
        return std::max(_queue.confirmed_s(), _mute.confirmed_s());
    }

    // These are called by one thread, in this order: begin(); then attach(), or detach() if there
    // is no link; work() while attached.

    /// To be called before a link with this as its owner is opened.
    void begin() MIDAIR_EXCLUDES(_mutex);
    /// \a isBack: count a reconnect.
    void attach(std::unique_ptr<UsbLink> link, bool isBack) MIDAIR_EXCLUDES(_mutex);
    /// Counts fields in flight as lost, and a loss for the reason \a why unless that is empty; the
    /// caller destroys the returned link.
    std::unique_ptr<UsbLink> detach(const std::string& why = {}) MIDAIR_EXCLUDES(_mutex);
    /// Does what is due until the link has to be given up, and returns the reason, or an empty
    /// string after close().
    std::string work() MIDAIR_EXCLUDES(_mutex);
    /// Leaves all joints, mutes, waits at most \a atMost_s until the device confirms it, and makes
    /// work() return. Any thread.
    void close(double atMost_s) MIDAIR_EXCLUDES(_mutex);

private:
    using Outcome = UsbTransferPool::Outcome;

    /// What begins anew with each link: numbers, faults, and what the device said of itself.
    struct Session
    {
        std::uint32_t sequence = 0;
        std::uint16_t flags = 0;       ///< the last protocol::StatusFlags that the device sent
        Outcome fault = Outcome::DONE; ///< the fault to recover from; DONE: none
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
    bool workOnce() MIDAIR_REQUIRES(_mutex); ///< does one thing that is due; false: none was
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
    FieldCounters _counters; ///< all but those of fields; any thread
    HeldField _playing;      ///< the last field that the device confirmed; any thread

    mutable base::Mutex _mutex;
    base::Condition _wake;    ///< the worker
    base::Condition _changed; ///< an answer or a fault came, alone() ended, or the link is gone
    State _state MIDAIR_GUARDED_BY(_mutex) = State::AWAY;
    std::string _name MIDAIR_GUARDED_BY(_mutex);
    std::unique_ptr<UsbLink> _link MIDAIR_GUARDED_BY(_mutex);
    bool _busy MIDAIR_GUARDED_BY(_mutex) = false; ///< a thread is in alone()
    std::vector<std::uint8_t> _bytes;             ///< of who is alone(), or has _mutex and may be
    FieldQueue _queue MIDAIR_GUARDED_BY(_mutex);
    PendingMute _mute MIDAIR_GUARDED_BY(_mutex);
    Session _session MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
