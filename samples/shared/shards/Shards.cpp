#include "samples/shared/shards/Shards.h"

#include "haptics/base/Bytes.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/shards/LineJournal.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

using base::InputError;
using device::recording::OpenFile;

constexpr char kMagic[] = "MIDAIRP\n";
constexpr std::size_t kMagicBytes = 8;
constexpr std::uint32_t kPiece = 0x43454950; // "PIEC"
constexpr std::size_t kFrontBytes = 24;
constexpr std::size_t kCrcBytes = 4;
constexpr std::uint64_t kHeaderNumber = ~std::uint64_t(0);
constexpr std::uint64_t kMostPieces = 100000000; // enough for one frame per piece in the longest
                                                 // animation
constexpr std::uint64_t kMostPieceBytes = std::uint64_t(1) << 31;

[[noreturn]] void fail(const std::string& path, const std::string& why)
{
    throw InputError(fmt::format("part \"{}\": {}", path, why));
}

[[noreturn]] void failSystem(const std::string& path, const char* what)
{
    fail(path, fmt::format("{}: {}", what, std::generic_category().message(errno)));
}

std::uint32_t crcOf(const void* bytes, std::size_t count)
{
    return base::crc32c(static_cast<const std::uint8_t*>(bytes), count);
}

std::uint64_t sizeOf(const OpenFile& file, const std::string& path)
{
    struct stat about = {};
    if (::fstat(file.descriptor(), &about) != 0) failSystem(path, "can't be read");
    if (!S_ISREG(about.st_mode)) fail(path, "isn't a regular file");
    return static_cast<std::uint64_t>(about.st_size);
}

constexpr int kMostShards = 100000;
constexpr int kBar = 30;              // characters
constexpr double kTerminal_s = 0.2;   // interval of the progress bar
constexpr double kElsewhere_s = 30.0; // interval of lines in a log

constexpr std::size_t kBuffer = std::size_t(1) << 20;

[[noreturn]] void failToWrite(const std::string& file)
{
    throw base::InputError(
        fmt::format("\"{}\" can't be written: {}", file, std::generic_category().message(errno)));
}

} // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(PartHeader, work, shard, shards, pieces)

std::uint64_t PartHeader::share() const
{
    const auto first = static_cast<std::uint64_t>(shard - 1);
    const auto step = static_cast<std::uint64_t>(shards);
    return pieces > first ? (pieces - first + step - 1) / step : 0;
}

std::string differenceOf(const nlohmann::json& a, const nlohmann::json& b)
{
    if (a == b) return {};
    const nlohmann::json flatA = a.flatten();
    const nlohmann::json flatB = b.flatten();
    const auto say = [](const std::string& path, const std::string& one, const std::string& other)
    {
        std::string name = path.substr(1);
        for (char& c : name)
            if (c == '/') c = '.';
        return fmt::format("{} is {} and {}", name, one, other);
    };
    for (const auto& [path, value] : flatA.items())
        if (!flatB.contains(path))
            return say(path, value.dump(), "not there");
        else if (flatB[path] != value)
            return say(path, value.dump(), flatB[path].dump());
    for (const auto& [path, value] : flatB.items())
        if (!flatA.contains(path)) return say(path, "not there", value.dump());
    return "they differ";
}

PartFile::PartFile(std::string path, OpenFile file) : _path(std::move(path)), _file(std::move(file))
{
}

PartFile PartFile::openToGoOn(const std::string& path, const PartHeader& header)
{
    PartFile part(
        path,
        OpenFile(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666)));
    const int descriptor = part._file.descriptor();
    if (descriptor < 0) failSystem(path, "can't be written");
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        fail(path, "another process is using it");
    if (sizeOf(part._file, path) > 0) part.scan();
    if (part._hasHeader)
    {
        const std::string other = differenceOf(part._header, header);
        if (!other.empty())
            fail(path,
                 "exists and belongs to other work: " + other +
                     " (there and here); delete it, or choose another name");
    }
    part._header = header;
    if (::ftruncate(descriptor, static_cast<off_t>(part._end)) != 0)
        failSystem(path, "can't be truncated to its complete pieces");
    if (part._hasHeader) return part;
    if (!writeAll(descriptor, kMagic, kMagicBytes)) failSystem(path, "can't be written");
    part._end = kMagicBytes;
    part.write(kHeaderNumber, nlohmann::json(header).dump());
    part._hasHeader = true;
    return part;
}

