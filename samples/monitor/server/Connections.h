#pragma once

#include "samples/monitor/server/ConnectionLoop.h"

#include <cstdint>
#include <string>
#include <vector>

#include <poll.h>

namespace midair::samples
{

/// A socket or the like, closed at the end.
class OwnedFile
{
public:
    explicit OwnedFile(int file = -1) : _file(file) {}
    ~OwnedFile();
    OwnedFile(OwnedFile&& other) noexcept : _file(other._file) { other._file = -1; }
    OwnedFile& operator=(OwnedFile&& other) noexcept;
    int get() const { return _file; }

private:
    int _file;
};

/// Returns a socket that listens on \a address, which no other program may do then. Throws
/// std::runtime_error.
OwnedFile listenOn(const MonitorAddress& address);

/// Returns the port that \a socket is bound to.
int portOf(const OwnedFile& socket);

/// One request on its way in, being answered, or on its way out.
class Connection
{
public:
    enum Stage
    {
        READING,
        WORKING, ///< an answer is being made
        WRITING,
        DRAINING, ///< answered; until the other side has read it and hangs up
        CLOSED
    };

    Connection(OwnedFile socket, std::string peer, std::uint64_t number, double end_s);

    Stage stage() const { return _stage; }
    std::uint64_t number() const { return _number; }
    const std::string& peer() const { return _peer; }
    const std::string& head() const { return _head; }
    double end_s() const { return _end_s; }
    pollfd polled() const;

    /// Does what can be done at once. After the last bytes of a request READING becomes WORKING.
    void move(short events, double now_s, const ConnectionLimits& limits);
    /// The answer is there.
    void write(std::string answer, double now_s, const ConnectionLimits& limits);
    /// Its time is over.
    void expire(double now_s, const ConnectionLimits& limits);
    void close() { _stage = CLOSED; }

private:
    void readSome(double now_s, const ConnectionLimits& limits);
    void writeSome(double now_s, const ConnectionLimits& limits);
    void drainSome();

    OwnedFile _socket;
    std::string _peer;
    std::uint64_t _number;
    Stage _stage = READING;
    std::string _head;
    std::string _answer;
    std::size_t _written = 0;
    std::size_t _drained = 0;
    double _end_s;
};

} // namespace midair::samples
