#include "samples/shared/monitor/page/MonitorAddress.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <string_view>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <strings.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

/// A place and its port, which may be missing.
struct HostAndPort
{
    std::string host; ///< without brackets
    bool isBracketed = false;
    bool hasPort = false;
    int port = 0;
};

bool parsePort(std::string_view digits, int& port)
{
    const char* const end = digits.data() + digits.size();
    const auto read = std::from_chars(digits.data(), end, port);
    return !digits.empty() && digits.front() != '-' && read.ec == std::errc() && read.ptr == end &&
           port <= 65535;
}

/// Cuts "HOST", "HOST:PORT", "[V6]" and "[V6]:PORT". Returns false for anything else.
bool cutHost(const std::string& text, HostAndPort& parts)
{
    std::size_t end = text.find(':');
    if (!text.empty() && text.front() == '[')
    {
        const std::size_t close = text.find(']');
        if (close == std::string::npos) return false;
        parts.isBracketed = true;
        parts.host = text.substr(1, close - 1);
        end = close + 1;
        if (end < text.size() && text[end] != ':') return false;
        if (end >= text.size()) end = std::string::npos;
    }
    else
        parts.host = text.substr(0, end);
    parts.hasPort = end != std::string::npos;
    return !parts.hasPort || parsePort(std::string_view(text).substr(end + 1), parts.port);
}

bool isNumeric(const std::string& host, int family)
{
    std::array<unsigned char, sizeof(in6_addr)> bytes{};
    // A zero byte would end the text for inet_pton alone.
    return host.find('\0') == std::string::npos &&
           ::inet_pton(family, host.c_str(), bytes.data()) == 1;
}

} // namespace

MonitorAddress MonitorAddress::parse(const std::string& text)
{
    HostAndPort parts;
    const bool isCut = cutHost(text, parts) && parts.hasPort;
    if (isCut && parts.host.empty() && !parts.isBracketed) parts.host = "127.0.0.1";
    if (isCut && parts.host == "localhost") parts.host = "127.0.0.1";
    if (!isCut || !isNumeric(parts.host, parts.isBracketed ? AF_INET6 : AF_INET))
        throw std::runtime_error(fmt::format(
            "is \"{}\", should be ADDRESS:PORT with a numeric address, as 127.0.0.1:8080, "
            "[::1]:8080, or :8080 for this machine alone",
            text));
    return {parts.host, parts.port};
}

bool MonitorAddress::isLoopback() const
{
    return host == "::1" || (!isV6() && host.compare(0, 4, "127.") == 0);
}

std::string MonitorAddress::text() const
{
    return isV6() ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

std::vector<std::string> ownHostNames()
{
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return {};
    return {name.data(), std::string(name.data()) + ".local"};
}

bool isTrustedHost(const std::string& host, const std::vector<std::string>& names)
{
    HostAndPort parts;
    if (!cutHost(host, parts)) return false;
    if (parts.isBracketed) return isNumeric(parts.host, AF_INET6);
    if (isNumeric(parts.host, AF_INET)) return true;
    const auto isIt = [&](const std::string& name)
    {
        return name.size() == parts.host.size() &&
               ::strncasecmp(name.data(), parts.host.data(), name.size()) == 0;
    };
    return isIt("localhost") || std::any_of(names.begin(), names.end(), isIt);
}

} // namespace midair::samples
