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

/// An internet address and a port.
class SocketAddress
{
public:
    /// \a address: numeric, IPv4 or IPv6; names would need the network. \a port: 0 .. 65535. Throws
    /// base::InputError.
    static SocketAddress parse(const std::string& address, int port);
    /// Returns the address that \a socket is bound to.
    static SocketAddress boundTo(int socket);

    int family() const { return _address.ss_family; }
    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&_address); }
    socklen_t size() const { return _size; }
    int port() const;

private:
    sockaddr_storage _address{};
    socklen_t _size = sizeof(sockaddr_storage);
};

/// Address for receiving datagrams.
struct OscOptions
{
    std::string address = "127.0.0.1"; ///< numeric, IPv4 or IPv6; 0.0.0.0: all of the machine
    int port = 9000;                   ///< 0 .. 65535; 0: any free one, for tests
};

bool operator==(const OscOptions& a, const OscOptions& b);

/// Receives hands by OSC over UDP, on a separate thread. A port that can't be opened is tried
/// again, with pauses from 1 s to 30 s. Reads at most kMostInTurn datagrams a millisecond, so that
/// a flood doesn't use a whole core; the system drops the rest.
class OscReceiver
{
public:
    static constexpr int kMostInTurn = 64;

    /// Returns the receiver for these options; callers with equal options share one, because a port
    /// can be bound only once.
    static std::shared_ptr<OscReceiver> open(const OscOptions& options);

    /// Throws base::InputError if \a options have an invalid address.
    explicit OscReceiver(const OscOptions& options);
    ~OscReceiver();
    OscReceiver(const OscReceiver&) = delete;
    OscReceiver& operator=(const OscReceiver&) = delete;

    const OscInbox& inbox() const { return _inbox; }
    int port() const { return _port; } ///< 0: not open yet; any thread

    /// One line of text: its address, and counts. Any thread.
    std::string status() const;

private:
    bool bindSocket();
    void run();
    void receive();
    int takeTurn();

    const OscOptions _options;
    OscInbox _inbox;
    int _stop;        ///< a file descriptor that becomes readable at the end
    int _socket = -1; ///< of the thread
    std::atomic<int> _port{0};
    std::thread _thread; ///< last: it uses the other members
};

/// The hands that come by OSC now, for any requested time.
class OscHandSource : public HandSource
{
public:
    /// \a placement maps the sender's space to the scene's world, in metres. Throws
    /// base::InputError if \a options have an invalid address.
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

/// Takes address= and port= of "osc:?..", for receiving or sending.
inline OscOptions takeOscOptions(device::DeviceUri& uri)
{
    uri.rejectPath();
    OscOptions options;
    options.address = uri.takeText("address", options.address);
    options.port = static_cast<int>(uri.takeNumber("port", options.port, 1, 65535));
    return options;
}

} // namespace midair::bridge
