#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/UsbConnection.h"
#include "device/usb/UsbTransferPool.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <string>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// `usb:` and `usb:SERIAL`: the array over libusb, in the protocol of PROTOCOL.md.
///
/// send() packs and submits the field if a transfer is free, without waiting for the hardware or
/// waking another thread. Otherwise it leaves the field in a one-field slot, where a newer one
/// replaces it; a worker thread sends it and does everything else. A field whose transfer fails is
/// sent once more unless a newer one waits. When the device is lost, the worker looks for it every
/// 0.25 s and reconnects; the array stays silent until the next field.
///
/// A field of a joint takes two transfers: its data, and its commit when all devices have their
/// data. Until then newer fields wait in the slot. After a fault, or with 8 unconfirmed fields, the
/// device leaves the joint and plays the field by itself.
class UsbArrayDevice : public ArrayDevice
{
public:
    /// The parameters of the URI.
    struct Options
    {
        UsbAddress address;
        bool wait = false; ///< wait for a missing device instead of throwing
    };
    static Options takeOptions(DeviceUri& uri); ///< path: serial number; `id=VVVV:PPPP`, `wait`

    /// Throws DeviceError as UsbLink does, unless \a options.wait.
    UsbArrayDevice(const DeviceLayout& layout, const Options& options);
    ~UsbArrayDevice() override; ///< mutes and waits at most 0.2 s until the device confirms it

    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return true; }
    bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint) override
    {
        return _connection.send(signal, joint);
    }
    void silence() override { _connection.mute(); }
    double confirmed_s() const override { return _connection.confirmed_s(); }
    std::string status() const override;
    DeviceReport report() const override { return _connection.report(); }
    DriveAbility ability() const override;
    bool identify(int board, bool light) override { return _connection.identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _connection.played(); }

private:
    void connect(bool isBack); ///< throws DeviceError
    void giveUp(const std::string& why);
    void run();
    bool isClosedWithin(double atMost_s) MIDAIR_EXCLUDES(_mutex);

    const DeviceLayout _layout;
    const Options _options;
    std::atomic<int> _fieldsPerSecond{0}; ///< reported by the firmware; 0: not connected yet
    UsbConnection _connection;
    bool _connected = false; ///< used only by the thread while it runs
    base::Mutex _mutex;
    base::Condition _wake;
    bool _closing MIDAIR_GUARDED_BY(_mutex) = false;
    std::thread _thread; ///< calls work(), and looks for a missing array
};

} // namespace midair::device
