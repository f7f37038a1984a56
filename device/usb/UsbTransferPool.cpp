#include "device/usb/UsbTransferPool.h"

#include "device/ArrayDevice.h"

#include <libusb.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

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

} // namespace

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
    // Before the listener, which may use the slot again; the pool exists until this thread ends.
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

} // namespace midair::device
