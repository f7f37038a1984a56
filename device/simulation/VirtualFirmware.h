#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/Protocol.h"
#include "haptics/base/threads/Mutex.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace midair::device
{

/// Recent output: drives of any kind with their start times. Keeps output within kKept_s of the
/// newest, at most kMost drives.
template<typename Drive>
class PlayedHistory
{
public:
    static constexpr double kKept_s = 0.11;
    static constexpr std::size_t kMost = 1024; ///< 10,000 a second

    /// Notes that \a drive plays from \a since_s on, which is not before the last.
    void note(double since_s, Drive drive)
    {
        _drives.emplace_back(since_s, std::move(drive));
        const bool isFull = _drives.size() > kMost;
        while (isFull ? _drives.size() > kMost
                      : _drives.size() > 1 && _drives[1].first <= since_s - kKept_s)
            _drives.pop_front();
    }
    const Drive* newest() const { return _drives.empty() ? nullptr : &_drives.back().second; }

    /// Returns the drives that played at \a from_s or later, in order; the first may have begun
    /// before.
    std::vector<std::pair<double, Drive>> since(double from_s) const
    {
        auto first = _drives.begin();
        while (first != _drives.end() && first + 1 != _drives.end() && (first + 1)->first <= from_s)
            ++first;
        return {first, _drives.end()};
    }

private:
    std::deque<std::pair<double, Drive>> _drives;
};

/// Firmware of the array as described in PROTOCOL.md, for `sim:` and for the USB tests. Takes bytes
/// and the time as arguments (seconds from any start, never decreasing), so that tests need not
/// wait. Any thread may call any member.
class VirtualFirmware
{
public:
    /// Kind of simulated device.
    struct Options
    {
        double latency_s = 0; ///< >= 0; from commit to sound
        /// >= 0; maximum number of fields per second; of faster commits the newest wins; 0: no
        /// limit
        double fieldsPerSecond = 0;
        double temperature_C = 35;
        double temperatureLimit_C = 80; ///< mutes above it, until it is 5 degrees below
        std::uint8_t protocolVersion = protocol::kVersion;
        std::uint8_t firmwareMinor = 0; ///< firmware 1.minor.0
        bool hasHistory = false;        ///< playedSince() returns something
    };

    VirtualFirmware(const DeviceLayout& layout, const Options& options);
    explicit VirtualFirmware(const DeviceLayout& layout) : VirtualFirmware(layout, Options()) {}

    /// Receives bytes from the host, split at any place.
    void receive(const std::uint8_t* bytes, std::size_t count, double now_s);
    /// Takes waiting answers to the host, only whole ones, at most \a most bytes.
    std::vector<std::uint8_t> takeAnswer(std::size_t most, double now_s);
    bool hasAnswer(double now_s);

    /// Feeds the watchdog at \a now_s, as KEEPALIVE does; for `sim:`.
    void keptAlive(double now_s);

    DriveSignal playing(double now_s); ///< present field; duties 0 when muted
    /// Returns the output from \a from_s to \a now_s; PlayedHistory limits how much is kept.
    std::vector<std::pair<double, DriveSignal>> playedSince(double from_s, double now_s);
    protocol::Status status(double now_s);
    bool light(int board) const; ///< true if IDENTIFY has turned the board's light on

    void setTemperature(double celsius, double now_s);
    void powerCycle(double now_s); ///< resets everything

private:
    /// The boards of the array.
    struct Boards
    {
        std::vector<int> begin; ///< first transducer of each board, and the end
        std::vector<bool> light;
    };
    /// The incoming field, until it is whole and committed.
    struct BackBuffer
    {
        DriveSignal signal;
        /// Sequence number of each transducer's data; 0: none.
        std::vector<std::uint32_t> stamp;
    };
    /// A committed field, to play at due_s.
    struct Committed
    {
        double due_s;
        DriveSignal signal;
    };
    /// Committed fields that don't play yet.
    struct Commits
    {
        std::deque<Committed> queue;
        double lastDue_s = -1e30;
        std::uint32_t newest = 0; ///< sequence number of the last commit or mute
    };
    /// Mutes when no packet arrives.
    struct Watchdog
    {
        double fed_s = 0;
        double after_s = protocol::kWatchdog_s;
    };

    void advance(double now_s) MIDAIR_REQUIRES(_mutex);
    void handle(const protocol::Packet& packet, double now_s) MIDAIR_REQUIRES(_mutex);
    void greet(const protocol::Packet& packet, double now_s) MIDAIR_REQUIRES(_mutex);
    void store(const protocol::Packet& packet) MIDAIR_REQUIRES(_mutex);
    void commit(const protocol::Packet& packet, double now_s) MIDAIR_REQUIRES(_mutex);
    void mute(std::uint16_t why, double at_s) MIDAIR_REQUIRES(_mutex);
    void note(double since_s) MIDAIR_REQUIRES(_mutex);
    void answerStatus(std::uint32_t sequence) MIDAIR_REQUIRES(_mutex);
    void reset(double now_s) MIDAIR_REQUIRES(_mutex);

    const Options _options;
    const int _transducers;

    mutable base::Mutex _mutex;
    Boards _boards MIDAIR_GUARDED_BY(_mutex);
    protocol::StreamParser _parser MIDAIR_GUARDED_BY(_mutex);
    BackBuffer _back MIDAIR_GUARDED_BY(_mutex);
    Commits _commits MIDAIR_GUARDED_BY(_mutex);
    DriveSignal _front MIDAIR_GUARDED_BY(_mutex); ///< plays
    PlayedHistory<DriveSignal> _history MIDAIR_GUARDED_BY(_mutex);
    std::deque<std::vector<std::uint8_t>> _answers MIDAIR_GUARDED_BY(_mutex);
    protocol::Status _status MIDAIR_GUARDED_BY(_mutex);
    Watchdog _watchdog MIDAIR_GUARDED_BY(_mutex);
    double _temperature_C MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
