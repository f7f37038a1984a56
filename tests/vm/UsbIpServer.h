#pragma once

#include "device/simulation/VirtualFirmware.h"

#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

/// A device as a USB/IP server in user space: the kernel's vhci-hcd is given one end of a socket
/// and enumerates it like a device in a port. Needs root and the module. Source: the kernel's
/// Documentation/usb/usbip_protocol.rst.
class UsbIpServer
{
public:
    using Take = std::function<void(const std::uint8_t*, std::size_t)>;

    /// The array, in the first port.
    explicit UsbIpServer(midair::device::VirtualFirmware& firmware);
    /// An FT232H, in the second port, which hands what it is sent to \a take, on a thread of its
    /// own.
    explicit UsbIpServer(Take take);
    ~UsbIpServer() { unplug(); }

    UsbIpServer(const UsbIpServer&) = delete;
    UsbIpServer& operator=(const UsbIpServer&) = delete;

    bool plug();   ///< false when vhci-hcd doesn't take the socket
    void unplug(); ///< the connection ends, as when a plug is pulled

    void hold();        ///< what is sent from here on stays in flight ..
    void letGo();       ///< .. until now
    std::size_t held(); ///< transfers in flight
    int unlinkedHeld(); ///< transfers in flight that the kernel has taken back

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
    void receive(const Header& header, const std::vector<std::uint8_t>& data);
    void control(const Header& header, const std::vector<std::uint8_t>& data);
    void answer(const Header& header, int status, const std::uint8_t* data, std::size_t count);
    void unlink(const Header& header);
    void feedIn();

    struct Held
    {
        Header header;
        std::vector<std::uint8_t> data;
    };

    midair::device::VirtualFirmware* const _firmware = nullptr; ///< the array's
    const Take _take;
    std::mutex _mutex; ///< what is below, up to the socket, and sending on that
    bool _holding = false;
    std::deque<Held> _held;
    int _unlinkedHeld = 0;
    int _socket = -1;
    std::atomic<bool> _stop{false};
    std::deque<Header> _waitingIn;
    std::thread _thread;
};
