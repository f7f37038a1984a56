#pragma once

#include "engine-bridge/hands/osc/OscInbox.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

namespace midair::bridge
{

/// Where datagrams are received.
struct OscOptions
{
    std::string address = "127.0.0.1"; ///< numeric, IPv4 or IPv6; 0.0.0.0: all of the machine's
    int port = 9000;                   ///< 0 .. 65535; 0: any that is free, for tests
};

bool operator==(const OscOptions& a, const OscOptions& b);

/// Receives hands by OSC over UDP, on a thread of its own. A port that can't be had is tried again,
/// with pauses from 1 s to 30 s. At most kMostInTurn datagrams a millisecond are read, so that a
/// flood takes no whole core; what is more the system drops.
class OscReceiver
{
public:
    static constexpr int kMostInTurn = 64;

    /// The receiver for these options; callers with the same options share one, since a port is had
    /// once.
    static std::shared_ptr<OscReceiver> open(const OscOptions& options);

    /// Throws base::InputError if \a options have no address.
    explicit OscReceiver(const OscOptions& options);
    ~OscReceiver();
    OscReceiver(const OscReceiver&) = delete;
    OscReceiver& operator=(const OscReceiver&) = delete;

    const OscInbox& inbox() const { return _inbox; }
    int port() const { return _port; } ///< 0: not open yet; any thread

    /// One line of text: where it listens, and what came. Any thread.
    std::string status() const;

private:
    bool bindSocket();
    void run();
    void receive();
    int takeTurn();

    const OscOptions _options;
    OscInbox _inbox;
    int _stop;        ///< a file descriptor that gets readable at the end
    int _socket = -1; ///< of the thread
    std::atomic<int> _port{0};
    std::thread _thread; ///< last: it uses the other members
};

} // namespace midair::bridge
