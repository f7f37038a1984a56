#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/boards/BoardCodec.h"
#include "device/simulation/VirtualBoard.h"
#include "device/simulation/VirtualFirmware.h"
#include "device/usb/Protocol.h"

#include <limits>
#include <mutex>
#include <random>

namespace midair::device
{

class DeviceUri;

/// `sim:`: the bytes that hardware would get go to a virtual firmware, and played() is what that
/// makes of them.
///
/// Faults can be asked for in the URI: `drop` and `corrupt` (probability a packet), `seed`,
/// `latency`, `fps`, `unplug_at`, `replug_at`, `hang_at` (the host stops talking, so the watchdog
/// mutes), all times since opening; `board` chooses the protocol of an open board instead of our
/// own.
class SimulatedArray : public ArrayDevice
{
public:
    struct Options
    {
        double drop = 0;
        double corrupt = 0;
        unsigned seed = 1;
        double unplugAt_s = std::numeric_limits<double>::infinity();
        double replugAt_s = std::numeric_limits<double>::infinity();
        double hangAt_s = std::numeric_limits<double>::infinity();
        std::string board; ///< BoardCodec's name; empty: our own protocol
        VirtualFirmware::Options firmware;
    };
    static Options takeOptions(DeviceUri& uri);

    /// Throws DeviceError when the board is unknown or has another number of transducers.
    SimulatedArray(const DeviceLayout& layout, const Options& options);
    ~SimulatedArray() override;

    SimulatedArray(const SimulatedArray&) = delete;
    SimulatedArray& operator=(const SimulatedArray&) = delete;

    bool send(const DriveSignal& signal) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override;
    bool identify(int board, bool light) override;
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    double advance() const; ///< with _mutex held; gives the time
    bool sendPackets(const DriveSignal& signal, double now_s);
    void deliver(double now_s); ///< _bytes, less what faults take
    void silenceLocked(double now_s);
    bool unplugged(double now_s) const
    {
        return now_s >= _options.unplugAt_s && now_s < _options.replugAt_s;
    }

    const DeviceLayout _layout;
    const Options _options;
    const std::vector<protocol::Range> _ranges;
    const double _start_s;
    const std::unique_ptr<BoardCodec> _codec;
    mutable std::mutex _mutex;
    mutable VirtualFirmware _firmware;
    const std::unique_ptr<VirtualBoard> _board;
    std::vector<std::uint8_t> _bytes;
    mutable FieldCounters _counters;
    mutable bool _lost = false;
    mutable bool _unplugged = false;      ///< has been, once
    mutable std::uint32_t _watchdogs = 0; ///< counted as faults
    std::uint32_t _sequence = 0;
    std::minstd_rand _random;
};

} // namespace midair::device
