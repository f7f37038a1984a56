#include "device/ArrayDevice.h"
#include "device/usb/UsbNode.h"
#include "device/usb/UsbTransferPool.h"

#include <libusb.h>

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

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

/// The list of devices that are plugged in now; the destructor frees it.
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
