#include "device/autd3/protocol/Messages.h"

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr std::size_t kHeaderBytes = 4;
constexpr std::size_t kInfoBytes = 20;  // after the status
constexpr std::size_t kReplyBytes = 12; // after the header
constexpr std::uint8_t kVersionNotSpoken = 1;

std::uint64_t number(const std::uint8_t* bytes, int count)
{
    std::uint64_t value = 0;
    for (int i = count; i-- > 0;)
        value = (value << 8) | bytes[i];
    return value;
}

FirmwareVersion version(const std::uint8_t* bytes)
{
    return {bytes[0], bytes[1], bytes[2]};
}

void append(std::vector<std::uint8_t>& bytes, std::uint64_t value, int count)
{
    for (int i = 0; i < count; ++i)
        bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

bool isReply(Kind kind)
{
    return kind == Kind::FRAME || kind == Kind::HEARTBEAT;
}

void readInfo(const std::uint8_t* body, UnitInfo& info)
{
    info.id = body[0];
    info.flags = body[1];
    info.firmware = version(body + 4);
    info.time_ns = number(body + 8, 8);
}

void readReply(const std::uint8_t* body, std::size_t size, FrameReply& reply)
{
    reply.acknowledged = body[0];
    reply.result = body[1];
    reply.flags = body[2];
    reply.id = body[3];
    reply.time_ns = number(body + 4, 8);
    reply.data.assign(body + kReplyBytes, body + size);
}

// The length after the header depends on kind and status.
bool readBody(const std::uint8_t* body, std::size_t size, Answer& answer, std::string& error)
{
    bool fits = false;
    answer.status = size > 0 ? body[0] : 0;
    if (answer.version != kProtocolVersion)
        fits = size >= 1 && answer.status == kVersionNotSpoken;
    else if (isReply(answer.kind))
    {
        fits = size >= kReplyBytes && size <= kReplyBytes + kMostReplyData;
        if (fits) readReply(body, size, answer.reply);
        if (fits)
            answer.status = 0;
        else
            fits = size == 1 && answer.status != 0; // refused as a message, not as a command
    }
    else if (answer.status != 0)
        fits = size >= 1;
    else if (answer.kind == Kind::READ_UNIT_INFO) // newer firmware may add data
    {
        fits = size >= 1 + kInfoBytes;
        if (fits) readInfo(body + 1, answer.info);
    }
    else if (answer.kind == Kind::UNBLOCK_DOWNSTREAM)
    {
        fits = size == 2 && body[1] <= 1;
        answer.hasDownstream = fits && body[1] == 1;
    }
    else
        fits = size == 1;
    if (!fits)
        error = fmt::format("an answer of kind {}, version {}, with {} bytes after its header",
                            static_cast<int>(answer.kind),
                            answer.version,
                            size);
    return fits;
}

} // namespace

std::vector<std::uint8_t> message(Kind kind, std::uint16_t number)
{
    std::vector<std::uint8_t> bytes = {kProtocolVersion, static_cast<std::uint8_t>(kind)};
    append(bytes, number, 2);
    return bytes;
}

std::vector<std::uint8_t> assignId(std::uint16_t number, std::uint8_t id, bool isGrandmaster)
{
    std::vector<std::uint8_t> bytes = message(Kind::ASSIGN_ID, number);
    bytes.push_back(id);
    bytes.push_back(isGrandmaster ? 1 : 0);
    return bytes;
}

std::vector<std::uint8_t> setTime(std::uint16_t number, std::uint64_t time_ns)
{
    std::vector<std::uint8_t> bytes = message(Kind::SET_TIME, number);
    append(bytes, time_ns, 8);
    return bytes;
}

std::vector<std::uint8_t> frame(std::uint16_t number, std::uint8_t sequence, const Command& command)
{
    std::vector<std::uint8_t> bytes = message(Kind::FRAME, number);
    bytes.push_back(sequence);
    bytes.insert(bytes.end(), command.bytes().begin(), command.bytes().end());
    return bytes;
}

std::string FirmwareVersion::text() const
{
    return fmt::format("{}.{}.{}", major, minor, patch);
}

bool readAnswer(const std::vector<std::uint8_t>& bytes, Answer& answer, std::string& error)
{
    if (bytes.size() < kHeaderBytes)
    {
        error = fmt::format("{} bytes, less than a header", bytes.size());
        return false;
    }
    if (bytes[1] > static_cast<std::uint8_t>(Kind::HEARTBEAT))
    {
        error = fmt::format("unknown kind {}", bytes[1]);
        return false;
    }
    Answer read;
    read.version = bytes[0];
    read.kind = static_cast<Kind>(bytes[1]);
    read.number = static_cast<std::uint16_t>(number(bytes.data() + 2, 2));
    if (!readBody(bytes.data() + kHeaderBytes, bytes.size() - kHeaderBytes, read, error))
        return false;
    answer = std::move(read);
    return true;
}

bool readFirmwareInfo(const std::vector<std::uint8_t>& data, FirmwareInfo& info)
{
    constexpr std::size_t kBytes = 8;
    if (data.size() != kBytes) return false;
    info.cpu = version(data.data());
    info.fpga = version(data.data() + 3);
    info.isEmulator = (data[6] & 0x80) != 0;
    return true;
}

std::string resultText(std::uint8_t result)
{
    const char* text = "a fault";
    switch (result)
    {
    case 0x00:
        text = "done";
        break;
    case 0x01:
        text = "an unknown command";
        break;
    case 0x02:
        text = "an invalid payload";
        break;
    case 0x04:
        text = "forbidden by its silencer";
        break;
    case 0x05:
        text = "a switch of the wrong kind for this bank";
        break;
    case 0x06:
        text = "a time that is past or too soon";
        break;
    case 0x07:
        text = "its FPGA doesn't answer";
        break;
    case 0x08:
        text = "it has no sync pulse yet";
        break;
    case 0x14:
        text = "it missed the sync pulse";
        break;
    case 0x15:
        text = "the cause of its fail-safe persists";
        break;
    default:
        break;
    }
    return fmt::format("{} ({:02X})", text, result);
}

std::string statusText(std::uint8_t status)
{
    const char* text = "refused";
    switch (status)
    {
    case 0:
        text = "done";
        break;
    case 1:
        text = "an unsupported protocol version";
        break;
    case 2:
        text = "it has no id";
        break;
    case 3:
        text = "an invalid body";
        break;
    case 4:
        text = "it isn't the grandmaster";
        break;
    default:
        break;
    }
    return fmt::format("{} ({})", text, status);
}

} // namespace midair::device::autd3
