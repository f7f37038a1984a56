#include "tests/device-usb/EmulatedArray.h"

#include "tests/device-usb/Descriptors.h"
#include "tests/device-usb/Testbed.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>

namespace
{

constexpr int kOut = 0x03;
constexpr int kIn = 0x86;
constexpr int kFifoOut = 0x02;
constexpr int kFifoIn = 0x81;

} // namespace

double EmulatedArray::now_s()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

EmulatedArray::EmulatedArray(const midair::device::DeviceLayout& layout,
                             const midair::device::VirtualFirmware::Options& options,
                             int port) :
    _firmware(layout, options),
    _port(port),
    _testbed(theTestbed()),
    _handler(umockdev_ioctl_base_new())
{
    _take = [this](const std::uint8_t* bytes, std::size_t count)
    { _firmware.receive(bytes, count, now_s()); };
    connect();
}

EmulatedArray::EmulatedArray(std::function<void(const std::uint8_t*, std::size_t)> take) :
    _firmware(midair::device::DeviceLayout{1, {}}),
    _take(std::move(take)),
    _isFifo(true),
    _testbed(theTestbed()),
    _handler(umockdev_ioctl_base_new())
{
    connect();
}

void EmulatedArray::connect()
{
    g_signal_connect(_handler, "handle-ioctl", G_CALLBACK(onIoctl), this);
    g_signal_connect(_handler, "client-vanished", G_CALLBACK(onVanished), this);
    plug();
    _watch = std::thread([this] { watch(); });
}

EmulatedArray::~EmulatedArray()
{
    {
        std::lock_guard<std::mutex> lock(_mutex);
        _closing = true;
    }
    _wake.notify_all();
    _watch.join();
    if (_plugged) unplug();
    for (const Urb& urb : _done)
        free(urb);
    g_object_unref(_handler);
}

void EmulatedArray::plug()
{
    GError* error = nullptr;
    umockdev_testbed_add_from_string(
        testbed(), recordText(_isFifo ? kFifoDescriptors : kDescriptors, _port).c_str(), &error);
    if (error != nullptr) throw std::runtime_error(error->message);
    umockdev_testbed_attach_ioctl(testbed(), nodeOf(_port).c_str(), _handler, &error);
    if (error != nullptr) throw std::runtime_error(error->message);
    _firmware.powerCycle(now_s());
    std::lock_guard<std::mutex> lock(_mutex);
    char* root = umockdev_testbed_get_root_dir(testbed());
    _node.make(std::string(root) + nodeOf(_port));
    g_free(root);
    _outHalted = false;
    _plugged = true;
}

bool EmulatedArray::isDue()
{
    return !_done.empty() ||
           (_plugged && !_waitingIn.empty() && !mute && _firmware.hasAnswer(now_s()));
}

void EmulatedArray::watch()
{
    std::unique_lock<std::mutex> lock(_mutex);
    while (!_closing)
    {
        _node.set(isDue());
        _wake.wait_for(lock, std::chrono::milliseconds(1));
    }
}

void EmulatedArray::unplug(int error)
{
    {
        std::lock_guard<std::mutex> lock(_mutex);
        _plugged = false;
        _claimedBy = nullptr;
        endAll(-error);
    }
    _firmware.powerCycle(now_s());
    GError* failure = nullptr;
    umockdev_testbed_detach_ioctl(testbed(), nodeOf(_port).c_str(), &failure);
    g_clear_error(&failure);
    umockdev_testbed_uevent(testbed(), sysPathOf(_port).c_str(), "remove");
    umockdev_testbed_remove_device(testbed(), sysPathOf(_port).c_str());
}

void EmulatedArray::denyPermission()
{
    char* root = umockdev_testbed_get_root_dir(testbed());
    const std::string base = root;
    g_free(root);
    ::chmod(base.c_str(), 0755); // so that only the node itself refuses
    ::chmod((base + nodeOf(_port)).c_str(), 0);
}

void EmulatedArray::free(const Urb& urb)
{
    g_clear_object(const_cast<UMockdevIoctlData**>(&urb.data));
    g_clear_object(const_cast<UMockdevIoctlData**>(&urb.buffer));
}

gboolean EmulatedArray::onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self)
{
    return static_cast<EmulatedArray*>(self)->handle(client);
}

void EmulatedArray::onVanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self)
{
    auto& array = *static_cast<EmulatedArray*>(self);
    std::lock_guard<std::mutex> lock(array._mutex);
    if (array._claimedBy == client) array._claimedBy = nullptr;
    for (auto* queue : {&array._waitingIn, &array._hanging, &array._done})
        for (auto urb = queue->begin(); urb != queue->end();)
        {
            if (urb->owner != client)
            {
                ++urb;
                continue;
            }
            free(*urb);
            urb = queue->erase(urb);
        }
}

gboolean EmulatedArray::handle(UMockdevIoctlClient* client)
{
    std::lock_guard<std::mutex> lock(_mutex);
    const gboolean handled = answer(client);
    _node.set(isDue());
    return handled;
}

