#include "samples/shared/monitor/page/MonitorToken.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

/// Closes a file at the end of its scope.
class TokenFile
{
public:
    explicit TokenFile(int file) : _file(file) {}
    ~TokenFile()
    {
        if (_file >= 0) ::close(_file);
    }
    TokenFile(const TokenFile&) = delete;
    TokenFile& operator=(const TokenFile&) = delete;
    int get() const { return _file; }

private:
    int _file;
};

[[noreturn]] void failOnToken(const std::string& path, const std::string& what)
{
    throw std::runtime_error(fmt::format("the token's file {} {}", path, what));
}

bool isTokenCharacter(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("-._~", c) != nullptr;
}

/// Returns the new token in a new file; empty if the file is there already.
std::string tokenOfNewFile(const std::string& path)
{
    const TokenFile file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (file.get() < 0 && errno == EEXIST) return {};
    if (file.get() < 0)
        failOnToken(path, fmt::format("can't be made: {}", std::generic_category().message(errno)));
    std::string token = newToken();
    const std::string line = token + "\n";
    if (::write(file.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    {
        ::unlink(path.c_str());
        failOnToken(path, "can't be written");
    }
    return token;
}

} // namespace

std::string newToken()
{
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw std::runtime_error("the system has no random numbers for a token");
    std::string token;
    for (const unsigned char byte : bytes)
        token += fmt::format("{:02x}", byte);
    return token;
}

std::string tokenOfFile(const std::string& path)
{
    std::string made = tokenOfNewFile(path);
    if (!made.empty()) return made;
    const TokenFile file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    struct stat about = {};
    if (file.get() < 0 || ::fstat(file.get(), &about) != 0)
        failOnToken(path, fmt::format("can't be read: {}", std::generic_category().message(errno)));
    if (!S_ISREG(about.st_mode)) failOnToken(path, "is no regular file");
    if ((about.st_mode & 077U) != 0)
        failOnToken(path, fmt::format("may be read by others; type: chmod 600 {}", path));
    std::array<char, kMostTokenCharacters + 2> text{};
    const ssize_t got = ::read(file.get(), text.data(), text.size());
    const auto* const end = text.begin() + std::max<ssize_t>(0, got);
    std::string token(static_cast<const char*>(text.begin()), std::find(text.cbegin(), end, '\n'));
    if (token.size() < kFewestTokenCharacters || token.size() > kMostTokenCharacters ||
        !std::all_of(token.begin(), token.end(), isTokenCharacter))
        failOnToken(path,
                    fmt::format("should have {} to {} letters, digits, '-', '.', '_' or '~' in its "
                                "first line",
                                kFewestTokenCharacters,
                                kMostTokenCharacters));
    return token;
}

bool isSameToken(const std::string& given, const std::string& wanted)
{
    volatile unsigned int different = given.size() == wanted.size() ? 0U : 1U;
    for (std::size_t i = 0; i < wanted.size(); ++i)
    {
        const auto mine = static_cast<unsigned char>(wanted[i]);
        const auto theirs = static_cast<unsigned char>(i < given.size() ? given[i] : 0);
        different = different | static_cast<unsigned int>(mine ^ theirs);
    }
    return different == 0U && !wanted.empty();
}

std::string operatorName(const std::string& name, const std::string& peer)
{
    constexpr std::size_t kMost = 40;
    std::string shown;
    for (std::size_t i = 0; i < name.size() && shown.size() < kMost; ++i)
    {
        unsigned int code = static_cast<unsigned char>(name[i]);
        if (name[i] == '%' && i + 2 < name.size())
        {
            const char* const digits = name.data() + i + 1;
            const auto read = std::from_chars(digits, digits + 2, code, 16);
            if (read.ec != std::errc() || read.ptr != digits + 2) continue;
            i += 2;
        }
        if (code >= 0x20 && code != 0x7F) shown += static_cast<char>(code);
    }
    return shown.empty() ? peer : fmt::format("{} ({})", shown, peer);
}

} // namespace midair::samples
