#pragma once

#include <array>
#include <chrono>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

/// A connection to a port of this machine, byte by byte.
class RawClient
{
public:
    explicit RawClient(int port) : _socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
    {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        _isOpen =
            ::connect(_socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
    }
    ~RawClient() { ::close(_socket); }
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    bool isOpen() const { return _isOpen; }
    bool send(const std::string& bytes) const
    {
        return ::send(_socket, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
               static_cast<ssize_t>(bytes.size());
    }
    void finish() const { ::shutdown(_socket, SHUT_WR); }

    /// Returns what comes until the other side hangs up, or for at most so long.
    std::string receive(double atMost_s = 20.0) const
    {
        const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(atMost_s);
        std::string all;
        std::array<char, 4096> buffer{};
        while (std::chrono::steady_clock::now() < end)
        {
            pollfd polled{_socket, POLLIN, 0};
            if (::poll(&polled, 1, 50) <= 0) continue;
            const ssize_t got = ::recv(_socket, buffer.data(), buffer.size(), 0);
            if (got <= 0) break;
            all.append(buffer.data(), static_cast<std::size_t>(got));
        }
        return all;
    }

private:
    int _socket;
    bool _isOpen = false;
};

/// Returns the head of a request with \a lines of headers, each ended by "\r\n".
inline std::string requestHead(const std::string& line, const std::string& lines = {})
{
    return line + " HTTP/1.1\r\nHost: localhost\r\n" + lines + "\r\n";
}

/// Returns the status of an answer; 0: it is none.
inline int statusOf(const std::string& answer)
{
    if (answer.compare(0, 9, "HTTP/1.1 ") != 0 || answer.size() < 12) return 0;
    return std::stoi(answer.substr(9, 3));
}

inline std::string bodyOf(const std::string& answer)
{
    const std::size_t end = answer.find("\r\n\r\n");
    return end == std::string::npos ? std::string() : answer.substr(end + 4);
}
