#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/UsbConnection.h"
#include "device/usb/UsbTransferPool.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// `usb:` and `usb:SERIAL`: the array over libusb, in the protocol of PROTOCOL.md.
///
/// send() packs and submits the field where a transfer is free: that doesn't wait for the hardware,
/// and no other thread has to wake up for it. Else it leaves it in a slot one deep, where a newer
/// one replaces it, for a worker thread, who also does all the rest. A field whose transfer fails
/// is sent once more, whole, unless a newer one waits. When the device is lost the worker looks for
/// it every quarter of a second and takes it up again, silent until the next field.
///
/// A field of a joint goes in two transfers: its data, and when all have theirs its commit. Until
/// then newer ones wait in the slot. With a fault, or with 8 fields not confirmed, the device
/// leaves the joint and plays the field by itself.
class UsbArrayDevice : public ArrayDevice
{
public:
    struct Options
    {
        UsbAddress address;
        bool wait = false; ///< begin without the device instead of throwing
    };
    static Options takeOptions(DeviceUri& uri); ///< path: serial number; `id=VVVV:PPPP`, `wait`

    /// Throws DeviceError: what UsbTransferPool says, another protocol version, another number of
    /// transducers or boards, no answer.
    UsbArrayDevice(const DeviceLayout& layout, const Options& options);
    ~UsbArrayDevice() override; ///< mutes and waits until the device said so, at most 0.2 s

    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return true; }
    bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint) override
    {
        return _connection.send(signal, joint);
    }
    void silence() override { _connection.mute(); }
    std::string status() const override;
    DeviceReport report() const override { return _connection.report(); }
    DriveAbility ability() const override;
    bool identify(int board, bool light) override { return _connection.identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _connection.played(); }

private:
    void connect(bool isBack); ///< throws DeviceError
    void giveUp(const std::string& why);
    void run();
    bool isClosedWithin(double atMost_s);

    const DeviceLayout _layout;
    const Options _options;
    std::atomic<int> _fieldsPerSecond{0}; ///< what the firmware said; 0 before
    UsbConnection _connection;
    bool _connected = false; ///< the thread's, once that is there
    std::mutex _mutex;
    std::condition_variable _wake;
    bool _closing = false;
    std::thread _thread; ///< looks for the array while it is away, and works for the connection
};

} // namespace midair::device
