#pragma once

#include <string>

struct libusb_device;
struct libusb_device_handle;

namespace midair::device
{

/// The path of the device's usbfs file, such as "/dev/bus/usb/001/005".
std::string nodeOf(libusb_device* device);

/// The file descriptor with which libusb holds \a interface of an open device, or -1 if none is
/// found. libusb still owns it.
int descriptorOf(libusb_device_handle* handle, unsigned interface);

} // namespace midair::device
