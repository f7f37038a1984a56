#pragma once

#include "device/autd3/protocol/Commands.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::device::autd3
{

constexpr std::uint8_t kProtocolVersion = 2;
constexpr std::uint16_t kPort = 44336; ///< that units listen on
constexpr std::uint8_t kNoId = 0xFF;
constexpr std::size_t kMostReplyData = 40; ///< bytes of a frame reply after its fixed part

/// Kinds of datagrams; an answer has that of its question.
enum class Kind : std::uint8_t
{
    FRAME = 0,
    READ_UNIT_INFO = 1,
    RESET_ID = 2,
    DISCOVER = 3,
    ASSIGN_ID = 4,
    UNBLOCK_DOWNSTREAM = 5,
    SET_TIME = 6,
    HEARTBEAT = 7
};

/// Bits of the flags in unit infos and frame replies.
enum UnitFlags : std::uint8_t
{
    HAS_ID = 1,
    PASSES_ON = 2,
    HAS_DOWNSTREAM = 4, ///< when it was opened
    HAS_SYNC_PULSE = 8,
    FOLLOWS_CLOCK = 16,
    IS_GRANDMASTER = 32
};

/// Bits of the answer to Command::readFpgaState().
enum FpgaState : std::uint8_t
{
    IS_HOT = 0x01,
    PATTERN_BANK = 0x04,
    SWITCH_WAITS = 0x40,
    FAILSAFE = 0x80
};

/// Results of commands that the driver distinguishes.
enum Result : std::uint8_t
{
    DONE = 0x00,
    TOO_NEAR = 0x06,
    NO_SYNC_PULSE = 0x08,
    FAILSAFE_LASTS = 0x15
};

// Datagrams to units. \a number: repeated in the answer.

std::vector<std::uint8_t> message(Kind kind, std::uint16_t number);
std::vector<std::uint8_t> assignId(std::uint16_t number, std::uint8_t id, bool isGrandmaster);
std::vector<std::uint8_t> setTime(std::uint16_t number, std::uint64_t time_ns);
std::vector<std::uint8_t>
frame(std::uint16_t number, std::uint8_t sequence, const Command& command);

/// A firmware version, "0.10.0".
struct FirmwareVersion
{
    std::uint8_t major = 0;
    std::uint8_t minor = 0;
    std::uint8_t patch = 0;

    std::string text() const;
};

/// Self-description of a unit.
struct UnitInfo
{
    std::uint8_t id = kNoId;
    std::uint8_t flags = 0;
    FirmwareVersion firmware;
    std::uint64_t time_ns = 0;
};

/// A unit's answer to a frame or heartbeat: the result of the last frame done in sequence, whatever
/// was asked. A heartbeat after a read thus also returns the read's data.
struct FrameReply
{
    std::uint8_t acknowledged = 0; ///< last frame done in sequence
    std::uint8_t result = 0;       ///< of that frame
    std::uint8_t flags = 0;
    std::uint8_t id = kNoId;
    std::uint64_t time_ns = 0;
    std::vector<std::uint8_t> data; ///< of that frame, if it was a read; at most kMostReplyData
};

/// A datagram from a unit. Its kind determines the valid members.
struct Answer
{
    std::uint8_t version = kProtocolVersion;
    Kind kind = Kind::FRAME;
    std::uint16_t number = 0;
    std::uint8_t status = 0;    ///< 0: done, and the data is present
    bool hasDownstream = false; ///< of UNBLOCK_DOWNSTREAM
    UnitInfo info;              ///< of READ_UNIT_INFO
    FrameReply reply;           ///< of FRAME and HEARTBEAT
};

/// Parses an answer. Returns false, with the reason in \a error and nothing else changed, if it is
/// too short, of another kind or of the wrong length. An answer of another protocol version is
/// valid (status 1, \a answer.version is the unit's).
bool readAnswer(const std::vector<std::uint8_t>& bytes, Answer& answer, std::string& error);

/// Versions in the answer to Command::readFirmware().
struct FirmwareInfo
{
    FirmwareVersion cpu;
    FirmwareVersion fpga;
    bool isEmulator = false;
};
bool readFirmwareInfo(const std::vector<std::uint8_t>& data, FirmwareInfo& info);

/// Returns "a time that is past or too soon (06)": the result of a command, for messages.
std::string resultText(std::uint8_t result);
/// Returns "it has no id (2)": the status of an answer, for messages.
std::string statusText(std::uint8_t status);

} // namespace midair::device::autd3
