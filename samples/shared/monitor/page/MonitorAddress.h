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

    bool isV6() const { return host.find(':') != std::string::npos; }
    /// True: only this machine reaches it.
    bool isLoopback() const;
    std::string text() const; ///< "127.0.0.1:8080", "[::1]:8080"
};

/// Returns the names besides localhost by which this machine may be asked for the page: its own,
/// with and without ".local".
std::vector<std::string> ownHostNames();

/// Returns true if a browser may ask for the page by the Host header \a host: a number, localhost,
/// or one of \a names, with any port. Any other name may be a stranger's that was made to lead here
/// (DNS rebinding), and that stranger's page would then read and act as ours.
bool isTrustedHost(const std::string& host, const std::vector<std::string>& names);

} // namespace midair::samples
