#include "device/usb/Protocol.h"

#include "device/ArrayDevice.h"
#include "haptics/base/Bytes.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device::protocol
{

namespace
{

constexpr std::uint8_t kMagic0 = 0x4D; // "MH"
constexpr std::uint8_t kMagic1 = 0x48;
constexpr std::size_t kDataHead = 4; // first, count
constexpr std::size_t kStatusBytes = 28;
constexpr std::size_t kInfoBytes = 24;

void putU16(std::vector<std::uint8_t>& out, std::size_t at, std::size_t value)
{
    out[at] = static_cast<std::uint8_t>(value);
    out[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

// Appends a header with payload length 0, for finish(); returns the packet's offset.
std::size_t begin(std::vector<std::uint8_t>& out,
                  Type type,
                  std::uint16_t board,
                  std::uint32_t sequence,
                  std::uint8_t version = kVersion)
{
    const std::size_t start = out.size();
    base::ByteWriter writer(out);
    writer.u8(kMagic0);
    writer.u8(kMagic1);
    writer.u8(version);
    writer.u8(static_cast<std::uint8_t>(type));
    writer.u16(0);
    writer.u16(board);
    writer.u32(sequence);
    return start;
}

void finish(std::vector<std::uint8_t>& out, std::size_t start)
{
    putU16(out, start + 4, out.size() - start - kHeaderBytes);
    base::ByteWriter(out).u32(base::crc32c(out.data() + start, out.size() - start));
}

/// Writes the members of a packet's payload. Take reads them in the same order.
struct Put
{
    base::ByteWriter& out;

    void operator()(std::uint8_t value) const { out.u8(value); }
    void operator()(std::uint16_t value) const { out.u16(value); }
    void operator()(std::int16_t value) const { out.u16(static_cast<std::uint16_t>(value)); }
    void operator()(std::uint32_t value) const { out.u32(value); }
    void operator()(bool value) const { out.u32(value ? 1 : 0); }
    void skip(int bytes) const
    {
        for (int i = 0; i < bytes; ++i)
            out.u8(0);
    }
    void drives(const Packet& packet) const
    {
        out.u16(static_cast<std::uint16_t>(packet.phases.size()));
        out.bytes(packet.phases.data(), packet.phases.size());
        out.bytes(packet.duties.data(), packet.duties.size());
    }
};

struct Take
{
    base::ByteReader& in;

    void operator()(std::uint8_t& value) const { value = in.u8(); }
    void operator()(std::uint16_t& value) const { value = in.u16(); }
    void operator()(std::int16_t& value) const { value = static_cast<std::int16_t>(in.u16()); }
    void operator()(std::uint32_t& value) const { value = in.u32(); }
    void operator()(bool& value) const { value = in.u32() != 0; }
    void skip(std::size_t bytes) const { in.bytes(bytes); }
    void drives(Packet& packet) const
    {
        const std::size_t count = in.u16();
        const std::uint8_t* phases = in.bytes(count);
        const std::uint8_t* duties = in.bytes(count);
        if (!in.ok()) return;
        packet.phases.assign(phases, phases + count);
        packet.duties.assign(duties, duties + count);
    }
};

/// Members of a payload. \a field: Put or Take.
template<typename Field, typename P>
void eachField(const Field& field, P& packet)
{
    auto& status = packet.status;
    auto& info = packet.info;
    switch (packet.type)
    {
    case Type::HELLO:
        field(packet.nonce);
        field(packet.watchdog_ms);
        field.skip(2);
        break;
    case Type::DATA:
        field(packet.first);
        field.drives(packet);
        break;
    case Type::COMMIT:
        field(packet.transducers);
        break;
    case Type::IDENTIFY:
        field(packet.light);
        break;
    case Type::STATUS:
        field(status.lastPlayed);
        field(status.flags);
        field(status.temperature_dC);
        for (auto* count : {&status.played,
                            &status.stale,
                            &status.incomplete,
                            &status.badPackets,
                            &status.watchdogs})
            field(*count);
        break;
    case Type::INFO:
        for (auto* part : {&info.firmwareMajor, &info.firmwareMinor, &info.firmwarePatch})
            field(*part);
        field.skip(1);
        field(info.boards);
        field.skip(2);
        field(info.transducers);
        for (auto* number :
             {&info.phaseLevels, &info.dutyLevels, &info.watchdog_ms, &info.fieldsPerSecond})
            field(*number);
        field(info.nonce);
        break;
    case Type::MUTE:
    case Type::KEEPALIVE:
    case Type::GET_STATUS:
        break;
    }
}

// Returns true if a payload of the type may have this length; detects garbage by its first 12
// bytes.
bool lengthFits(Type type, std::size_t length)
{
    switch (type)
    {
    case Type::HELLO:
        return length == 8;
    case Type::DATA:
        return length > kDataHead && length % 2 == 0 && length <= kDataHead + 2 * kMostInPacket;
    case Type::COMMIT:
    case Type::IDENTIFY:
        return length == 4;
    case Type::MUTE:
    case Type::KEEPALIVE:
    case Type::GET_STATUS:
        return length == 0;
    case Type::STATUS:
        return length == kStatusBytes;
    case Type::INFO:
        return length == kInfoBytes;
    }
    return false;
}

} // namespace

std::string Info::firmware() const
{
    return fmt::format("{}.{}.{}", firmwareMajor, firmwareMinor, firmwarePatch);
}

void append(std::vector<std::uint8_t>& out, const Packet& packet)
{
    const std::size_t start =
        begin(out, packet.type, packet.board, packet.sequence, packet.version);
    base::ByteWriter writer(out);
    eachField(Put{writer}, packet);
    finish(out, start);
}

std::vector<Range> ranges(const DeviceLayout& layout)
{
    std::vector<Range> cut;
    int boardBegin = 0;
    for (int i = 0; i < layout.transducers; ++i)
    {
        const int board = layout.board.empty() ? 0 : layout.board[i];
        const bool newBoard = i > 0 && board != cut.back().board;
        if (newBoard) boardBegin = i;
        if (i == 0 || newBoard || cut.back().count == kMostInPacket)
            cut.push_back({static_cast<std::uint16_t>(board),
                           static_cast<std::uint16_t>(i - boardBegin),
                           0,
                           i});
        ++cut.back().count;
    }
    return cut;
}

void appendData(std::vector<std::uint8_t>& out,
                const DriveSignal& signal,
                const std::vector<Range>& ranges,
                std::uint32_t sequence)
{
    for (const Range& range : ranges)
    {
        const std::size_t start = begin(out, Type::DATA, range.board, sequence);
        base::ByteWriter writer(out);
        writer.u16(range.first);
        writer.u16(range.count);
        writer.bytes(signal.phase.data() + range.offset, range.count);
        writer.bytes(signal.duty.data() + range.offset, range.count);
        finish(out, start);
    }
}

void appendCommit(std::vector<std::uint8_t>& out, int transducers, std::uint32_t sequence)
{
    const std::size_t start = begin(out, Type::COMMIT, kAllBoards, sequence);
    base::ByteWriter(out).u32(static_cast<std::uint32_t>(transducers));
    finish(out, start);
}

void appendField(std::vector<std::uint8_t>& out,
                 const DriveSignal& signal,
                 const std::vector<Range>& ranges,
                 std::uint32_t sequence)
{
    appendData(out, signal, ranges, sequence);
    appendCommit(out, signal.size(), sequence);
}

void StreamParser::push(const std::uint8_t* bytes, std::size_t count)
{
    if (_begin > 0 && _begin == _bytes.size()) clear();
    _bytes.insert(_bytes.end(), bytes, bytes + count);
}

void StreamParser::clear()
{
    _bytes.clear();
    _begin = 0;
}

StreamParser::Result StreamParser::parse(std::size_t& used, Packet& packet) const
{
    const std::uint8_t* data = _bytes.data() + _begin;
    const std::size_t size = _bytes.size() - _begin;
    if (data[0] != kMagic0 || (size > 1 && data[1] != kMagic1)) return Result::BAD;
    if (size < kHeaderBytes) return Result::MORE;
    base::ByteReader in(data + 2, kHeaderBytes - 2);
    const std::uint8_t version = in.u8();
    const Type type = static_cast<Type>(in.u8());
    const std::size_t length = in.u16();
    // Other versions may have other packets, but HELLO and INFO stay the same, so that both sides
    // can report the difference.
    const bool greeting = type == Type::HELLO || type == Type::INFO;
    if (!lengthFits(type, length) || (version != kVersion && !greeting)) return Result::BAD;
    const std::size_t whole = kHeaderBytes + length + kCrcBytes;
    if (size < whole) return Result::MORE;
    if (base::ByteReader(data + whole - kCrcBytes, kCrcBytes).u32() !=
        base::crc32c(data, whole - kCrcBytes))
        return Result::BAD;
    Packet read;
    read.version = version;
    read.type = type;
    read.board = in.u16();
    read.sequence = in.u32();
    base::ByteReader payload(data + kHeaderBytes, length);
    eachField(Take{payload}, read);
    if (!payload.ok() || payload.left() != 0) return Result::BAD;
    packet = std::move(read);
    used = whole;
    return Result::PACKET;
}

bool StreamParser::next(Packet& packet)
{
    while (_begin < _bytes.size())
    {
        std::size_t used = 0;
        const Result result = parse(used, packet);
        if (result == Result::PACKET)
        {
            _begin += used;
            _skipping = false;
            return true;
        }
        if (result == Result::MORE) break;
        if (!_skipping) ++_bad;
        _skipping = true;
        const auto* from = _bytes.data() + _begin + 1;
        const auto* end = _bytes.data() + _bytes.size();
        _begin = static_cast<std::size_t>(std::find(from, end, kMagic0) - _bytes.data());
    }
    // At most the start of one packet is left, so this copies little.
    _bytes.erase(_bytes.begin(), _bytes.begin() + static_cast<std::ptrdiff_t>(_begin));
    _begin = 0;
    return false;
}

} // namespace midair::device::protocol
