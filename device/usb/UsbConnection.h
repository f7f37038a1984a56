#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/HeldField.h"
#include "device/JointCommit.h"
#include "device/usb/LinkClock.h"
#include "device/usb/UsbLink.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace midair::device
{

/// What goes to an array on the USB and what comes back: fields, mutes, signs of life, faults;
/// while it is there. When it isn't, fields are refused. Who owns this opens the link, and its
/// thread does in work() what no other does.
class UsbConnection : public UsbLink::Owner, private JointCommit::Device
{
public:
    using Joint = FieldQueue::Joint;

    enum class State
    {
        AWAY,
        GREETING, ///< a link is being opened
        READY,    ///< takes fields, also while a fault is recovered from
        CLOSING   ///< takes none any more, for good
    };

    UsbConnection(const DeviceLayout& layout, const std::string& name);
    ~UsbConnection() override;

    UsbConnection(const UsbConnection&) = delete;
    UsbConnection& operator=(const UsbConnection&) = delete;

    // Any thread.

    bool send(const DriveSignal& signal, const Joint& joint); ///< see UsbArrayDevice
    void mute();
    bool identify(int board, bool light)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _link != nullptr && _link->identify(board, light);
    }
    FieldCounters& counters() { return _counters; } ///< all but the fields'
    std::string name() const                        ///< the last link's
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
    std::uint16_t flags() const ///< protocol::StatusFlags that the device told last
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _flags;
    }
    std::vector<std::complex<float>> played() const { return _playing.activations(); }

    // One thread: in turn begin(), attach() or, where there is no link, detach(); while attached,
    // work().

    void begin(); ///< a link is about to be opened, of which this is the owner
    void attach(std::unique_ptr<UsbLink> link, bool isBack); ///< \a isBack: counts as a reconnect
    /// What is on its way is lost. The caller ends the link.
    std::unique_ptr<UsbLink> detach();
    /// Does what is due. Gives why the link is to be given up, or nothing when closed.
    std::string work();
    /// Has work() return; first mutes, in no joint any more, and waits at most \a atMost_s until
    /// the device said so. Any thread.
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
    void become(State state); ///< but for CLOSING, which stays
    bool canHandOver() const;
    bool canSubmit() const { return !_queue.isFull() && !_queue.isStaged() && canHandOver(); }
    void submitField(std::unique_lock<std::mutex>& lock);
    void submitCommit(std::unique_lock<std::mutex>& lock);
    void handOver(std::unique_lock<std::mutex>& lock);
    bool submitMute();
    std::vector<Joint> settleAll(bool isLost);         ///< gives the joints that were waited for
    bool workOnce(std::unique_lock<std::mutex>& lock); ///< one thing that is due; false: nothing
    std::string recover(std::unique_lock<std::mutex>& lock);
    void takeStatus(const protocol::Packet& packet);
    void noteFault(Outcome outcome);
    void wakeWorker();
    /// Calls action(link) unlocked, while nobody else is at the link or at _bytes, but for a mute.
    template<typename Action>
    auto alone(std::unique_lock<std::mutex>& lock, Action&& action);

    const DeviceLayout _layout;
    const std::vector<protocol::Range> _ranges;
    FieldCounters _counters; ///< but for the fields'
    mutable std::mutex _mutex;
    std::condition_variable _wake;  ///< the worker
    std::condition_variable _free;  ///< who waits until nobody is busy
    std::condition_variable _heard; ///< who waits for an answer
    State _state = State::AWAY;
    std::unique_ptr<UsbLink> _link;
    bool _busy = false; ///< somebody is in alone()
    std::vector<std::uint8_t> _bytes;
    FieldQueue _queue;
    PendingMute _mute;
    LinkClock _clock;
    HeldField _playing; ///< the last field that it confirmed
    std::uint32_t _sequence = 0;
    std::uint16_t _flags = 0;       ///< protocol::StatusFlags that the device told last
    Outcome _fault = Outcome::DONE; ///< one to be recovered from
    int _faultsInRow = 0;
    std::string _name;
    const std::shared_ptr<JointCommit::Seat> _seat;
};

} // namespace midair::device
