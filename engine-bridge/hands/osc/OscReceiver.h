#pragma once

#include "device/DeviceUri.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/osc/OscInbox.h"
#include "haptics/base/InputError.h"

#include <Eigen/Geometry>

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <sys/socket.h>

namespace midair::bridge
{

/// An address of the internet and a port.
class SocketAddress
{
public:
    /// \a address: numeric, IPv4 or IPv6, no name, for which the network would be asked. \a port: 0
    /// .. 65535. Throws base::InputError.
    static SocketAddress parse(const std::string& address, int port);
    /// What \a socket is bound to.
    static SocketAddress boundTo(int socket);

    int family() const { return _address.ss_family; }
    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&_address); }
    socklen_t size() const { return _size; }
    int port() const;

private:
    sockaddr_storage _address{};
    socklen_t _size = sizeof(sockaddr_storage);
};

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

/// The hands that come by OSC now, whatever time is asked for.
class OscHandSource : public HandSource
{
public:
    /// \a placement maps the sender's space to the world of the scene, in metres. Throws
    /// base::InputError if \a options have no address.
    explicit OscHandSource(const OscOptions& options,
                           const Eigen::Isometry3d& placement = Eigen::Isometry3d::Identity());

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override { return _receiver->status(); }

    std::vector<std::string> takeMessages() override { return _receiver->inbox().messages(_told); }

    const OscReceiver& receiver() const { return *_receiver; }

private:
    std::shared_ptr<OscReceiver> _receiver;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

/// Takes address= and port= of "osc:?..": what a source listens at, and where a sender sends to.
inline OscOptions takeOscOptions(device::DeviceUri& uri)
{
    uri.rejectPath();
    OscOptions options;
    options.address = uri.takeText("address", options.address);
    options.port = static_cast<int>(uri.takeNumber("port", options.port, 1, 65535));
    return options;
}

} // namespace midair::bridge
