#include "device/recording/Recording.h"

#include "device/ArrayDevice.h"
#include "haptics/base/Bytes.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace midair::device::recording
{

namespace
{

constexpr std::size_t kRecordHeaderBytes = 16;
constexpr std::size_t kCrcBytes = 4;

/// The coding of the phases or duties of a field, see Recording.h.
enum Coding : std::uint8_t
{
    RAW = 0,
    CONSTANT = 1,
    SAME = 2
};

Coding chooseCoding(const std::vector<std::uint8_t>& now, const std::vector<std::uint8_t>& before)
{
    if (now == before) return SAME;
    return std::all_of(now.begin(), now.end(), [&](std::uint8_t value) { return value == now[0]; })
               ? CONSTANT
               : RAW;
}

void putPlane(base::ByteWriter& out, Coding coding, const std::vector<std::uint8_t>& plane)
{
    if (coding != SAME) out.bytes(plane.data(), coding == RAW ? plane.size() : 1);
}

bool takePlane(base::ByteReader& in, std::uint8_t coding, std::vector<std::uint8_t>& plane)
{
    if (coding == SAME) return true;
    const std::uint8_t* bytes = in.bytes(coding == RAW ? plane.size() : 1);
    if (bytes == nullptr || coding > SAME) return false;
    if (coding == RAW)
        std::copy(bytes, bytes + plane.size(), plane.begin());
    else
        std::fill(plane.begin(), plane.end(), *bytes);
    return true;
}

} // namespace

Writer::Writer(int transducers) : _transducers(transducers), _before(silentSignal(transducers)) {}

std::vector<std::uint8_t> Writer::header(std::uint64_t start_ns) const
{
    std::vector<std::uint8_t> bytes(kMagic, kMagic + kMagicBytes);
    base::ByteWriter out(bytes);
    out.u16(kVersion);
    out.u16(kHeaderBytes);
    out.u32(static_cast<std::uint32_t>(_transducers));
    out.u64(start_ns);
    out.u32(0);
    out.u32(base::crc32c(bytes.data(), bytes.size()));
    return bytes;
}

void Writer::begin(std::uint64_t time_ns, Kind kind)
{
    _bytes.clear();
    base::ByteWriter out(_bytes);
    out.u8(static_cast<std::uint8_t>(kind));
    out.u8(0);
    out.u16(0);
    out.u32(0);
    out.u64(time_ns);
}

void Writer::finish()
{
    const std::size_t payload = _bytes.size() - kRecordHeaderBytes;
    for (int i = 0; i < 4; ++i)
        _bytes[4 + i] = static_cast<std::uint8_t>(payload >> (8 * i));
    base::ByteWriter(_bytes).u32(base::crc32c(_bytes.data(), _bytes.size()));
}

const std::vector<std::uint8_t>& Writer::field(std::uint64_t time_ns, const DriveSignal& signal)
{
    begin(time_ns, Kind::FIELD);
    const Coding phase = chooseCoding(signal.phase, _before.phase);
    const Coding duty = chooseCoding(signal.duty, _before.duty);
    _bytes[1] = phase;
    _bytes[2] = duty;
    base::ByteWriter out(_bytes);
    putPlane(out, phase, signal.phase);
    putPlane(out, duty, signal.duty);
    finish();
    _before = signal;
    return _bytes;
}

const std::vector<std::uint8_t>& Writer::mark(std::uint64_t time_ns, Kind kind)
{
    begin(time_ns, kind);
    finish();
    return _bytes;
}

Reader::Reader(const std::uint8_t* data, std::size_t size, const std::string& name) :
    _data(data),
    _size(size)
{
    base::ByteReader in(data, size);
    const std::uint8_t* magic = in.bytes(kMagicBytes);
    if (magic == nullptr || std::memcmp(magic, kMagic, kMagicBytes) != 0)
        throw DeviceError("recording \"" + name +
                          "\": not a recording of fields: it doesn't start with MIDAIRF");
    const std::uint16_t version = in.u16();
    if (in.ok() && version != kVersion)
        throw DeviceError(
            fmt::format("recording \"{}\": format version {}, but this program reads version {}",
                        name,
                        version,
                        kVersion));
    in.u16();
    const std::uint32_t transducers = in.u32();
    _start_ns = in.u64();
    in.u32();
    const std::uint32_t crc = in.u32();
    if (!in.ok() || crc != base::crc32c(data, kHeaderBytes - kCrcBytes))
        throw DeviceError("recording \"" + name + "\": the header is damaged");
    if (transducers == 0 || transducers > kMostTransducers)
        throw DeviceError(fmt::format("recording \"{}\": {} transducers, should be 1 to {}",
                                      name,
                                      transducers,
                                      kMostTransducers));
    _transducers = static_cast<int>(transducers);
    _before = silentSignal(_transducers);
}

Reader::Reader(const std::string& bytes, const std::string& name) :
    Reader(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), name)
{
}

Stop Reader::next(Entry& entry)
{
    base::ByteReader in(_data + _offset, _size - _offset);
    const std::uint8_t kind = in.u8();
    const std::uint8_t phaseCoding = in.u8();
    const std::uint8_t dutyCoding = in.u8();
    in.u8();
    const std::uint32_t payloadBytes = in.u32();
    const std::uint64_t time_ns = in.u64();
    if (!in.ok()) return Stop::TRUNCATED;
    if (payloadBytes > 2U * static_cast<std::uint32_t>(_transducers)) return Stop::CORRUPT;
    const std::uint8_t* payload = in.bytes(payloadBytes);
    const std::uint32_t crc = in.u32();
    if (!in.ok()) return Stop::TRUNCATED;
    const std::size_t bytes = kRecordHeaderBytes + payloadBytes;
    if (crc != base::crc32c(_data + _offset, bytes) || time_ns < _last_ns) return Stop::CORRUPT;

    Entry read;
    read.time_ns = time_ns;
    read.kind = static_cast<Kind>(kind);
    if (read.kind == Kind::FIELD)
    {
        read.signal = _before;
        base::ByteReader planes(payload, payloadBytes);
        if (!takePlane(planes, phaseCoding, read.signal.phase) ||
            !takePlane(planes, dutyCoding, read.signal.duty) || planes.left() != 0)
            return Stop::CORRUPT;
        _before = read.signal;
    }
    else if (read.kind == Kind::SILENCE)
        read.signal = silentSignal(_transducers);
    else if (read.kind == Kind::END)
        return Stop::END;
    else
        return Stop::CORRUPT;
    _last_ns = time_ns;
    _offset += bytes + kCrcBytes;
    entry = std::move(read);
    return Stop::MORE;
}

} // namespace midair::device::recording
