#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/Protocol.h"

#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

namespace midair::device
{

/// The array's firmware as PROTOCOL.md describes it, fed with bytes and with the time: what `sim:`
/// plays, and the peer of the USB tests. Time is an argument (seconds from any start, never
/// backwards), so tests need not wait. Calls from any thread.
class VirtualFirmware
{
public:
    struct Options
    {
        double latency_s = 0; ///< from commit to sound
        double fieldsPerSecond =
            0; ///< most that it swaps; the newest commit of those too fast wins; 0: no limit
        double temperature_C = 35;
        double temperatureLimit_C = 80; ///< mutes above, until 5 degrees below
        std::uint8_t protocolVersion = protocol::kVersion;
        std::uint8_t firmwareMinor = 0; ///< firmware 1.minor.0
    };

    VirtualFirmware(const DeviceLayout& layout, const Options& options);
    explicit VirtualFirmware(const DeviceLayout& layout) : VirtualFirmware(layout, Options()) {}

    /// Bytes from the host, cut anyhow.
    void receive(const std::uint8_t* bytes, std::size_t count, double now_s);
    /// Whole answers waiting for the host, at most \a most bytes; an answer is never cut.
    std::vector<std::uint8_t> takeAnswer(std::size_t most, double now_s);
    bool hasAnswer(double now_s);

    /// The host talked until \a now_s without sending anything that matters; as KEEPALIVE does, for
    /// `sim:`.
    void keptAlive(double now_s);

    DriveSignal playing(double now_s); ///< duties 0 when muted
    protocol::Status status(double now_s);
    bool light(int board) const; ///< IDENTIFY's

    void setTemperature(double celsius, double now_s);
    void powerCycle(double now_s); ///< forgets all

private:
    struct Committed
    {
        double due_s;
        DriveSignal signal;
    };

    void advance(double now_s);
    void handle(const protocol::Packet& packet, double now_s);
    void store(const protocol::Packet& packet);
    void commit(const protocol::Packet& packet, double now_s);
    void mute(std::uint16_t why);
    void answerStatus(std::uint32_t sequence);
    void reset();

    const Options _options;
    const int _transducers;
    std::vector<int> _boardBegin; ///< first transducer of each board, and the end
    mutable std::mutex _mutex;
    protocol::StreamParser _parser;
    DriveSignal _back;
    std::vector<std::uint32_t>
        _stamp; ///< sequence number that each transducer of the back buffer came with; 0: none
    DriveSignal _front;
    std::deque<Committed> _queue;
    std::deque<std::vector<std::uint8_t>> _answers;
    protocol::Status _status;
    std::uint32_t _newest = 0; ///< sequence number of the last commit or mute
    double _lastPacket_s = 0;
    double _lastDue_s = -1e30;
    double _watchdog_s = protocol::kWatchdog_s;
    double _temperature_C;
    std::vector<bool> _light;
};

} // namespace midair::device
