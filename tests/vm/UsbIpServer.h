#pragma once

#include "device/VirtualFirmware.h"

#include <atomic>
#include <deque>
#include <thread>
#include <vector>

/// The array as a USB/IP server in user space: the kernel's vhci-hcd is given one end of a socket and enumerates the virtual
/// firmware like a device in a port. Needs root and the module. Source: the kernel's Documentation/usb/usbip_protocol.rst.
class UsbIpServer
{
public:
    explicit UsbIpServer(midair::device::VirtualFirmware& firmware) : _firmware(firmware) {}
    ~UsbIpServer() { unplug(); }

    UsbIpServer(const UsbIpServer&) = delete;
    UsbIpServer& operator=(const UsbIpServer&) = delete;

    bool plug();   ///< false when vhci-hcd doesn't take the socket
    void unplug(); ///< the connection ends, as when a plug is pulled

    static double now_s();

private:
    struct Header
    {
        std::uint32_t command = 0;
        std::uint32_t sequence = 0;
        std::uint32_t direction = 0; ///< 1: IN
        std::uint32_t endpoint = 0;
        std::uint32_t length = 0; ///< of the buffer; of an unlink: which sequence number
        std::uint8_t setup[8] = {};
    };

    void run();
    bool readHeader(Header& header);
    void submit(const Header& header);
    void control(const Header& header, const std::vector<std::uint8_t>& data);
    void answer(const Header& header, int status, const std::uint8_t* data, std::size_t count);
    void unlink(const Header& header);
    void feedIn();

    midair::device::VirtualFirmware& _firmware;
    int _socket = -1;
    std::atomic<bool> _stop{false};
    std::deque<Header> _waitingIn;
    std::thread _thread;
};
