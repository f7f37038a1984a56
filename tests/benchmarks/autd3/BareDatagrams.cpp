#include "tests/benchmarks/autd3/BareDatagrams.h"

#include "haptics/base/threads/SteadyClock.h"
#include "tests/benchmarks/Timing.h"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace
{

/// A socket on loopback with a port of its own.
class Socket
{
public:
    Socket() : _socket(::socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0))
    {
        at.sin6_family = AF_INET6;
        at.sin6_addr = in6addr_loopback;
        socklen_t size = sizeof at;
        auto* address = reinterpret_cast<sockaddr*>(&at);
        if (_socket < 0 || ::bind(_socket, address, size) != 0 ||
            ::getsockname(_socket, address, &size) != 0)
            std::_Exit(1);
    }
    ~Socket() { ::close(_socket); }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;

    ssize_t receive(sockaddr_in6& from, int flags)
    {
        socklen_t size = sizeof from;
        return ::recvfrom(_socket,
                          _bytes.data(),
                          _bytes.size(),
                          flags,
                          reinterpret_cast<sockaddr*>(&from),
                          &size);
    }
    void send(const sockaddr_in6& to, std::size_t bytes)
    {
        ::sendto(
            _socket, _bytes.data(), bytes, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }

    sockaddr_in6 at{};

private:
    int _socket;
    std::array<char, 64> _bytes{};
};

} // namespace

double bareDatagrams(int units, double beat_s, double duration_s)
{
    constexpr std::size_t kBeatBytes = 4;
    constexpr std::size_t kAnswerBytes = 16;
    Socket unit;
    const pid_t process = ::fork();
    if (process == 0)
    {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (sockaddr_in6 from{};;)
            if (unit.receive(from, 0) > 0) unit.send(from, kAnswerBytes);
    }
    Socket host;
    const double before_s = 1e-3 * midair::bench::cpu_ms();
    const double begin_s = midair::base::steadySeconds();
    double now_s = begin_s;
    for (int n = 1; now_s - begin_s < duration_s; ++n)
    {
        for (int k = 0; k < units; ++k)
            host.send(unit.at, kBeatBytes);
        const double next_s = begin_s + n * beat_s;
        std::this_thread::sleep_for(std::chrono::duration<double>(next_s - now_s));
        sockaddr_in6 from{};
        while (host.receive(from, MSG_DONTWAIT) > 0)
            ;
        now_s = midair::base::steadySeconds();
    }
    const double used_s = 1e-3 * midair::bench::cpu_ms() - before_s;
    ::kill(process, SIGKILL);
    ::waitpid(process, nullptr, 0);
    return used_s / (now_s - begin_s);
}
