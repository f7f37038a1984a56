#pragma once

#include <string>
#include <vector>

namespace midair::samples
{

/// Address of the operator's page.
struct MonitorAddress
{
    std::string host = "127.0.0.1"; ///< numeric, IPv4 or IPv6
    int port = 0;                   ///< 0: any free port

    /// Parses "127.0.0.1:8080", "[::1]:8080", "localhost:8080" and ":8080" (loopback). Names are
    /// not resolved. Throws std::runtime_error with a phrase that describes the problem.
    static MonitorAddress parse(const std::string& text);

    /// Returns true if only this machine can reach it.
    bool isLoopback() const;
    std::string text() const; ///< "127.0.0.1:8080", "[::1]:8080"
};

/// Returns true if the Host header \a host is trusted: a number, localhost, this machine's name,
/// with or without ".local", or one of \a names, with any port. Any other name could be an
/// attacker's that resolves to this machine (DNS rebinding); the attacker's page could then read
/// and act like ours.
bool isTrustedHost(const std::string& host, const std::vector<std::string>& names);

/// Returns a token of 128 random bits as 32 hexadecimal digits. Throws std::runtime_error if the
/// system has no random numbers.
std::string newToken();

/// Returns the token in the first line of \a path. Creates a missing file with a new token,
/// readable by its owner only. Throws std::runtime_error with the file's name if others may read it
/// or if it has no token of 16 to 256 letters, digits, '-', '.', '_' or '~'.
std::string tokenOfFile(const std::string& path);

/// Compares in a time that depends only on the length of \a wanted, so that the token can't be
/// guessed letter by letter.
bool isSameToken(const std::string& given, const std::string& wanted);

/// Returns \a name, percent-encoded as browsers send it, and \a peer as one line: "Anna
/// (192.168.1.7)". Uses at most 40 bytes of the name, without control characters.
std::string operatorName(const std::string& name, const std::string& peer);

} // namespace midair::samples
