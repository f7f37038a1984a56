#include "samples/shared/shards/Shards.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr int kMostShards = 100000;
constexpr int kBar = 30;              // characters
constexpr double kTerminal_s = 0.2;   // between two looks of the bar
constexpr double kElsewhere_s = 30.0; // between two lines in a log

constexpr std::size_t kBuffer = std::size_t(1) << 20;

[[noreturn]] void failToWrite(const std::string& file)
{
    throw base::InputError(
        fmt::format("\"{}\" can't be written: {}", file, std::generic_category().message(errno)));
}

} // namespace

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
    throw InputError(why + "; run their shards again, which keeps what is done");
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
            fmt::format("\"{}\" is there and is no regular file; choose another name", _file));
    if (isThere && !magic.empty() && !overwrite && about.st_size > 0)
    {
        std::string begin(magic.size(), '\0');
        std::ifstream(_file, std::ios::binary)
            .read(begin.data(), static_cast<std::streamsize>(begin.size()));
        if (begin != magic)
            throw base::InputError(fmt::format(
                "\"{}\" is there and is something else, so it stays as it is; choose another name, "
                "or say --overwrite",
                _file));
    }
    ::unlink(_temporary.c_str()); // of a process that was ended
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
    std::size_t done = 0;
    while (done < _buffer.size())
    {
        const ssize_t put = ::write(_descriptor, _buffer.data() + done, _buffer.size() - done);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) failToWrite(_temporary);
        done += static_cast<std::size_t>(put);
    }
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
