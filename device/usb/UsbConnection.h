#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/HeldField.h"
#include "device/JointCommit.h"
#include "device/usb/LinkClock.h"
#include "device/usb/UsbLink.h"

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
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

    bool send(const DriveSignal& signal, const Joint& joint); ///< see UsbArrayDevice
    /// Turns the array off at once and drops all fields; work() repeats the MUTE until the device
    /// confirms it.
    void mute();
    bool identify(int board, bool light)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _link != nullptr && _link->identify(board, light);
    }
    FieldCounters& counters() { return _counters; } ///< all but those of fields
    std::string name() const                        ///< of the last link
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _name;
    }
    DeviceReport report() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        DeviceReport report = _counters.report();
        _queue.addTo(report);
        return report;
    }
    std::uint16_t flags() const ///< the last protocol::StatusFlags that the device sent
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _flags;
    }
    std::vector<std::complex<float>> played() const { return _playing.activations(); }
    double confirmed_s() const ///< what its answers say, see ArrayDevice
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return std::max(_queue.confirmed_s(), _muted_s);
    }

    // These are called by one thread, in this order: begin(); then attach(), or detach() if there
    // is no link; work() while attached.

    void begin(); ///< to be called before a link with this as its owner is opened
    void attach(std::unique_ptr<UsbLink> link, bool isBack); ///< \a isBack: count a reconnect
    /// Counts fields in flight as lost, and a loss for the reason \a why unless that is empty; the
    /// caller destroys the returned link.
    std::unique_ptr<UsbLink> detach(const std::string& why = {});
    /// Does what is due until the link has to be given up, and returns the reason, or an empty
    /// string after close().
    std::string work();
    /// Leaves all joints, mutes, waits at most \a atMost_s until the device confirms it, and makes
    /// work() return. Any thread.
    void close(double atMost_s);

private:
    using Outcome = UsbTransferPool::Outcome;

    void onSent(std::uint64_t token, Outcome outcome) override;
    void onAnswer(const protocol::Packet& packet) override;
    void onReceiveFailed(Outcome outcome) override;
    void onNonsense(bool first) override;
    void commit(const JointCommit& joint) override;
    void drop(const JointCommit& joint) override;

    // With _mutex held.
    void become(State state); ///< sets the state, unless it is CLOSING
    bool canHandOver() const;
    bool canSubmit() const { return !_queue.isFull() && !_queue.isStaged() && canHandOver(); }
    void submitField(std::unique_lock<std::mutex>& lock);
    void submitCommit(std::unique_lock<std::mutex>& lock);
    void handOver(std::unique_lock<std::mutex>& lock);
    bool submitMute();
    /// does one thing that is due; false: none was
    bool workOnce(std::unique_lock<std::mutex>& lock);
    std::string recover(std::unique_lock<std::mutex>& lock);
    void takeStatus(const protocol::Packet& packet);
    void noteFault(Outcome outcome);
    void wakeWorker();
    /// Calls action(link) with the lock released, while no other thread uses the link or _bytes,
    /// except for a mute.
    template<typename Action>
    auto alone(std::unique_lock<std::mutex>& lock, Action&& action);

    const DeviceLayout _layout;
    const std::vector<protocol::Range> _ranges;
    FieldCounters _counters; ///< all but those of fields
    mutable std::mutex _mutex;
    std::condition_variable _wake;  ///< wakes the worker
    std::condition_variable _free;  ///< _busy became false
    std::condition_variable _heard; ///< an answer or a fault came, or the link is gone
    State _state = State::AWAY;
    std::unique_ptr<UsbLink> _link;
    bool _busy = false; ///< a thread is in alone()
    std::vector<std::uint8_t> _bytes;
    FieldQueue _queue;
    PendingMute _mute;
    double _muteAsked_s = 0; ///< steady clock, when mute() was called last
    double _muted_s = 0;     ///< the same of the last one that the device confirmed
    LinkClock _clock;
    HeldField _playing; ///< the last field that the device confirmed
    std::uint32_t _sequence = 0;
    std::uint16_t _flags = 0;       ///< the last protocol::StatusFlags that the device sent
    Outcome _fault = Outcome::DONE; ///< the fault to recover from; DONE: none
    int _faultsInRow = 0;
    std::string _name;
    const std::shared_ptr<JointCommit::Seat> _seat;
};

} // namespace midair::device
