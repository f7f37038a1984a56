#pragma once

#include "engine-bridge/hands/osc/OscReceiver.h"

#include <string>
#include <vector>

namespace midair::bridge
{

/// Sends hands for OscReceiver, by UDP or through a socket. One thread at a time may use it. Never
/// waits: drops data without room.
class OscSender
{
public:
    /// Sends to \a to. Throws base::InputError for an invalid address.
    explicit OscSender(const OscOptions& to);
    /// Sends to \a socket, a connected datagram socket, which it owns from now on.
    explicit OscSender(int socket);
    ~OscSender();
    OscSender(const OscSender&) = delete;
    OscSender& operator=(const OscSender&) = delete;

    /// \a time_s: the sender's clock, which must increase. Returns false if it was not sent.
    bool send(const std::vector<Hand>& hands, double time_s);
    bool send(const Head& head); ///< at its time_s on the same clock
    bool say(const std::string& text);

    /// Reads requests of the receiver. Returns false if it is gone, which UDP can't detect.
    bool listen();
    double horizon_s() const { return _horizon_s; } ///< of the last listen(); 0: no request

private:
    bool sendBytes(std::size_t size);

    int _socket;
    OscWriter _writer;
    double _horizon_s = 0.0;
};

} // namespace midair::bridge
