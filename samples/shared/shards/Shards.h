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

/// What a part file begins with: what work it is of, so that parts of different work can't be
/// joined, and which share.
struct PartHeader
{
    nlohmann::json work; ///< all that the results depend on; alike in all parts
    int shard = 1;       ///< 1 .. shards
    int shards = 1;
    std::uint64_t pieces = 0; ///< of the whole work

    /// Pieces are dealt out in turn: shard i of K has i - 1, i - 1 + K, ..
    bool has(std::uint64_t piece) const
    {
        return piece % static_cast<std::uint64_t>(shards) == static_cast<std::uint64_t>(shard - 1);
    }
    /// Number of pieces that the shard has.
    std::uint64_t share() const;
};

/// Returns the first difference of two works in words, "fps is 60 and 30"; empty: there is none.
std::string differenceOf(const nlohmann::json& a, const nlohmann::json& b);

/// What of a shard is done: finished pieces, each with its number and its CRC-32C. The format: the
/// eight bytes "MIDAIRP\n", a piece with number 2^64 - 1 and the header as JSON, then pieces in any
/// order: "PIEC", number (u64), bytes (u64), CRC-32C of these 20 bytes (u32), payload, CRC-32C of
/// the payload (u32), all little-endian.
class PartFile
{
public:
    /// Opens \a path to go on with it. It is made where there is none; of one that is there, whole
    /// pieces are kept, what is behind the last whole one is cut off, and damaged ones are to be
    /// done again. Throws base::InputError, and leaves the file, if it is something else, of other
    /// work or another share, or in use.
    static PartFile openToGoOn(const std::string& path, const PartHeader& header);
    /// Opens \a path to read it; damaged pieces don't count.
    static PartFile openToRead(const std::string& path);

    const std::string& path() const { return _path; }
    const PartHeader& header() const { return _header; }
    bool has(std::uint64_t piece) const { return _places.count(piece) > 0; }
    std::uint64_t pieces() const { return _places.size(); }
    std::vector<std::uint64_t> numbers() const;
    /// A sentence on what was cut off or damaged when it was opened; empty: nothing.
    const std::string& damage() const { return _damage; }

    /// Appends a piece, which outlives this process from then on. What the machine itself loses, as
    /// without power, is no whole piece and so done again. Throws base::InputError.
    void add(std::uint64_t piece, const std::string& payload);
    /// Waits until all pieces are on the disk. Throws base::InputError.
    void sync();
    /// Returns the payload of a piece that is there. Throws base::InputError.
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
    std::uint64_t _end = 0; ///< behind the last whole piece
    std::string _damage;
};

/// A share of the work: "2/4" is the second of four.
struct Shard
{
    int number = 1; ///< 1 .. count
    int count = 1;  ///< 1 .. 100000
};

/// Reads "i/K". Throws base::InputError.
Shard parseShard(const std::string& text);

/// The pieces of all parts of one work, each once and without gaps.
class JoinedParts
{
public:
    /// \a describe: what a piece is, in words, such as "frames 0 to 63". Throws base::InputError,
    /// which names the files and the pieces, if parts are of different work, or if pieces are there
    /// twice, missing or damaged.
    JoinedParts(const std::vector<std::string>& files,
                const std::function<std::string(const nlohmann::json& work, std::uint64_t piece)>&
                    describe);

    const nlohmann::json& work() const { return _parts.front().header().work; }
    std::uint64_t pieces() const { return _partOf.size(); }
    std::string read(std::uint64_t piece) const { return _parts[_partOf[piece]].read(piece); }

private:
    std::vector<PartFile> _parts;
    std::vector<std::size_t> _partOf; ///< for each piece
};

/// Tells on stderr how far the work is: a bar on a terminal, a line now and then elsewhere.
class Progress
{
public:
    /// \a done of \a all units (with their plural name) are done already.
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

/// Writes \a file as a whole: what is there is replaced when commit() is called, or stays as it is.
class WholeFile
{
public:
    /// \a magic: a file that is there and doesn't begin with it is not replaced, unless \a
    /// overwrite; empty: any regular file is. Throws base::InputError.
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
