#include "haptics/base/RegularFile.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::base
{

namespace
{

[[noreturn]] void fail(const std::string& what)
{
    throw FileError(what + std::generic_category().message(errno));
}

std::string sizeText(std::size_t bytes)
{
    constexpr std::size_t kMebibyte = std::size_t(1) << 20;
    return bytes % kMebibyte == 0 ? fmt::format("{} MiB", bytes / kMebibyte)
                                  : fmt::format("{} bytes", bytes);
}

/// File descriptor that is closed at the end of its scope.
struct Descriptor
{
    int number;
    explicit Descriptor(int n) : number(n) {}
    ~Descriptor()
    {
        if (number >= 0) ::close(number);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
};

void require(int file, std::size_t mostBytes, struct stat& about)
{
    if (::fstat(file, &about) != 0) fail("can't be read: ");
    if (S_ISDIR(about.st_mode)) throw FileError("is a folder, should be a regular file");
    if (!S_ISREG(about.st_mode)) throw FileError("is a device or a pipe, should be a regular file");
    if (static_cast<std::size_t>(about.st_size) > mostBytes)
        throw FileError(fmt::format(
            "has {} bytes, should have at most {}", about.st_size, sizeText(mostBytes)));
}

std::string bytesOf(const std::string& path, std::size_t mostBytes)
{
    // Other kinds of files are not even opened: opening a terminal or a pipe has side effects.
    struct stat about = {};
    if (::stat(path.c_str(), &about) != 0) fail("can't be read: ");
    if (!S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode))
        throw FileError("is a device or a pipe, should be a regular file");
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (file.number < 0) fail("can't be read: ");
    require(file.number, mostBytes, about);
    std::string text(static_cast<std::size_t>(about.st_size), '\0');
    std::size_t done = 0;
    while (done < text.size())
    {
        const ssize_t count = ::read(file.number, text.data() + done, text.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail("can't be read: ");
        if (count == 0) break; // the file shrank meanwhile
        done += static_cast<std::size_t>(count);
    }
    text.resize(done);
    return text;
}

} // namespace

std::string
readRegularFile(const std::string& path, std::size_t mostBytes, const std::string& before)
{
    try
    {
        return bytesOf(path, mostBytes);
    }
    catch (const FileError& error)
    {
        throw FileError(before + error.what());
    }
}

} // namespace midair::base
