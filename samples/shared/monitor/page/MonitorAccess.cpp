#include "samples/shared/monitor/page/MonitorAccess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kFewestTokenCharacters = 16;
constexpr std::size_t kMostTokenCharacters = 256;

struct Place
{
    std::string host; ///< without brackets
    bool isBracketed = false;
    std::optional<std::uint16_t> port;
};

/// Parses "HOST", "HOST:PORT", "[V6]" and "[V6]:PORT"; returns none for anything else.
std::optional<Place> placeOf(const std::string& text)
{
    Place place;
    place.isBracketed = !text.empty() && text.front() == '[';
    const std::size_t begin = place.isBracketed ? 1 : 0;
    const std::size_t end =
        place.isBracketed ? text.find(']') : std::min(text.find(':'), text.size());
    if (end == std::string::npos) return {};
    place.host = text.substr(begin, end - begin);
    const std::string_view rest = std::string_view(text).substr(end + begin);
    if (rest.empty()) return place;
    place.port = 0;
    const auto read = std::from_chars(rest.data() + 1, rest.data() + rest.size(), *place.port);
    if (rest.front() != ':' || read.ec != std::errc() || read.ptr != rest.data() + rest.size())
        return {};
    return place;
}

bool isNumeric(const Place& place)
{
    std::array<unsigned char, sizeof(in6_addr)> bytes{};
    // inet_pton would stop at a zero byte.
    return place.host.find('\0') == std::string::npos &&
           ::inet_pton(place.isBracketed ? AF_INET6 : AF_INET, place.host.c_str(), bytes.data()) ==
               1;
}

[[noreturn]] void failOnToken(const std::string& path, const std::string& what)
{
    throw std::runtime_error(fmt::format("the token's file {} {}", path, what));
}

bool isTokenCharacter(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("-._~", c) != nullptr;
}

/// Creates the file with a new token and returns the token, or an empty text if the file exists.
std::string tokenOfNewFile(const std::string& path)
{
    std::string token = newToken();
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file < 0 && errno == EEXIST) return {};
    if (file < 0)
        failOnToken(path,
                    fmt::format("can't be created: {}", std::generic_category().message(errno)));
    const std::string line = token + "\n";
    const ssize_t written = ::write(file, line.data(), line.size());
    ::close(file);
    if (written == static_cast<ssize_t>(line.size())) return token;
    ::unlink(path.c_str());
    failOnToken(path, "can't be written");
}

} // namespace

MonitorAddress MonitorAddress::parse(const std::string& text)
{
    std::optional<Place> place = placeOf(text);
    if (place && !place->isBracketed && (place->host.empty() || place->host == "localhost"))
        place->host = "127.0.0.1";
    if (!place || !place->port || !isNumeric(*place))
        throw std::runtime_error(
            fmt::format("is \"{}\", should be ADDRESS:PORT with a numeric address, such as "
                        "127.0.0.1:8080, [::1]:8080, or :8080 for this machine only",
                        text));
    return {place->host, *place->port};
}

bool MonitorAddress::isLoopback() const
{
    return host == "::1" || host.compare(0, 4, "127.") == 0;
}

std::string MonitorAddress::text() const
{
    const bool isV6 = host.find(':') != std::string::npos;
    return fmt::format(isV6 ? "[{}]:{}" : "{}:{}", host, port);
}

bool isTrustedHost(const std::string& host, const std::vector<std::string>& names)
{
    const std::optional<Place> place = placeOf(host);
    if (!place) return false;
    if (place->isBracketed || isNumeric(*place)) return isNumeric(*place);
    std::array<char, 256> own{};
    if (::gethostname(own.data(), own.size() - 1) != 0) own[0] = '\0';
    const auto isIt = [&](const std::string& name)
    {
        return !name.empty() && name.size() == place->host.size() &&
               ::strncasecmp(name.data(), place->host.data(), name.size()) == 0;
    };
    return isIt("localhost") || isIt(own.data()) || isIt(own.data() + std::string(".local")) ||
           std::any_of(names.begin(), names.end(), isIt);
}

std::string newToken()
{
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw std::runtime_error("the system has no random numbers for a token");
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}

std::string tokenOfFile(const std::string& path)
{
    std::string made = tokenOfNewFile(path);
    if (!made.empty()) return made;
    const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    struct stat about = {};
    if (file < 0 || ::fstat(file, &about) != 0)
        failOnToken(path, fmt::format("can't be read: {}", std::generic_category().message(errno)));
    std::array<char, kMostTokenCharacters + 2> text{};
    const ssize_t got = S_ISREG(about.st_mode) ? ::read(file, text.data(), text.size()) : 0;
    ::close(file);
    if (!S_ISREG(about.st_mode)) failOnToken(path, "is not a regular file");
    if ((about.st_mode & 077U) != 0)
        failOnToken(path, fmt::format("can be read by others; run: chmod 600 {}", path));
    const auto* const end = text.begin() + std::max<ssize_t>(0, got);
    std::string token(text.cbegin(), std::find(text.cbegin(), end, '\n'));
    if (token.size() < kFewestTokenCharacters || token.size() > kMostTokenCharacters ||
        !std::all_of(token.begin(), token.end(), isTokenCharacter))
        failOnToken(
            path,
            fmt::format("needs a first line of {} to {} letters, digits, '-', '.', '_' or '~'",
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
