#pragma once

#include <string>

struct libusb_device;
struct libusb_device_handle;

namespace midair::device
{

/// The file of usbfs that is this device, such as "/dev/bus/usb/001/005".
std::string nodeOf(libusb_device* device);

/// The descriptor by which libusb holds \a interface of an open device, or -1 where none is found.
/// It stays libusb's.
int descriptorOf(libusb_device_handle* handle, unsigned interface);

} // namespace midair::device
