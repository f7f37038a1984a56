#pragma once

#include "device/drive/DriveSignal.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::device
{

/// File format of `record:` and `play:`, as pure functions on bytes (format version 1).
///
/// All numbers are little-endian. The header has 32 bytes: "MIDAIRF\n" (8), version (u16), header
/// bytes (u16), number m of transducers (u32), start in ns since 1970 (u64), 0 (u32), CRC-32C of
/// the 28 bytes before (u32). Then records: kind (u8: 1 field, 2 silence, 3 end), phase coding
/// (u8), duty coding (u8), 0 (u8), payload bytes (u32), time in ns since the start (u64), payload,
/// CRC-32C of all of the record before it (u32). A field's payload is its phases, then its duties,
/// each coded as 0: m bytes; 1: one byte for all; 2: nothing, as in the field before (at the start:
/// all 0). A record is valid if its CRC is right; a reader stops before the first invalid one.
namespace recording
{

constexpr std::uint16_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 32;
constexpr char kMagic[9] = "MIDAIRF\n";
constexpr std::size_t kMagicBytes = 8;
constexpr int kMostTransducers = 1 << 20;

/// The kind of a record.
enum class Kind : std::uint8_t
{
    FIELD = 1,
    SILENCE = 2,
    END = 3
};

/// Encodes fields as bytes; keeps the last field for coding 2.
class Writer
{
public:
    explicit Writer(int transducers);

    std::vector<std::uint8_t> header(std::uint64_t start_ns) const;
    /// Returns a record of a field; \a signal has one entry per transducer. The bytes are valid
    /// until the next call.
    const std::vector<std::uint8_t>& field(std::uint64_t time_ns, const DriveSignal& signal);
    const std::vector<std::uint8_t>& mark(std::uint64_t time_ns, Kind kind); ///< SILENCE or END
    /// Makes the next field independent of those before it.
    void forget() { _before = {}; }

private:
    void begin(std::uint64_t time_ns, Kind kind);
    void finish();

    const int _transducers;
    DriveSignal _before;
    std::vector<std::uint8_t> _bytes;
};

/// One record of a recording: a field, a silence (all duties 0), or the end.
struct Entry
{
    std::uint64_t time_ns = 0;
    Kind kind = Kind::END;
    DriveSignal signal;
};

/// Reason for the end of reading.
enum class Stop
{
    MORE,      ///< an entry was read
    END,       ///< the end mark was reached
    TRUNCATED, ///< the bytes end inside a record or without an end mark
    CORRUPT    ///< a record's CRC or contents are wrong
};

/// Decodes bytes to fields; never reads out of bounds, whatever the bytes.
class Reader
{
public:
    /// Keeps the pointer, so the bytes must outlive the reader. \a name is the file's, for
    /// messages. Throws DeviceError if the header is invalid or of another version than 1.
    Reader(const std::uint8_t* data, std::size_t size, const std::string& name);
    Reader(const std::string& bytes, const std::string& name);

    int transducers() const { return _transducers; }
    std::uint64_t start_ns() const { return _start_ns; }
    Stop next(Entry& entry);                       ///< sets \a entry only if it returns MORE
    std::size_t offset() const { return _offset; } ///< of the first unread byte

private:
    const std::uint8_t* _data;
    std::size_t _size;
    std::size_t _offset = kHeaderBytes;
    int _transducers = 0;
    std::uint64_t _start_ns = 0;
    std::uint64_t _last_ns = 0;
    DriveSignal _before;
};

} // namespace recording

} // namespace midair::device
