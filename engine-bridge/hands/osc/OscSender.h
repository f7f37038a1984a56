#pragma once

#include "engine-bridge/hands/osc/OscReceiver.h"

#include <string>
#include <vector>

namespace midair::bridge
{

/// Sends hands as OscReceiver takes them, by UDP or to the other end of a socket. One thread at a
/// time may use it. Never waits: what there is no room for is dropped.
class OscSender
{
public:
    /// Sends to \a to. Throws base::InputError if there is no such address.
    explicit OscSender(const OscOptions& to);
    /// Sends into \a socket, a connected one of datagrams that it owns from now on.
    explicit OscSender(int socket);
    ~OscSender();
    OscSender(const OscSender&) = delete;
    OscSender& operator=(const OscSender&) = delete;

    /// \a time_s: the sender's clock, which must rise. Returns false if it was not sent.
    bool send(const std::vector<Hand>& hands, double time_s);
    bool send(const Head& head); ///< at its time_s, of the same clock
    bool say(const std::string& text);

    /// Reads what the receiver has asked for. False if it is gone, which UDP doesn't tell.
    bool listen();
    double horizon_s() const { return _horizon_s; } ///< by the last listen(); 0: none asked for

private:
    bool sendBytes(std::size_t size);

    int _socket;
    OscWriter _writer;
    double _horizon_s = 0.0;
};

} // namespace midair::bridge
