#pragma once

#include <string>
#include <vector>

namespace midair::samples
{

/// Where the operator's page is served.
struct MonitorAddress
{
    std::string host = "127.0.0.1"; ///< numeric, IPv4 or IPv6
    int port = 0;                   ///< 0: one that is free

    /// Reads "127.0.0.1:8080", "[::1]:8080", "localhost:8080" and ":8080", which is this machine's
    /// loopback. Names are not looked up. Throws std::runtime_error with a phrase that says what is
    /// wrong.
    static MonitorAddress parse(const std::string& text);

    /// True: only this machine reaches it.
    bool isLoopback() const;
    std::string text() const; ///< "127.0.0.1:8080", "[::1]:8080"
};

/// Returns true if a browser may ask for the page by the Host header \a host: a number, localhost,
/// this machine's own name, with or without ".local", or one of \a names, with any port. Any other
/// name may be a stranger's that was made to lead here (DNS rebinding), and that stranger's page
/// would then read and act as ours.
bool isTrustedHost(const std::string& host, const std::vector<std::string>& names);

/// Returns a token of 128 random bits, as 32 hexadecimal digits. Throws std::runtime_error if the
/// system has no random numbers.
std::string newToken();

/// Returns the token in the first line of \a path. A file that is missing is made, with a new token
/// and for its owner alone. Throws std::runtime_error that names the file if others may read it, or
/// if there is no token of 16 to 256 letters, digits, '-', '.', '_' or '~' in it.
std::string tokenOfFile(const std::string& path);

/// Compares in a time that depends on \a wanted's length alone, so that nobody finds the token
/// letter by letter.
bool isSameToken(const std::string& given, const std::string& wanted);

/// Returns who \a name, percent-encoded as a browser sends it, and \a peer are, in a line: "Anna
/// (192.168.1.7)". Of the name at most 40 bytes are taken, without control characters.
std::string operatorName(const std::string& name, const std::string& peer);

} // namespace midair::samples
