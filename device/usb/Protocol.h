#pragma once

#include "device/SequenceNumber.h"
#include "device/drive/DriveSignal.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::device
{

struct DeviceLayout;

/// Wire format of the array, as pure functions: bytes <-> packets. PROTOCOL.md describes it for
/// firmware authors.
namespace protocol
{

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kCrcBytes = 4;
constexpr std::uint16_t kAllBoards = 0xFFFF;
constexpr int kMostInPacket = 1024;            ///< transducers in one DATA packet
constexpr double kWatchdog_s = 0.1;            ///< the device mutes without a packet for this time
constexpr double kKeepAliveInterval_s = 0.025; ///< three may be lost before the watchdog mutes

/// The type of a packet.
enum class Type : std::uint8_t
{
    HELLO = 0x01,     ///< starts a session: mutes, forgets sequence numbers; answered by INFO
    DATA = 0x02,      ///< phases and duties of a range of one board, into its back buffer
    COMMIT = 0x03,    ///< all boards swap at once, if the field is complete; answered by STATUS
    MUTE = 0x04,      ///< all transducers off at once; fields up to its sequence number never play;
                      ///< answered by STATUS
    KEEPALIVE = 0x05, ///< feeds the watchdog
    GET_STATUS = 0x06, ///< answered by STATUS
    IDENTIFY = 0x07,   ///< turns the board's light on or off
    STATUS = 0x81,
    INFO = 0x82
};

/// The device's description of itself.
struct Info
{
    std::uint8_t firmwareMajor = 0;
    std::uint8_t firmwareMinor = 0;
    std::uint8_t firmwarePatch = 0;
    std::uint16_t boards = 0;
    std::uint32_t transducers = 0;
    std::uint16_t phaseLevels = 256;
    std::uint16_t dutyLevels = 256;
    std::uint16_t watchdog_ms = 100;
    std::uint16_t fieldsPerSecond = 0; ///< the most that it plays
    std::uint32_t nonce = 0;           ///< that of the HELLO

    std::string firmware() const; ///< "1.2.3"
};

/// Bits of Status::flags.
enum StatusFlags : std::uint16_t
{
    PLAYING = 1,          ///< a field is played
    MUTED = 2,            ///< since the last MUTE no field has been committed
    WATCHDOG_FIRED = 4,   ///< muted because no packets came from the host
    OVER_TEMPERATURE = 8, ///< muted because it is too hot
    BOARD_FAULT = 16      ///< a board doesn't answer
};

/// State and counters of the device; sent after each COMMIT, MUTE and GET_STATUS and when the
/// watchdog or the temperature mutes. The packet's sequence number is that of the COMMIT or MUTE
/// that it answers, else 0.
struct Status
{
    /// sequence number of the last committed field; 0: none in this session
    std::uint32_t lastPlayed = 0;
    std::uint16_t flags = 0;         ///< StatusFlags
    std::int16_t temperature_dC = 0; ///< tenths of a degree Celsius
    std::uint32_t played = 0;     ///< commits that swapped, since power-on; like all counters below
    std::uint32_t stale = 0;      ///< commits dropped as not newer than the last field or mute
    std::uint32_t incomplete = 0; ///< commits refused because of missing data
    /// bytes that are no packet (counted once per gap), or with wrong CRC or contents
    std::uint32_t badPackets = 0;
    std::uint32_t watchdogs = 0; ///< times the watchdog muted
};

/// One parsed packet. Its type determines the members in use.
struct Packet
{
    Type type = Type::KEEPALIVE;
    std::uint16_t board = kAllBoards;
    std::uint32_t sequence = 0;

    /// the sender's protocol version; only HELLO and INFO may have another than kVersion
    std::uint8_t version = kVersion;
    std::uint32_t nonce = 0;          ///< HELLO
    std::uint16_t watchdog_ms = 100;  ///< HELLO
    std::uint16_t first = 0;          ///< DATA: first transducer within the board
    std::vector<std::uint8_t> phases; ///< DATA
    std::vector<std::uint8_t> duties; ///< DATA, as long
    std::uint32_t transducers = 0;    ///< COMMIT: number of transducers of the field
    bool light = false;               ///< IDENTIFY
    Status status;                    ///< STATUS
    Info info;                        ///< INFO
};

/// Appends one packet.
void append(std::vector<std::uint8_t>& out, const Packet& packet);

/// Part of a field in one DATA packet.
struct Range
{
    std::uint16_t board = 0;
    std::uint16_t first = 0; ///< within the board
    std::uint16_t count = 0;
    int offset = 0; ///< within the field
};
/// Splits a field into DATA packets: boards ascending, each in ranges of at most kMostInPacket.
std::vector<Range> ranges(const DeviceLayout& layout);

/// Appends all DATA packets of a field, or its COMMIT; doesn't allocate once \a out is large
/// enough.
void appendData(std::vector<std::uint8_t>& out,
                const DriveSignal& signal,
                const std::vector<Range>& ranges,
                std::uint32_t sequence);
void appendCommit(std::vector<std::uint8_t>& out, int transducers, std::uint32_t sequence);

/// Appends all DATA packets and the COMMIT.
void appendField(std::vector<std::uint8_t>& out,
                 const DriveSignal& signal,
                 const std::vector<Range>& ranges,
                 std::uint32_t sequence);

using device::newer; // sequence numbers

/// Splits a byte stream into packets. Skips and counts bytes that are no packet, and finds the next
/// whole packet after them, however the bytes are split into transfers.
class StreamParser
{
public:
    void push(const std::uint8_t* bytes, std::size_t count);
    bool next(Packet& packet); ///< takes the next packet; false: no whole one is left
    std::uint32_t badPackets() const { return _bad; }
    void clear(); ///< drops an incomplete packet, keeps the counter

private:
    enum class Result
    {
        PACKET,
        MORE, ///< valid so far, but incomplete
        BAD
    };
    Result parse(std::size_t& used, Packet& packet) const;

    std::vector<std::uint8_t> _bytes;
    std::size_t _begin = 0;
    bool _skipping = false;
    std::uint32_t _bad = 0;
};

} // namespace protocol

} // namespace midair::device
