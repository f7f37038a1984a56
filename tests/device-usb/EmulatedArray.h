#pragma once

#include "device/simulation/VirtualFirmware.h"
#include "tests/device-usb/ReadyPipe.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <linux/usbdevice_fs.h>
#include <umockdev.h>

/// The array as the kernel's usbfs would show it to the real libusb: umockdev answers libusb's
/// ioctls, the virtual firmware answers the packets. Faults are switched on by the test.
///
/// The device node is a pipe that is full, and so not ready, until a transfer has ended, as usbfs's
/// node is not: libusb then sleeps in between instead of asking again and again.
///
/// The device has a second interface, before the array's, and endpoint numbers that nobody would
/// guess. Several may be plugged in at a time, into ports 1 to 5 of one emulated bus, with the
/// serial numbers A0001 to A0005; umockdev has one thread for all.
class EmulatedArray
{
public:
    explicit EmulatedArray(const midair::device::DeviceLayout& layout,
                           const midair::device::VirtualFirmware::Options& options = {},
                           int port = 1);
    ~EmulatedArray();

    /// Not an array but an FT232H with serial number A0001, which hands what it is sent to \a take,
    /// on umockdev's thread.
    explicit EmulatedArray(std::function<void(const std::uint8_t*, std::size_t)> take);

    EmulatedArray(const EmulatedArray&) = delete;
    EmulatedArray& operator=(const EmulatedArray&) = delete;

    midair::device::VirtualFirmware& firmware() { return _firmware; }
    static double now_s();
    midair::device::DriveSignal playing() { return _firmware.playing(now_s()); }

    void plug();
    /// In-flight transfers end with \a error: ESHUTDOWN, EPROTO or EPIPE, as it happens with real
    /// controllers.
    void unplug(int error = 108);
    void letGo();          ///< what hangs arrives now, in its order
    void denyPermission(); ///< the device node can't be opened from here on

    // How many of the next OUT transfers with fields in them ..
    std::atomic<int> stalls{0};         ///< .. end with a stall, which stays until it is cleared
    std::atomic<int> hangs{0};          ///< .. never end, unless let go
    std::atomic<int> shorts{0};         ///< .. take only half of the bytes
    std::atomic<int> stalledCommits{0}; ///< as stalls, of transfers with a commit and nothing else
    std::atomic<bool> nonsense{false};  ///< answers are random bytes
    std::atomic<bool> mute{false};      ///< there are no answers
    std::atomic<bool> busyElsewhere{false}; ///< another program holds the interface
    std::atomic<int> cleared{0};            ///< CLEAR_HALT calls
    std::atomic<int> fieldTransfers{0};     ///< OUT transfers with fields that arrived whole
    std::atomic<int> discarded{0};          ///< transfers that the host took back

    std::function<void(const std::uint8_t*)>
        onField; ///< told the bytes of each of these, on umockdev's thread
    std::function<void(const std::uint8_t*)>
        onCommit; ///< told the bytes of a commit that came by itself, before the firmware has it
    std::function<void(const std::uint8_t*)>
        onDiscarded; ///< told the bytes of what the host takes back
    std::function<void(const std::uint8_t*)>
        onControl; ///< told the packets that come by the control endpoint

private:
    struct Urb
    {
        UMockdevIoctlData* data = nullptr;
        UMockdevIoctlData* buffer = nullptr;
        UMockdevIoctlClient* owner = nullptr;
        usbdevfs_urb& fields() const { return *reinterpret_cast<usbdevfs_urb*>(data->data); }
    };

    void connect();
    static gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
    static void onVanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
    gboolean handle(UMockdevIoctlClient* client);
    gboolean answer(UMockdevIoctlClient* client);
    gboolean submit(UMockdevIoctlClient* client, UMockdevIoctlData* data);
    gboolean bulk(UMockdevIoctlClient* client, UMockdevIoctlData* data);
    gboolean reap(UMockdevIoctlClient* client);
    gboolean discard(UMockdevIoctlClient* client);
    void startOut(const Urb& urb);
    void startHanging();
    void answerControl(const Urb& urb);
    void feedIn();
    void finish(const Urb& urb, int status, int length);
    void endAll(int error);
    bool isDue(); ///< with _mutex held: whether a host has something to fetch
    void watch();
    static void free(const Urb& urb);

    midair::device::VirtualFirmware _firmware;
    std::function<void(const std::uint8_t*, std::size_t)> _take;
    bool _isFifo = false;
    UMockdevTestbed* testbed() const { return _testbed.get(); }

    const int _port = 1;
    std::shared_ptr<UMockdevTestbed> _testbed; ///< shared by all
    UMockdevIoctlBase* _handler = nullptr;
    std::mutex _mutex;
    std::deque<Urb> _waitingIn;
    std::deque<Urb> _hanging;
    std::deque<Urb> _done;
    UMockdevIoctlClient* _claimedBy = nullptr;
    bool _plugged = false;
    bool _outHalted = false;
    ReadyPipe _node;
    bool _closing = false;
    std::condition_variable _wake;
    std::thread _watch; ///< for what the firmware says unasked, and what is hidden while `mute`
};
