#pragma once

#include <memory>
#include <string>

#include <umockdev.h>

// The emulated bus: where the device in a port is found, and the bed that all of them share.

inline int numberOf(int port)
{
    return 4 + port;
}

inline std::string nodeOf(int port)
{
    return "/dev/bus/usb/001/00" + std::to_string(numberOf(port));
}

inline std::string sysPathOf(int port)
{
    return "/sys/devices/pci0000:00/usb1/1-" + std::to_string(port);
}

inline std::string serialOf(int port)
{
    return "A000" + std::to_string(port);
}

/// The device as umockdev takes it; \a descriptors in hexadecimal.
inline std::string recordText(const std::string& descriptors, int port)
{
    const std::string number = std::to_string(numberOf(port));
    return "P: " + sysPathOf(port).substr(4) + "\nN: " + nodeOf(port).substr(5) + "=" +
           descriptors + "\nE: DEVNAME=" + nodeOf(port) +
           "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nE: BUSNUM=001\nE: DEVNUM=00" + number +
           "\nE: MAJOR=189\nE: MINOR=" + std::to_string(numberOf(port) - 1) +
           "\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum=" + number +
           "\\n\nA: speed=480\\n\nH: descriptors=" + descriptors + "\n";
}

/// umockdev knows one bed at a time.
inline std::shared_ptr<UMockdevTestbed> theTestbed()
{
    static std::weak_ptr<UMockdevTestbed> current;
    std::shared_ptr<UMockdevTestbed> testbed = current.lock();
    if (testbed == nullptr) testbed.reset(umockdev_testbed_new(), g_object_unref);
    current = testbed;
    return testbed;
}
