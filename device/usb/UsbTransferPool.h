#pragma once

#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

struct libusb_context;
struct libusb_device;
struct libusb_device_handle;
struct libusb_transfer;

namespace midair::device
{

/// The path of the device's usbfs file, such as "/dev/bus/usb/001/005".
std::string nodeOf(libusb_device* device);

/// Returns libusb's file descriptor for \a interface of an open device, or -1 if not found. libusb
/// still owns it.
int descriptorOf(libusb_device_handle* handle, unsigned interface);

/// Identifies a USB device; its interface is found by class (PROTOCOL.md).
struct UsbAddress
{
    std::uint16_t vendor = 0x1209;  ///< pid.codes
    std::uint16_t product = 0x0001; ///< pid.codes' test id, until one is registered
    std::string serial;             ///< empty: the first device found
};

/// An FT232H with factory ids, which may be the chip of a board.
inline const UsbAddress kFifoAddress{0x0403, 0x6014, {}};

/// A plugged-in USB device, for lists.
struct UsbListing
{
    int bus = 0;
    int address = 0;
    std::string serial;    ///< empty if it can't be opened
    std::string condition; ///< "free", or the reason why it can't be used
};
/// Lists the devices that match \a which.
std::vector<UsbListing> listUsbDevices(const UsbAddress& which);

/// A claimed interface of a USB device: a pool of asynchronous OUT transfers, one permanent IN
/// transfer for answers, and the thread that handles libusb's events. Has its own libusb context,
/// so that it sees devices that were plugged in before it.
class UsbTransferPool
{
public:
    /// Result of a transfer.
    enum class Outcome
    {
        DONE,
        SHORT, ///< the device took only part of the bytes
        STALLED,
        TIMED_OUT,
        CANCELLED,
        LOST, ///< unplugged
        FAILED
    };

    /// Receives the pool's events, on the event thread, with no lock of the pool held. May call
    /// send() and control(), but must not destroy the pool.
    class Listener
    {
    public:
        virtual ~Listener() = default;
        virtual void onSent(std::uint64_t token, Outcome outcome) = 0;
        virtual void onReceived(const std::uint8_t* bytes, std::size_t count) = 0;
        virtual void onReceiveFailed(Outcome outcome) = 0; ///< answers resume after clearHalt()
    };

    static constexpr int kTransfers = 4;
    static constexpr unsigned kSendTimeout_ms = 100; ///< by then the device's watchdog has muted

    /// Throws DeviceError if the device is missing, permission is denied, another program uses it,
    /// or it has no interface of this class.
    UsbTransferPool(const UsbAddress& which, Listener& listener);
    ~UsbTransferPool(); ///< cancels and waits for every transfer

    UsbTransferPool(const UsbTransferPool&) = delete;
    UsbTransferPool& operator=(const UsbTransferPool&) = delete;

    bool hasFree() const; ///< true if an OUT transfer is free
    /// Submits \a bytes. Returns false if no transfer is free, or, after calling onSent() with LOST
    /// or FAILED, if they can't be submitted. \a token is passed to onSent(). Any thread.
    bool send(std::uint64_t token, const std::vector<std::uint8_t>& bytes);
    /// Submits a packet by the control endpoint, which doesn't wait for OUT transfers. Returns
    /// false if it can't be submitted or the last one is still in flight. Any thread.
    bool control(const std::vector<std::uint8_t>& packet);
    void cancelSends(); ///< cancels all OUT transfers; any thread
    /// Clears a stall of both endpoints and resumes answers; returns false on failure. Must not be
    /// called on the event thread.
    bool clearHalt();

    const std::string& name() const { return _name; }

    struct Slot; ///< public for libusb's C callbacks

private:
    void open(const UsbAddress& which);
    void claim(libusb_device* device);
    void allocate() MIDAIR_REQUIRES(_mutex);
    void release() MIDAIR_REQUIRES(_mutex);
    bool receive() MIDAIR_REQUIRES(_mutex);
    bool isAnyBusy() const MIDAIR_REQUIRES(_mutex);
    void settle(Slot& slot);
    static void onOut(libusb_transfer* transfer);
    static void onIn(libusb_transfer* transfer);

    Listener& _listener;
    libusb_context* _context = nullptr;
    libusb_device_handle* _handle = nullptr;
    int _interface = -1;
    std::uint8_t _endpointOut = 0;
    std::uint8_t _endpointIn = 0;
    std::string _name;
    mutable base::Mutex _mutex;
    base::Condition _settled;
    /// kTransfers OUT, then control, then IN; includes everything except transfers in flight.
    std::vector<std::unique_ptr<Slot>> _slots MIDAIR_GUARDED_BY(_mutex);
    bool _closing MIDAIR_GUARDED_BY(_mutex) = false;
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

/// Returns \a outcome in words, for messages: "short transfer", "unplugged", ..
const char* outcomeName(UsbTransferPool::Outcome outcome);

} // namespace midair::device