gboolean EmulatedArray::answer(UMockdevIoctlClient* client)
{
    const gulong request = umockdev_ioctl_client_get_request(client);
    if (request == USBDEVFS_DISCARDURB) return discard(client);
    if (request == USBDEVFS_REAPURBNDELAY) return reap(client);
    GError* error = nullptr;
    UMockdevIoctlData* data = umockdev_ioctl_data_resolve(
        umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), &error);
    if (error != nullptr)
    {
        g_clear_error(&error);
        return FALSE;
    }
    [[maybe_unused]] g_autoptr(UMockdevIoctlData) owner = data; // unrefs it in the end
    const auto complete = [&](int result, int code)
    {
        umockdev_ioctl_client_complete(client, result, code);
        return TRUE;
    };
    if (!_plugged) return complete(-1, ENODEV);
    switch (request)
    {
    case USBDEVFS_GET_CAPABILITIES:
    {
        guint32 abilities = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                            USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
        umockdev_ioctl_data_update(
            data, 0, reinterpret_cast<guint8*>(&abilities), sizeof abilities);
        return complete(0, 0);
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
        if (busyElsewhere || (_claimedBy != nullptr && _claimedBy != client))
            return complete(-1, EBUSY);
        _claimedBy = client;
        return complete(0, 0);
    case USBDEVFS_RELEASEINTERFACE:
        if (_claimedBy == client) _claimedBy = nullptr;
        return complete(0, 0);
    case USBDEVFS_CLEAR_HALT:
        ++cleared;
        _outHalted = false;
        return complete(0, 0);
    case USBDEVFS_SUBMITURB:
        return submit(client, data);
    case USBDEVFS_BULK:
        return bulk(client, data);
    case USBDEVFS_GETDRIVER:
        return complete(-1, ENODATA);
    default:
        return complete(-1, ENOTTY);
    }
}

// As the kernel takes it, but for nobody who hasn't claimed the interface; only the FIFO is written
// to like this.
gboolean EmulatedArray::bulk(UMockdevIoctlClient* client, UMockdevIoctlData* data)
{
    const auto& transfer = *reinterpret_cast<const usbdevfs_bulktransfer*>(data->data);
    const bool takes = _isFifo && transfer.ep == kFifoOut && _claimedBy == client;
    g_autoptr(UMockdevIoctlData) buffer = umockdev_ioctl_data_resolve(
        data, offsetof(usbdevfs_bulktransfer, data), transfer.len, nullptr);
    if (takes && buffer != nullptr) _take(buffer->data, transfer.len);
    umockdev_ioctl_client_complete(
        client, takes ? static_cast<glong>(transfer.len) : -1, takes ? 0 : EINVAL);
    return TRUE;
}

gboolean EmulatedArray::submit(UMockdevIoctlClient* client, UMockdevIoctlData* data)
{
    Urb urb;
    urb.data = umockdev_ioctl_data_ref(data);
    urb.owner = client;
    const std::size_t length = static_cast<std::size_t>(urb.fields().buffer_length);
    urb.buffer = umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_urb, buffer), length, nullptr);
    if (urb.fields().type == USBDEVFS_URB_TYPE_CONTROL)
        answerControl(urb);
    else if (urb.fields().endpoint == (_isFifo ? kFifoOut : kOut))
        startOut(urb);
    else if (urb.fields().endpoint == (_isFifo ? kFifoIn : kIn))
        _waitingIn.push_back(urb);
    else
        finish(urb, -ENOENT, 0);
    umockdev_ioctl_client_complete(client, 0, 0);
    return TRUE;
}

// Looks at the host's memory, which is a way to it and back, only where there is something to put
// there.
gboolean EmulatedArray::reap(UMockdevIoctlClient* client)
{
    if (_plugged) feedIn();
    const auto mine = std::find_if(
        _done.begin(), _done.end(), [&](const Urb& urb) { return urb.owner == client; });
    if (mine == _done.end())
    {
        umockdev_ioctl_client_complete(client, -1, _plugged ? EAGAIN : ENODEV);
        return TRUE;
    }
    g_autoptr(UMockdevIoctlData) data = umockdev_ioctl_data_resolve(
        umockdev_ioctl_client_get_arg(client), 0, sizeof(void*), nullptr);
    if (data == nullptr) return FALSE;
    umockdev_ioctl_data_set_ptr(data, 0, mine->data);
    umockdev_ioctl_client_complete(client, 0, 0);
    free(*mine);
    _done.erase(mine);
    return TRUE;
}

gboolean EmulatedArray::discard(UMockdevIoctlClient* client)
{
    const gulong address = *reinterpret_cast<gulong*>(umockdev_ioctl_client_get_arg(client)->data);
    for (auto* queue : {&_waitingIn, &_hanging})
        for (auto urb = queue->begin(); urb != queue->end(); ++urb)
            if (urb->owner == client && urb->data->client_addr == address)
            {
                ++discarded;
                if (queue == &_hanging && onDiscarded) onDiscarded(urb->buffer->data);
                finish(*urb, -ENOENT, 0);
                const bool isFirst = queue == &_hanging && urb == _hanging.begin();
                queue->erase(urb);
                if (isFirst) startHanging(); // those behind it go on
                umockdev_ioctl_client_complete(client, 0, 0);
                return TRUE;
            }
    umockdev_ioctl_client_complete(client, -1, EINVAL);
    return TRUE;
}

// umockdev sends an event to every socket that it finds and aborts the program where one has been
// closed since it looked, as that of a libusb context may be at any time. Linked into a program,
// this takes the place of the C library's function, also for umockdev.
extern "C" ssize_t sendmsg(int socket, const msghdr* message, int flags)
{
    static const auto own = reinterpret_cast<decltype(&sendmsg)>(dlsym(RTLD_NEXT, "sendmsg"));
    const ssize_t sent = own(socket, message, flags);
    const bool isRefused = sent < 0 && errno == ECONNREFUSED && message->msg_name != nullptr &&
                           static_cast<const sockaddr*>(message->msg_name)->sa_family == AF_UNIX;
    if (!isRefused) return sent;
    ssize_t size = 0;
    for (std::size_t i = 0; i < message->msg_iovlen; ++i)
        size += static_cast<ssize_t>(message->msg_iov[i].iov_len);
    return size;
}
