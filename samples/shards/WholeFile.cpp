#include "haptics/base/InputError.h"
#include "samples/shards/Shards.h"

#include <cerrno>
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

constexpr std::size_t kBuffer = std::size_t(1) << 20;

[[noreturn]] void failToWrite(const std::string& file)
{
    throw base::InputError(
        fmt::format("\"{}\" can't be written: {}", file, std::generic_category().message(errno)));
}

} // namespace

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
