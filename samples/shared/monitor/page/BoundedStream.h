#pragma once

#include "samples/shared/monitor/MonitorOptions.h"

#include <array>
#include <string>

#include <httplib.h>

namespace midair::samples
{

/// A connection as httplib reads and writes it. Its own stream has a time for each byte alone and
/// no limit to a line: whoever sends a byte every few seconds, or no line's end, would have a
/// thread or the memory for as long as he likes.
class BoundedStream : public httplib::Stream
{
public:
    /// Doesn't own \a socket.
    BoundedStream(int socket, const PageLimits& limits);

    /// Lets the other side take all before it is hung up on.
    void finish();
    /// Returns the status that was written; 0: none.
    int status() const { return _status; }

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    ssize_t read(char* to, std::size_t size) override;
    ssize_t write(const char* from, std::size_t size) override;
    void get_remote_ip_and_port(std::string& address, int& port) const override;
    void get_local_ip_and_port(std::string&, int&) const override {}
    /// Nothing asks for it but a check against select()'s limit, and nothing here selects.
    socket_t socket() const override { return 0; }

private:
    bool fill(double end_s);

    const int _socket;
    const PageLimits _limits;
    const double _headEnd_s;
    double _writeEnd_s = 0.0; ///< 0: nothing was written yet
    std::array<char, 4096> _buffer{};
    std::size_t _got = 0; ///< in the buffer ..
    std::size_t _at = 0;  ///< .. of which so many were read
    std::size_t _headBytes = 0;
    int _status = 0;
};

} // namespace midair::samples
