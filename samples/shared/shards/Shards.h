#pragma once

#include "device/recording/RecordingFile.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// Header of a part file. It identifies the work, so that parts of different work can't be merged,
/// and the share.
struct PartHeader
{
    nlohmann::json work; ///< everything the results depend on; equal in all parts
    int shard = 1;       ///< 1 .. shards
    int shards = 1;
    std::uint64_t pieces = 0; ///< in the whole work

    /// Pieces are distributed round-robin: shard i of K has i - 1, i - 1 + K, ..
    bool has(std::uint64_t piece) const
    {
        return piece % static_cast<std::uint64_t>(shards) == static_cast<std::uint64_t>(shard - 1);
    }
    /// Returns the number of pieces of the shard.
    std::uint64_t share() const;
};

/// Returns the first difference of two works, "fps is 60 and 30", or an empty text.
std::string differenceOf(const nlohmann::json& a, const nlohmann::json& b);

/// The finished pieces of a shard, each with its number and CRC-32C. Format: the eight bytes
/// "MIDAIRP\n", a piece with number 2^64 - 1 and the header as JSON, then pieces in any order:
/// "PIEC", number (u64), bytes (u64), CRC-32C of these 20 bytes (u32), payload, CRC-32C of the
/// payload (u32), all little-endian.
class PartFile
{
public:
    /// Opens \a path to continue it, or creates it. Keeps complete pieces, cuts off an incomplete
    /// end, and marks damaged pieces as to be redone. Throws base::InputError, and keeps the file,
    /// if it is another kind of file, belongs to other work or another share, or is in use.
    static PartFile openToGoOn(const std::string& path, const PartHeader& header);
    /// Opens \a path for reading; damaged pieces are ignored.
    static PartFile openToRead(const std::string& path);

    const std::string& path() const { return _path; }
    const PartHeader& header() const { return _header; }
    bool has(std::uint64_t piece) const { return _places.count(piece) > 0; }
    std::uint64_t pieces() const { return _places.size(); }
    std::vector<std::uint64_t> numbers() const;
    /// Returns a sentence on what was cut off or damaged, or an empty text.
    const std::string& damage() const { return _damage; }

    /// Appends a piece, which survives the end of this process. After a power failure, incomplete
    /// pieces are redone. Throws base::InputError.
    void add(std::uint64_t piece, const std::string& payload);
    /// Waits until all pieces are on disk. Throws base::InputError.
    void sync();
    /// Returns the payload of an existing piece. Throws base::InputError.
    std::string read(std::uint64_t piece) const;

private:
    struct Place
    {
        std::uint64_t offset = 0;
        std::uint64_t size = 0;
    };

    PartFile(std::string path, device::recording::OpenFile file);
    void scan();
    bool scanPiece(std::uint64_t& offset, std::uint64_t size, int& damaged);
    void write(std::uint64_t number, const std::string& payload);
    std::string bytesAt(std::uint64_t offset, std::uint64_t size) const;

    std::string _path;
    device::recording::OpenFile _file;
    PartHeader _header;
    bool _hasHeader = false;
    std::map<std::uint64_t, Place> _places;
    std::uint64_t _end = 0; ///< end of the last complete piece
    std::string _damage;
};

/// A share of the work: "2/4" is the second of four.
struct Shard
{
    int number = 1; ///< 1 .. count
    int count = 1;  ///< 1 .. 100000
};

/// Parses "i/K". Throws base::InputError.
Shard parseShard(const std::string& text);

/// The pieces of all parts of one work, complete and without duplicates.
class JoinedParts
{
public:
    /// \a describe returns the name of a piece, such as "frames 0 to 63". Throws base::InputError
    /// with the names of files and pieces if parts belong to different work, or if pieces are
    /// duplicated, missing or damaged.
    JoinedParts(const std::vector<std::string>& files,
                const std::function<std::string(const nlohmann::json& work, std::uint64_t piece)>&
                    describe);

    const nlohmann::json& work() const { return _parts.front().header().work; }
    std::uint64_t pieces() const { return _partOf.size(); }
    std::string read(std::uint64_t piece) const { return _parts[_partOf[piece]].read(piece); }

private:
    std::vector<PartFile> _parts;
    std::vector<std::size_t> _partOf; ///< index of the part for each piece
};

/// Prints progress on stderr: a bar on a terminal, occasional lines elsewhere.
class Progress
{
public:
    /// \a done of \a all units (\a name is their plural) are already done.
    Progress(std::string name, std::uint64_t done, std::uint64_t all, bool isQuiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void add(std::uint64_t units);

private:
    void show(bool isLast);

    const std::string _name;
    const std::uint64_t _before;
    const std::uint64_t _all;
    const bool _isQuiet;
    const bool _isTerminal;
    const double _start_s;
    std::uint64_t _done;
    double _shown_s = -1e9;
};

/// Writes \a file atomically: commit() replaces an existing file, which otherwise stays unchanged.
class WholeFile
{
public:
    /// \a magic: an existing file is replaced only if it begins with this text or \a overwrite is
    /// true; empty: any regular file is replaced. Throws base::InputError.
    WholeFile(std::string file, const std::string& magic, bool overwrite);
    ~WholeFile();
    WholeFile(const WholeFile&) = delete;
    WholeFile& operator=(const WholeFile&) = delete;

    void write(const void* bytes, std::size_t count); ///< throws base::InputError
    void commit();                                    ///< throws base::InputError
    std::uint64_t size() const { return _size; }

private:
    void flush();

    const std::string _file;
    const std::string _temporary;
    int _descriptor = -1;
    std::string _buffer;
    std::uint64_t _size = 0;
};

} // namespace midair::samples
