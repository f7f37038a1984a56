#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

struct libusb_context;
struct libusb_device;
struct libusb_device_handle;
struct libusb_transfer;

namespace midair::device
{

/// Which USB device is meant; the interface is found by its class (PROTOCOL.md).
struct UsbAddress
{
    std::uint16_t vendor = 0x1209;  ///< pid.codes
    std::uint16_t product = 0x0001; ///< its id for tests, until one is registered
    std::string serial;             ///< empty: the first that is there
};

/// An FT232H as it leaves the factory: perhaps the chip of a board.
inline const UsbAddress kFifoAddress{0x0403, 0x6014, {}};

/// What is plugged in, for lists.
struct UsbListing
{
    int bus = 0;
    int address = 0;
    std::string serial;    ///< empty when it can't be opened
    std::string condition; ///< "free", or why it can't be used
};
std::vector<UsbListing> listUsbDevices(const UsbAddress& which);

/// One claimed interface of a USB device: a pool of asynchronous OUT transfers, one IN transfer
/// that is always waiting, and the thread that handles libusb's events. Has a libusb context of its
/// own, so that it sees what was plugged in before it.
class UsbTransferPool
{
public:
    enum class Outcome
    {
        DONE,
        SHORT, ///< the device took less than all
        STALLED,
        TIMED_OUT,
        CANCELLED,
        LOST, ///< unplugged
        FAILED
    };

    /// Told on the event thread, with no lock of the pool held. May call send() and control(), not
    /// the destructor.
    class Listener
    {
    public:
        virtual ~Listener() = default;
        virtual void onSent(std::uint64_t token, Outcome outcome) = 0;
        virtual void onReceived(const std::uint8_t* bytes, std::size_t count) = 0;
        virtual void onReceiveFailed(Outcome outcome) = 0; ///< IN waits again after clearHalt()
    };

    static constexpr int kTransfers = 4;
    static constexpr unsigned kSendTimeout_ms = 100; ///< the device's watchdog would mute by then

    /// Throws DeviceError: not there, permission denied, busy, no such interface.
    UsbTransferPool(const UsbAddress& which, Listener& listener);
    ~UsbTransferPool(); ///< cancels and waits for every transfer

    UsbTransferPool(const UsbTransferPool&) = delete;
    UsbTransferPool& operator=(const UsbTransferPool&) = delete;

    bool hasFree() const;
    /// Hands \a bytes over; false when no transfer is free, or (told as LOST) the device is gone.
    /// Any thread.
    bool send(std::uint64_t token, const std::vector<std::uint8_t>& bytes);
    /// A packet by the control endpoint, which waits for no other transfer. Any thread; false when
    /// it can't be handed over.
    bool control(const std::vector<std::uint8_t>& packet);
    void cancelSends();
    /// Lifts a stall of either endpoint and waits for answers again; false when that fails. Not on
    /// the event thread.
    bool clearHalt();

    const std::string& name() const { return _name; }

    struct Slot; ///< public for the callbacks of C

private:
    void open(const UsbAddress& which);
    void claim(libusb_device* device);
    void allocate();
    void release();
    bool receive();
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
    mutable std::mutex _mutex;
    std::condition_variable _settled;
    std::vector<std::unique_ptr<Slot>> _slots; ///< kTransfers OUT, then control, then IN
    bool _closing = false;
    std::atomic<bool> _stop{false};
    std::thread _thread;
};

const char* outcomeName(UsbTransferPool::Outcome outcome);

} // namespace midair::device
