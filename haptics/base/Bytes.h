#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace midair::base
{

/// Appends little-endian numbers to a byte string. Wire formats are written field by field, never
/// as structs.
class ByteWriter
{
public:
    explicit ByteWriter(std::vector<std::uint8_t>& out) : _out(out) {}

    void u8(std::uint8_t value) { _out.push_back(value); }
    void u16(std::uint16_t value) { put(value, 2); }
    void u32(std::uint32_t value) { put(value, 4); }
    void u64(std::uint64_t value) { put(value, 8); }
    void bytes(const std::uint8_t* data, std::size_t count)
    {
        _out.insert(_out.end(), data, data + count);
    }

private:
    void put(std::uint64_t value, int count)
    {
        for (int i = 0; i < count; ++i)
            _out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    }

    std::vector<std::uint8_t>& _out;
};

/// Reads the output of ByteWriter. Reading past the end returns zeros and makes ok() false, so one
/// check at the end is enough.
class ByteReader
{
public:
    ByteReader(const std::uint8_t* data, std::size_t size) : _data(data), _left(size) {}

    std::uint8_t u8() { return static_cast<std::uint8_t>(get(1)); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(get(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(get(4)); }
    std::uint64_t u64() { return get(8); }
    /// Returns a pointer to the next \a count bytes, or nullptr if there are fewer.
    const std::uint8_t* bytes(std::size_t count)
    {
        if (!claim(count)) return nullptr;
        return _data - count;
    }
    std::size_t left() const { return _left; }
    bool ok() const { return _ok; }

private:
    bool claim(std::size_t count)
    {
        if (!_ok || count > _left)
        {
            _ok = false;
            return false;
        }
        _data += count;
        _left -= count;
        return true;
    }
    std::uint64_t get(int count)
    {
        if (!claim(count)) return 0;
        std::uint64_t value = 0;
        for (int i = 0; i < count; ++i)
            value |= std::uint64_t((_data - count)[i]) << (8 * i);
        return value;
    }

    const std::uint8_t* _data;
    std::size_t _left;
    bool _ok = true;
};

/// CRC-32C (Castagnoli, reflected polynomial 0x82F63B78, initial and final xor 0xFFFFFFFF; RFC
/// 3720, B.4). \a crc: result of the preceding bytes, for data in pieces.
std::uint32_t crc32c(const std::uint8_t* bytes, std::size_t count, std::uint32_t crc = 0);

} // namespace midair::base