PartFile PartFile::openToRead(const std::string& path)
{
    PartFile part(path, OpenFile(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)));
    if (part._file.descriptor() < 0) failSystem(path, "can't be read");
    if (::flock(part._file.descriptor(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        fail(path, "another process is still writing it");
    part.scan();
    if (!part._hasHeader) fail(path, "is empty: its first piece is incomplete");
    return part;
}

std::string PartFile::bytesAt(std::uint64_t offset, std::uint64_t size) const
{
    std::string bytes(size, '\0');
    std::size_t done = 0;
    while (done < size)
    {
        const ssize_t got = ::pread(_file.descriptor(),
                                    bytes.data() + done,
                                    size - done,
                                    static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) failSystem(_path, "can't be read to its end");
        done += static_cast<std::size_t>(got);
    }
    return bytes;
}

// Reads the piece at \a offset and advances \a offset. Returns false if there is no complete one.
bool PartFile::scanPiece(std::uint64_t& offset, std::uint64_t size, int& damaged)
{
    if (size - offset < kFrontBytes + kCrcBytes) return false;
    const std::string front = bytesAt(offset, kFrontBytes);
    base::ByteReader reader(reinterpret_cast<const std::uint8_t*>(front.data()), front.size());
    const std::uint32_t magic = reader.u32();
    const std::uint64_t number = reader.u64();
    const std::uint64_t bytes = reader.u64();
    if (magic != kPiece || reader.u32() != crcOf(front.data(), kFrontBytes - kCrcBytes) ||
        bytes > kMostPieceBytes || size - offset - kFrontBytes - kCrcBytes < bytes)
        return false;
    const std::string payload = bytesAt(offset + kFrontBytes, bytes + kCrcBytes);
    base::ByteReader end(reinterpret_cast<const std::uint8_t*>(payload.data()) + bytes, kCrcBytes);
    const bool isWhole = end.u32() == crcOf(payload.data(), bytes);
    const Place place{offset + kFrontBytes, bytes};
    offset += kFrontBytes + bytes + kCrcBytes;
    if (!isWhole)
        ++damaged;
    else if (number != kHeaderNumber)
        _places[number] = place;
    else
    {
        const nlohmann::json json = nlohmann::json::parse(payload.substr(0, bytes), nullptr, false);
        if (json.is_discarded() || !json.is_object()) fail(_path, "its header isn't JSON");
        _header = json.get<PartHeader>();
        if (_header.pieces > kMostPieces || _header.shard < 1 || _header.shards < _header.shard)
            fail(_path, "its header has an invalid share");
        _hasHeader = true;
    }
    return true;
}

void PartFile::scan()
{
    const std::uint64_t size = sizeOf(_file, _path);
    const std::uint64_t begin = std::min<std::uint64_t>(size, kMagicBytes);
    if (bytesAt(0, begin) != std::string(kMagic, begin))
        fail(_path,
             "exists and isn't a part (it doesn't start with MIDAIRP); it is left unchanged");
    std::uint64_t offset = begin;
    int damaged = 0;
    if (size > kMagicBytes)
        while (scanPiece(offset, size, damaged))
            if (!_hasHeader) fail(_path, "its header is damaged; delete it");
    _end = _hasHeader ? offset : 0;
    if (damaged > 0)
        _damage = fmt::format("{} of its pieces {} damaged", damaged, damaged == 1 ? "is" : "are");
    if (size > offset)
        _damage += fmt::format("{}{} bytes at its end are an incomplete piece",
                               _damage.empty() ? "" : "; ",
                               size - offset);
}

std::vector<std::uint64_t> PartFile::numbers() const
{
    std::vector<std::uint64_t> all;
    for (const auto& [number, place] : _places)
        all.push_back(number);
    return all;
}

void PartFile::write(std::uint64_t number, const std::string& payload)
{
    std::vector<std::uint8_t> bytes;
    bytes.reserve(kFrontBytes + payload.size() + kCrcBytes);
    base::ByteWriter writer(bytes);
    writer.u32(kPiece);
    writer.u64(number);
    writer.u64(payload.size());
    writer.u32(crcOf(bytes.data(), bytes.size()));
    writer.bytes(reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size());
    writer.u32(crcOf(payload.data(), payload.size()));
    if (!writeAll(_file.descriptor(), bytes.data(), bytes.size()))
        failSystem(_path, "can't be written");
    if (number != kHeaderNumber) _places[number] = {_end + kFrontBytes, payload.size()};
    _end += bytes.size();
}

void PartFile::sync()
{
    if (::fdatasync(_file.descriptor()) != 0) failSystem(_path, "can't be written to the disk");
}

void PartFile::add(std::uint64_t piece, const std::string& payload)
{
    if (payload.size() > kMostPieceBytes) fail(_path, "a piece is larger than 2 GiB");
    write(piece, payload);
}

std::string PartFile::read(std::uint64_t piece) const
{
    const auto found = _places.find(piece);
    if (found == _places.end()) fail(_path, fmt::format("has no piece {}", piece));
    return bytesAt(found->second.offset, found->second.size);
}

Shard parseShard(const std::string& text)
{
    Shard shard;
    const std::size_t slash = text.find('/');
    const bool isRead = slash != std::string::npos &&
                        base::parseWhole(text.substr(0, slash), shard.number) &&
                        base::parseWhole(text.substr(slash + 1), shard.count);
    if (!isRead || shard.number < 1 || shard.count < 1 || shard.count > kMostShards ||
        shard.number > shard.count)
        throw InputError(
            fmt::format("--shard is \"{}\", should be i/K with 1 <= i <= K <= {}, such as 2/4",
                        text,
                        kMostShards));
    return shard;
}

JoinedParts::JoinedParts(
    const std::vector<std::string>& files,
    const std::function<std::string(const nlohmann::json&, std::uint64_t)>& describe)
{
    if (files.empty()) throw InputError("there are no parts to merge");
    for (const std::string& file : files)
    {
        PartFile part = PartFile::openToRead(file);
        if (!_parts.empty())
        {
            const PartFile& first = _parts.front();
            const std::string other = differenceOf(first.header().work, part.header().work);
            if (!other.empty() || first.header().pieces != part.header().pieces)
                throw InputError(fmt::format("\"{}\" and \"{}\" are of different work: {}",
                                             first.path(),
                                             file,
                                             other.empty() ? "their lengths differ" : other));
        }
        _parts.push_back(std::move(part));
    }
    constexpr std::size_t kNone = ~std::size_t(0);
    const std::uint64_t count = _parts.front().header().pieces;
    _partOf.assign(count, kNone);
    for (std::size_t i = 0; i < _parts.size(); ++i)
        for (const std::uint64_t piece : _parts[i].numbers())
        {
            if (piece >= count)
                throw InputError(
                    fmt::format("\"{}\" has a piece {} of {}", files[i], piece, count));
            if (_partOf[piece] != kNone)
                throw InputError(fmt::format("{} are in \"{}\" and in \"{}\"",
                                             describe(work(), piece),
                                             files[_partOf[piece]],
                                             files[i]));
            _partOf[piece] = i;
        }
    const auto gap = std::find(_partOf.begin(), _partOf.end(), kNone);
    if (gap == _partOf.end()) return;
    const auto missing = std::count(_partOf.begin(), _partOf.end(), kNone);
    std::string why =
        fmt::format("{} of {} pieces are missing, the first of them {}",
                    missing,
                    count,
                    describe(work(), static_cast<std::uint64_t>(gap - _partOf.begin())));
    for (const PartFile& part : _parts)
        if (!part.damage().empty()) why += fmt::format("; \"{}\": {}", part.path(), part.damage());
    throw InputError(why + "; run their shards again; finished pieces are kept");
}

Progress::Progress(std::string name, std::uint64_t done, std::uint64_t all, bool isQuiet) :
    _name(std::move(name)),
    _before(done),
    _all(all),
    _isQuiet(isQuiet),
    _isTerminal(::isatty(STDERR_FILENO) == 1),
    _start_s(base::steadySeconds()),
    _done(done)
{
    show(false);
}

Progress::~Progress()
{
    show(true);
}

void Progress::add(std::uint64_t units)
{
    _done += units;
    show(false);
}

void Progress::show(bool isLast)
{
    const double now_s = base::steadySeconds();
    if (_isQuiet || (!isLast && now_s - _shown_s < (_isTerminal ? kTerminal_s : kElsewhere_s)))
        return;
    _shown_s = now_s;
    const double share = _all > 0 ? static_cast<double>(_done) / static_cast<double>(_all) : 1.0;
    const double rate = static_cast<double>(_done - _before) / std::max(1e-9, now_s - _start_s);
    std::string left;
    if (rate > 0.0 && _done > _before)
        left = fmt::format(", {:.3g} {}/s, {:.0f} s left",
                           rate,
                           _name,
                           std::ceil(static_cast<double>(_all - _done) / rate));
    const std::string line =
        fmt::format("{:3.0f} % of {} {}{}", std::floor(100.0 * share), _all, _name, left);
    if (!_isTerminal)
    {
        std::fprintf(stderr, "%s\n", line.c_str());
        return;
    }
    const int full = static_cast<int>(share * kBar);
    std::fprintf(stderr,
                 "\r[%s%s] %s\033[K%s",
                 std::string(static_cast<std::size_t>(full), '#').c_str(),
                 std::string(static_cast<std::size_t>(kBar - full), '.').c_str(),
                 line.c_str(),
                 isLast ? "\n" : "");
}

WholeFile::WholeFile(std::string file, const std::string& magic, bool overwrite) :
    _file(std::move(file)),
    _temporary(_file + ".unfinished")
{
    struct stat about = {};
    const bool isThere = ::lstat(_file.c_str(), &about) == 0;
    if (isThere && !S_ISREG(about.st_mode))
        throw base::InputError(
            fmt::format("\"{}\" exists and is not a regular file; choose another name", _file));
    if (isThere && !magic.empty() && !overwrite && about.st_size > 0)
    {
        std::string begin(magic.size(), '\0');
        std::ifstream(_file, std::ios::binary)
            .read(begin.data(), static_cast<std::streamsize>(begin.size()));
        if (begin != magic)
            throw base::InputError(fmt::format("\"{}\" exists and is a different kind of file; "
                                               "choose another name, or use --overwrite",
                                               _file));
    }
    ::unlink(_temporary.c_str()); // left by a process that was killed
    _descriptor =
        ::open(_temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (_descriptor < 0) failToWrite(_temporary);
}

WholeFile::~WholeFile()
{
    if (_descriptor < 0) return;
    ::close(_descriptor);
    ::unlink(_temporary.c_str());
}

void WholeFile::flush()
{
    if (!writeAll(_descriptor, _buffer.data(), _buffer.size())) failToWrite(_temporary);
    _buffer.clear();
}

void WholeFile::write(const void* bytes, std::size_t count)
{
    _buffer.append(static_cast<const char*>(bytes), count);
    _size += count;
    if (_buffer.size() >= kBuffer) flush();
}

void WholeFile::commit()
{
    flush();
    if (::fsync(_descriptor) != 0 || ::close(std::exchange(_descriptor, -1)) != 0)
    {
        ::unlink(_temporary.c_str());
        failToWrite(_temporary);
    }
    if (std::rename(_temporary.c_str(), _file.c_str()) != 0) failToWrite(_file);
}

} // namespace midair::samples
