#include "device/usb/UsbNode.h"

#include <libusb.h>

#include <cstdlib>
#include <memory>

#include <dirent.h>
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

namespace midair::device
{

std::string nodeOf(libusb_device* device)
{
    return fmt::format("/dev/bus/usb/{:03}/{:03}",
                       libusb_get_bus_number(device),
                       libusb_get_device_address(device));
}

// libusb doesn't return it. Another thread may have the same device open for a moment, to read its
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

} // namespace midair::device
