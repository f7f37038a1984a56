#include "samples/installations/shell/ServiceNotifier.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace midair::samples
{

ServiceNotifier::ServiceNotifier()
{
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody here changes the environment
    const char* address = std::getenv("NOTIFY_SOCKET");
    if (!address || (*address != '/' && *address != '@') ||
        std::strlen(address) >= sizeof(sockaddr_un::sun_path))
        return;
    _address = address;
    _socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody here changes the environment
    if (const char* limit = std::getenv("WATCHDOG_USEC"))
        _interval_s = std::clamp(std::atof(limit) * 1e-6 / 3.0, 0.01, 1.0);
}

ServiceNotifier::~ServiceNotifier()
{
    if (_socket >= 0) ::close(_socket);
}

void ServiceNotifier::beat(double now_s, const std::string& status)
{
    if (_socket < 0 || now_s - _last_s < _interval_s) return;
    _last_s = now_s;
    send(std::string(_isReady ? "" : "READY=1\n") + "WATCHDOG=1\nSTATUS=" + status);
    _isReady = true;
}

void ServiceNotifier::stop()
{
    if (_socket >= 0) send("STOPPING=1");
}

// A datagram that can't be sent is dropped: the next one follows soon, and frames never wait.
void ServiceNotifier::send(const std::string& text) const
{
    sockaddr_un to = {};
    to.sun_family = AF_UNIX;
    std::memcpy(to.sun_path, _address.data(), _address.size());
    if (to.sun_path[0] == '@') to.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + _address.size());
    static_cast<void>(::sendto(_socket,
                               text.data(),
                               text.size(),
                               MSG_NOSIGNAL,
                               reinterpret_cast<const sockaddr*>(&to),
                               length));
}

} // namespace midair::samples
