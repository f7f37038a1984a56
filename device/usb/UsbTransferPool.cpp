#include "device/usb/UsbTransferPool.h"

#include "device/ArrayDevice.h"

#include <libusb.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include <dirent.h>
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

namespace midair::device
{

namespace
{

constexpr std::uint8_t kControlRequest = 0x4D;
constexpr std::size_t kInBytes = 4096;
constexpr std::size_t kControlSlot = UsbTransferPool::kTransfers;
constexpr std::size_t kInSlot = kControlSlot + 1;

UsbTransferPool::Outcome outcomeOf(const libusb_transfer& transfer)
{
    using Outcome = UsbTransferPool::Outcome;
    switch (transfer.status)
    {
    case LIBUSB_TRANSFER_COMPLETED:
        return Outcome::DONE;
    case LIBUSB_TRANSFER_TIMED_OUT:
        return Outcome::TIMED_OUT;
    case LIBUSB_TRANSFER_CANCELLED:
        return Outcome::CANCELLED;
    case LIBUSB_TRANSFER_STALL:
        return Outcome::STALLED;
    case LIBUSB_TRANSFER_NO_DEVICE:
        return Outcome::LOST;
    case LIBUSB_TRANSFER_OVERFLOW:
    case LIBUSB_TRANSFER_ERROR:
        break;
    }
    return Outcome::FAILED;
}

// Identify the interface, whatever its number (PROTOCOL.md).
constexpr std::uint8_t kClass = 0xFF;
constexpr std::uint8_t kSubclass = 0x4D;
constexpr std::uint8_t kProtocol = 0x48;

std::string idText(std::uint16_t vendor, std::uint16_t product)
{
    return fmt::format("{:04x}:{:04x}", vendor, product);
}

std::string permissionText(libusb_device* device)
{
    return "permission denied for " + nodeOf(device) +
           ": copy 70-osgmidair.rules, which osgMidair installs in lib/udev/rules.d, to "
           "/etc/udev/rules.d, run \"udevadm "
           "control --reload\" and plug the array in again";
}

std::string serialOf(libusb_device_handle* handle, std::uint8_t index)
{
    unsigned char text[128] = {};
    if (index == 0 || libusb_get_string_descriptor_ascii(handle, index, text, sizeof text) < 0)
        return {};
    return reinterpret_cast<const char*>(text);
}

/// The list of plugged-in devices; the destructor frees it.
class DeviceList
{
public:
    explicit DeviceList(libusb_context* context) : _count(libusb_get_device_list(context, &_list))
    {
    }
    ~DeviceList()
    {
        if (_count >= 0) libusb_free_device_list(_list, 1);
    }
    DeviceList(const DeviceList&) = delete;
    DeviceList& operator=(const DeviceList&) = delete;
    libusb_device** begin() const { return _list; }
    libusb_device** end() const { return _list + std::max<ssize_t>(_count, 0); }

private:
    libusb_device** _list = nullptr;
    ssize_t _count;
};

bool matches(libusb_device* device, const UsbAddress& which, libusb_device_descriptor& descriptor)
{
    return libusb_get_device_descriptor(device, &descriptor) == 0 &&
           descriptor.idVendor == which.vendor && descriptor.idProduct == which.product;
}

} // namespace

std::string nodeOf(libusb_device* device)
{
    return fmt::format("/dev/bus/usb/{:03}/{:03}",
                       libusb_get_bus_number(device),
                       libusb_get_device_address(device));
}

// libusb doesn't return it. Another thread may have the same device open briefly, to read its
// serial number, so the descriptor must also be the one that holds the claim: claiming again
// succeeds and changes nothing for that one, and fails with EBUSY for any other.
int descriptorOf(libusb_device_handle* handle, unsigned interface)
{
    struct stat node
    {
    };
    if (::stat(nodeOf(libusb_get_device(handle)).c_str(), &node) != 0) return -1;
    const std::unique_ptr<DIR, int (*)(DIR*)> open(::opendir("/proc/self/fd"), ::closedir);
    if (open == nullptr) return -1;
    // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread has this DIR
    while (const dirent* entry = ::readdir(open.get()))
    {
        // 0 for "." and "..", which is a descriptor anyway
        const int descriptor = std::atoi(entry->d_name);
        struct stat file
        {
        };
        const bool same = ::fstat(descriptor, &file) == 0 && file.st_dev == node.st_dev &&
                          file.st_ino == node.st_ino;
        if (same && ::ioctl(descriptor, USBDEVFS_CLAIMINTERFACE, &interface) == 0)
            return descriptor;
    }
    return -1;
}

/// One transfer with its buffer and the token of its sender.
struct UsbTransferPool::Slot
{
    UsbTransferPool* pool = nullptr;
    libusb_transfer* transfer = nullptr;
    std::vector<std::uint8_t> buffer;
    std::uint64_t token = 0;
    bool busy = false;
};

const char* outcomeName(UsbTransferPool::Outcome outcome)
{
    using Outcome = UsbTransferPool::Outcome;
    switch (outcome)
    {
    case Outcome::DONE:
        return "done";
    case Outcome::SHORT:
        return "short transfer";
    case Outcome::STALLED:
        return "stall";
    case Outcome::TIMED_OUT:
        return "timeout";
    case Outcome::CANCELLED:
        return "cancelled";
    case Outcome::LOST:
        return "unplugged";
    case Outcome::FAILED:
        return "transfer error";
    }
    return "";
}

UsbTransferPool::UsbTransferPool(const UsbAddress& which, Listener& listener) : _listener(listener)
{
    const int error = libusb_init(&_context);
    if (error != 0)
        throw DeviceError(std::string("usb: libusb doesn't start: ") + libusb_error_name(error));
    {
        const base::Lock lock(_mutex);
        try
        {
            open(which);
            allocate();
        }
        catch (...)
        {
            release();
            throw;
        }
    }
    _thread = std::thread(
        [this]
        {
            while (!_stop)
            {
                timeval wait{1, 0};
                libusb_handle_events_timeout_completed(_context, &wait, nullptr);
            }
        });
    const base::Lock lock(_mutex);
    receive();
}

UsbTransferPool::~UsbTransferPool()
{
    {
        base::Lock lock(_mutex);
        _closing = true;
        for (const auto& slot : _slots)
            if (slot->busy) libusb_cancel_transfer(slot->transfer);
        while (isAnyBusy())
            _settled.wait(lock);
    }
    _stop = true;
    libusb_interrupt_event_handler(_context);
    _thread.join();
    const base::Lock lock(_mutex);
    release();
}

bool UsbTransferPool::isAnyBusy() const
{
    return std::any_of(_slots.begin(), _slots.end(), [](const auto& slot) { return slot->busy; });
}

void UsbTransferPool::release()
{
    for (const auto& slot : _slots)
        libusb_free_transfer(slot->transfer);
    _slots.clear();
    if (_handle != nullptr)
    {
        if (_interface >= 0) libusb_release_interface(_handle, _interface);
        libusb_close(_handle);
    }
    libusb_exit(_context);
}

void UsbTransferPool::allocate()
{
    for (std::size_t i = 0; i <= kInSlot; ++i)
    {
        _slots.push_back(std::make_unique<Slot>());
        _slots.back()->pool = this;
        _slots.back()->transfer = libusb_alloc_transfer(0);
        if (_slots.back()->transfer == nullptr) throw DeviceError(_name + ": out of memory");
    }
    _slots[kInSlot]->buffer.resize(kInBytes);
}

bool UsbTransferPool::hasFree() const
{
    const base::Lock lock(_mutex);
    return std::any_of(
        _slots.begin(), _slots.begin() + kTransfers, [](const auto& slot) { return !slot->busy; });
}

bool UsbTransferPool::send(std::uint64_t token, const std::vector<std::uint8_t>& bytes)
{
    int error = 0;
    {
        const base::Lock lock(_mutex);
        const auto free = std::find_if(_slots.begin(),
                                       _slots.begin() + kTransfers,
                                       [](const auto& slot) { return !slot->busy; });
        if (_closing || free == _slots.begin() + kTransfers) return false;
        Slot& slot = **free;
        slot.buffer.assign(bytes.begin(), bytes.end());
        slot.token = token;
        libusb_fill_bulk_transfer(slot.transfer,
                                  _handle,
                                  _endpointOut,
                                  slot.buffer.data(),
                                  static_cast<int>(slot.buffer.size()),
                                  onOut,
                                  &slot,
                                  kSendTimeout_ms);
        error = libusb_submit_transfer(slot.transfer);
        slot.busy = error == 0;
    }
    if (error != 0)
        _listener.onSent(token, error == LIBUSB_ERROR_NO_DEVICE ? Outcome::LOST : Outcome::FAILED);
    return error == 0;
}

bool UsbTransferPool::control(const std::vector<std::uint8_t>& packet)
{
    const base::Lock lock(_mutex);
    Slot& slot = *_slots[kControlSlot];
    if (_closing || slot.busy) return false;
    slot.buffer.resize(LIBUSB_CONTROL_SETUP_SIZE);
    slot.buffer.insert(slot.buffer.end(), packet.begin(), packet.end());
    constexpr std::uint8_t kVendorOutInterface =
        std::uint8_t(LIBUSB_REQUEST_TYPE_VENDOR) | std::uint8_t(LIBUSB_RECIPIENT_INTERFACE);
    libusb_fill_control_setup(slot.buffer.data(),
                              kVendorOutInterface,
                              kControlRequest,
                              0,
                              static_cast<std::uint16_t>(_interface),
                              static_cast<std::uint16_t>(packet.size()));
    libusb_fill_control_transfer(
        slot.transfer, _handle, slot.buffer.data(), onOut, &slot, kSendTimeout_ms);
    slot.token = 0;
    slot.busy = libusb_submit_transfer(slot.transfer) == 0;
    return slot.busy;
}

void UsbTransferPool::cancelSends()
{
    const base::Lock lock(_mutex);
    for (int i = 0; i < kTransfers; ++i)
        if (_slots[i]->busy) libusb_cancel_transfer(_slots[i]->transfer);
}

bool UsbTransferPool::clearHalt()
{
    if (libusb_clear_halt(_handle, _endpointOut) != 0 ||
        libusb_clear_halt(_handle, _endpointIn) != 0)
        return false;
    const base::Lock lock(_mutex);
    return _slots[kInSlot]->busy || receive();
}

bool UsbTransferPool::receive()
{
    Slot& slot = *_slots[kInSlot];
    if (_closing) return false;
    libusb_fill_bulk_transfer(slot.transfer,
                              _handle,
                              _endpointIn,
                              slot.buffer.data(),
                              static_cast<int>(slot.buffer.size()),
                              onIn,
                              &slot,
                              0);
    slot.busy = libusb_submit_transfer(slot.transfer) == 0;
    return slot.busy;
}

void UsbTransferPool::settle(Slot& slot)
{
    const base::Lock lock(_mutex);
    slot.busy = false;
    _settled.notifyAll();
}

void UsbTransferPool::onOut(libusb_transfer* transfer)
{
    Slot& slot = *static_cast<Slot*>(transfer->user_data);
    UsbTransferPool& pool = *slot.pool;
    Outcome outcome = outcomeOf(*transfer);
    if (transfer->type == LIBUSB_TRANSFER_TYPE_BULK && outcome == Outcome::DONE &&
        transfer->actual_length < transfer->length)
        outcome = Outcome::SHORT;
    const std::uint64_t token = slot.token;
    // Before the listener, which may reuse the slot; the pool exists until this thread ends.
    pool.settle(slot);
    pool._listener.onSent(token, outcome);
}

void UsbTransferPool::onIn(libusb_transfer* transfer)
{
    Slot& slot = *static_cast<Slot*>(transfer->user_data);
    UsbTransferPool& pool = *slot.pool;
    const Outcome outcome = outcomeOf(*transfer);
    if (outcome == Outcome::DONE)
    {
        pool._listener.onReceived(slot.buffer.data(),
                                  static_cast<std::size_t>(transfer->actual_length));
        const base::Lock lock(pool._mutex);
        if (pool.receive()) return;
    }
    pool.settle(slot);
    if (outcome != Outcome::CANCELLED)
        pool._listener.onReceiveFailed(outcome == Outcome::DONE ? Outcome::FAILED : outcome);
}

std::vector<UsbListing> listUsbDevices(const UsbAddress& which)
{
    std::vector<UsbListing> found;
    libusb_context* context = nullptr;
    if (libusb_init(&context) != 0) return found;
    {
        const DeviceList devices(context);
        for (libusb_device* device : devices)
        {
            libusb_device_descriptor descriptor{};
            if (!matches(device, which, descriptor)) continue;
            UsbListing listing;
            listing.bus = libusb_get_bus_number(device);
            listing.address = libusb_get_device_address(device);
            libusb_device_handle* handle = nullptr;
            const int error = libusb_open(device, &handle);
            if (error == 0)
            {
                listing.serial = serialOf(handle, descriptor.iSerialNumber);
                listing.condition = "free";
                libusb_close(handle);
            }
            else
                listing.condition = error == LIBUSB_ERROR_ACCESS ? permissionText(device)
                                                                 : libusb_error_name(error);
            if (which.serial.empty() || which.serial == listing.serial) found.push_back(listing);
        }
    }
    libusb_exit(context);
    return found;
}

void UsbTransferPool::open(const UsbAddress& which)
{
    const DeviceList devices(_context);
    std::string refusal;
    for (libusb_device* device : devices)
    {
        libusb_device_descriptor descriptor{};
        if (!matches(device, which, descriptor)) continue;
        const int error = libusb_open(device, &_handle);
        if (error != 0)
        {
            refusal = error == LIBUSB_ERROR_ACCESS
                          ? permissionText(device)
                          : nodeOf(device) + " can't be opened: " + libusb_error_name(error);
            continue;
        }
        const std::string serial = serialOf(_handle, descriptor.iSerialNumber);
        if (which.serial.empty() || serial == which.serial)
        {
            _name = "usb:" + serial + " at " + nodeOf(device);
            claim(device);
            return;
        }
        libusb_close(_handle);
        _handle = nullptr;
    }
    if (!refusal.empty()) throw DeviceError("usb: " + refusal);
    throw DeviceError("usb: no array " + idText(which.vendor, which.product) +
                      (which.serial.empty() ? "" : " with serial number \"" + which.serial + "\"") +
                      " is plugged in");
}

void UsbTransferPool::claim(libusb_device* device)
{
    libusb_config_descriptor* config = nullptr;
    if (libusb_get_active_config_descriptor(device, &config) == 0)
    {
        for (int i = 0; i < config->bNumInterfaces && _interface < 0; ++i)
            for (int a = 0; a < config->interface[i].num_altsetting && _interface < 0; ++a)
            {
                const libusb_interface_descriptor& face = config->interface[i].altsetting[a];
                if (face.bInterfaceClass != kClass || face.bInterfaceSubClass != kSubclass ||
                    face.bInterfaceProtocol != kProtocol || face.bAlternateSetting != 0)
                    continue;
                _endpointOut = _endpointIn = 0;
                for (int e = 0; e < face.bNumEndpoints; ++e)
                {
                    const libusb_endpoint_descriptor& endpoint = face.endpoint[e];
                    if ((endpoint.bmAttributes & 3U) != LIBUSB_TRANSFER_TYPE_BULK) continue;
                    const bool in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0;
                    (in ? _endpointIn : _endpointOut) = endpoint.bEndpointAddress;
                }
                if (_endpointOut != 0 && _endpointIn != 0) _interface = face.bInterfaceNumber;
            }
        libusb_free_config_descriptor(config);
    }
    if (_interface < 0)
        throw DeviceError(_name + ": has no interface of class FF, subclass 4D, protocol 48 with "
                                  "bulk endpoints both ways, "
                                  "so it isn't an array");
    libusb_set_auto_detach_kernel_driver(_handle, 1);
    const int error = libusb_claim_interface(_handle, _interface);
    if (error == 0) return;
    _interface = -1;
    if (error == LIBUSB_ERROR_BUSY)
        throw DeviceError(_name + ": another program uses it; close that first");
    throw DeviceError(_name + ": can't be claimed: " + libusb_error_name(error));
}

} // namespace midair::device
