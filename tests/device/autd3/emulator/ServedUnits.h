#pragma once

#include "device/autd3/emulator/UdpUnits.h"

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include <fmt/format.h>

/// Emulated units behind ports of this machine, served by a thread: what they do comes of the
/// datagrams that their sockets get. Throws DeviceError where there is no ::1.
class ServedUnits
{
public:
    explicit ServedUnits(int units) : _number(units), _units(optionsOf(units), 0)
    {
        _server = std::thread([this] { serve(); });
    }
    ~ServedUnits()
    {
        _ends = true;
        _server.join();
    }
    ServedUnits(const ServedUnits&) = delete;
    ServedUnits& operator=(const ServedUnits&) = delete;

    std::string uri() const
    {
        return fmt::format("autd3:?units={}&group=[::1]:{}", _number, _units.port());
    }
    midair::device::DriveSignal field()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _units.chain().field(midair::device::emulation::UdpUnits::now_ns());
    }
    midair::device::emulation::ChainReport report()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _units.chain().report(midair::device::emulation::UdpUnits::now_ns());
    }

private:
    static midair::device::emulation::ChainOptions optionsOf(int units)
    {
        midair::device::emulation::ChainOptions options;
        options.units = units;
        options.tolerance_ns = midair::device::emulation::kMillisecond_ns;
        return options;
    }
    void serve()
    {
        while (!_ends)
        {
            {
                const std::lock_guard<std::mutex> lock(_mutex);
                _units.run(midair::device::emulation::UdpUnits::now_ns() +
                           midair::device::emulation::kMillisecond_ns);
            }
            std::this_thread::yield();
        }
    }

    const int _number;
    midair::device::emulation::UdpUnits _units;
    std::mutex _mutex;
    std::atomic<bool> _ends{false};
    std::thread _server;
};
