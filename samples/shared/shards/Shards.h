#pragma once

#include "samples/shared/shards/PartFile.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace midair::samples
{

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
