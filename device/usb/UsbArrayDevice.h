#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/JointCommit.h"
#include "device/usb/Protocol.h"
#include "device/usb/UsbTransferPool.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// `usb:` and `usb:SERIAL`: the array over libusb, in the protocol of PROTOCOL.md.
///
/// send() packs and submits the field where a transfer is free: that doesn't wait for the hardware, and no other thread has to wake
/// up for it. Else it leaves it in a slot one deep, where a newer one replaces it, for a worker thread, who also does all the rest. A
/// field whose transfer fails is sent once more, whole, unless a newer one waits. When the device is lost the worker looks for it every
/// quarter of a second and takes it up again, silent until the next field.
///
/// A field of a joint goes in two transfers: its data, and when all have theirs its commit. Until then newer ones wait in the slot.
/// With a fault, or with 8 fields not confirmed, the device leaves the joint and plays the field by itself.
class UsbArrayDevice : public ArrayDevice,
                       public UsbTransferPool::Listener,
                       public JointCommit::Device
{
public:
    struct Options
    {
        UsbAddress address;
        bool wait = false; ///< begin without the device instead of throwing
    };
    static Options takeOptions(DeviceUri& uri); ///< path: serial number; `id=VVVV:PPPP`, `wait`

    /// Throws DeviceError: what UsbTransferPool says, another protocol version, another number of transducers or boards, no answer.
    UsbArrayDevice(const DeviceLayout& layout, const Options& options);
    ~UsbArrayDevice() override; ///< mutes and waits until the device said so, at most 0.2 s

    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return true; }
    bool sendTogether(const DriveSignal& signal,
                      const std::shared_ptr<JointCommit>& joint) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override;
    bool identify(int board, bool light) override;
    std::vector<std::complex<float>> played() const override;

    // The pool's, on its thread.
    void onSent(std::uint64_t token, UsbTransferPool::Outcome outcome) override;
    void onReceived(const std::uint8_t* bytes, std::size_t count) override;
    void onReceiveFailed(UsbTransferPool::Outcome outcome) override;

    void commit(const JointCommit& joint) override;
    void drop(const JointCommit& joint) override;

private:
    using Joint = std::shared_ptr<JointCommit>;

    struct Field
    {
        Joint joint;           ///< null: none, or its commit is out
        bool released = false; ///< waits for nobody in it any more
        bool committed = false;
        std::uint32_t sequence = 0;
        DriveSignal signal;
        double sentAt_s = 0;
        double submittedAt_s = 0;
        bool failed = false; ///< its transfer ended badly
        bool repeated = false;
    };

    void run();
    void connect(); ///< throws DeviceError
    void disconnect(const std::string& why);
    bool work(std::unique_lock<std::mutex>& lock); ///< one thing that is due; false: nothing
    bool canHandOver() const;
    bool canSubmit() const;
    bool isStaged() const;    ///< the last of _flying has its commit still to come
    bool isCommitDue() const; ///< and waits for nobody with it
    bool isHeldBackFor(const JointCommit& joint) const;
    void wakeWorker();
    void release(); ///< ends _busy
    Joint fillSlot(const DriveSignal& signal, double sentAt_s, const Joint& joint);
    void submitField(std::unique_lock<std::mutex>& lock);
    void submitCommit(std::unique_lock<std::mutex>& lock);
    void handOver(std::unique_lock<std::mutex>& lock);
    void submitPacket(std::unique_lock<std::mutex>& lock, protocol::Type type);
    void recover(std::unique_lock<std::mutex>& lock);
    Joint settleFailed(); ///< gives the joint to be left
    void takeStatus(const protocol::Packet& packet);
    std::vector<Joint> muteLocked();         ///< gives the joints to be given up
    std::vector<Joint> settleAll(bool lost); ///< gives the joints that were waited for
    void note(const std::string& fault);
    double nextDue_s() const;
    std::uint32_t nextSequence();
    bool submitMute();

    static constexpr std::size_t kMostFlying = 8;

    const DeviceLayout _layout;
    const Options _options;
    const std::vector<protocol::Range> _ranges;
    mutable std::mutex _mutex;
    std::condition_variable _wake;  ///< the worker
    std::condition_variable _free;  ///< who waits until nobody is busy
    std::condition_variable _heard; ///< who waits for an answer
    std::unique_ptr<UsbTransferPool> _pool;
    bool _busy =
        false; ///< somebody is at the pool or at _bytes without the lock; nobody else may then, but for a mute
    std::vector<std::uint8_t> _bytes;
    std::vector<std::uint8_t> _muteBytes; ///< under _mutex
    protocol::StreamParser _parser;       ///< the event thread's
    bool _slotFull = false;
    Field _slot;
    std::deque<Field>
        _flying; ///< submitted, not yet confirmed; the last one perhaps without its commit
    DriveSignal _playing;
    std::uint32_t _sequence = 0;
    std::uint32_t _nonce = 0;
    bool _greeted = false;
    protocol::Packet _info;
    protocol::Status _status;
    UsbTransferPool::Outcome _fault = UsbTransferPool::Outcome::DONE;
    int _faultsInRow = 0;
    std::uint32_t _nonsense = 0;
    double _lastSubmit_s = 0;
    double _lastStatusAsked_s = 0;
    double _lastHeard_s = 0;
    int _asked = 0;                 ///< GET_STATUS since then
    std::uint32_t _muteAwaited = 0; ///< sequence number of a MUTE not yet answered; 0: none
    std::uint32_t _muteSent = 0;    ///< the last one that was handed over
    double _muteAt_s = 0;
    bool _ready = false;
    bool _closing = false;
    std::string _name;
    FieldCounters _counters;
    const std::shared_ptr<JointCommit::Seat> _seat = std::make_shared<JointCommit::Seat>(*this);
    std::thread _thread;
};

} // namespace midair::device
