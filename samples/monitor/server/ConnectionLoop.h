#pragma once

#include "samples/monitor/server/MonitorAddress.h"
#include "samples/monitor/server/PatientThreads.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace midair::samples
{

/// What strangers may take of this program.
struct ConnectionLimits
{
    std::size_t connections = 64; ///< at a time; the oldest that is still asking makes room
    std::size_t headBytes = 8192; ///< of a request up to its empty line
    std::size_t waiting = 32;     ///< requests that wait for an answer; more are refused
    int workers = 3;              ///< threads that answer
    double head_s = 5.0;          ///< for a whole request to come, however slowly
    double answer_s = 4.0;        ///< for an answer to be made
    double write_s = 10.0;        ///< for an answer to be taken
    double drain_s = 1.0;         ///< for the other side to hang up
};

/// Listens on an address, and has each request answered on a thread of its own, one for each
/// connection. One thread moves all bytes and waits for none, so that whoever sends or reads slowly
/// holds up nobody.
class ConnectionLoop
{
public:
    /// Gives the whole answer to a request's head; \a peer: numeric address of who asks. Called
    /// from several threads.
    using Answer = std::function<std::string(const std::string& head, const std::string& peer)>;

    /// Throws std::runtime_error if it can't listen on \a address: "can't listen on
    /// 127.0.0.1:8080: Address already in use".
    ConnectionLoop(const MonitorAddress& address, const ConnectionLimits& limits, Answer answer);
    ~ConnectionLoop();
    ConnectionLoop(const ConnectionLoop&) = delete;
    ConnectionLoop& operator=(const ConnectionLoop&) = delete;

    int port() const { return _port; }

private:
    class Shared;

    std::shared_ptr<Shared> _shared;
    PatientThreads _threads;
    int _port = 0;
};

} // namespace midair::samples
