#include "samples/shared/monitor/Monitor.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/monitor/page/MonitorAccess.h"
#include "samples/shared/monitor/page/MonitorTexts.h"
#include "samples/shared/monitor/page/MonitorWatch.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <future>
#include <map>
#include <regex>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <MonitorPage.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <netdb.h>
#include <poll.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

using std::chrono::milliseconds;

constexpr const char* kTextType = "text/plain; charset=utf-8";
/// Concurrent connections, each with a thread; others wait in the system's queue.
constexpr std::size_t kConnections = 16;
constexpr int kBacklog = 64;                   ///< length of that queue
constexpr std::size_t kHeadBytes = 16384;      ///< largest head of a request
constexpr double kHead_s = 3.0;                ///< time limit for the head
constexpr double kAnswer_s = 10.0;             ///< time limit for the answer
constexpr double kDrain_s = 0.5;               ///< drains unread bytes at most so long ..
constexpr std::size_t kDrainBytes = 1U << 17U; ///< .. and at most so many
constexpr milliseconds kMuteWait{4000};        ///< before the program counts as hanging
constexpr milliseconds kEndWait{5000};         ///< for requests in progress
constexpr milliseconds kPause{100};
/// Limit of hanging mutes, because each holds a thread.
constexpr int kMostMutes = 8;
constexpr const char* kPolicy = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; "
                                "form-action 'none'";

/// Returns the value of a header, or an empty text if it is missing or repeated.
std::string oneHeader(const httplib::Request& request, const char* name)
{
    return request.get_header_value_count(name) == 1 ? request.get_header_value(name)
                                                     : std::string();
}

/// Returns the peer's address; an IPv4-mapped IPv6 address is written as IPv4.
std::string peerOf(const httplib::Request& request)
{
    const std::string& address = request.remote_addr;
    return address.compare(0, 7, "::ffff:") == 0 ? address.substr(7) : address;
}

void refuse(httplib::Response& response, int status, const std::string& text)
{
    response.status = status;
    response.set_content(text + "\n", kTextType);
}

bool hasBody(const httplib::Request& request)
{
    if (request.has_header("Transfer-Encoding")) return true;
    return request.has_header("Content-Length") && oneHeader(request, "Content-Length") != "0";
}

/// Returns true for requests that another site's page makes a browser send. Browsers mark them with
/// headers; other programs send none.
bool isForeign(const httplib::Request& request)
{
    if (request.has_header("Sec-Fetch-Site"))
    {
        const std::string site = oneHeader(request, "Sec-Fetch-Site");
        const bool isFollowedLink = request.method == "GET" && request.path == "/" &&
                                    oneHeader(request, "Sec-Fetch-Mode") == "navigate";
        if (site != "same-origin" && site != "none" && !isFollowedLink) return true;
    }
    if (!request.has_header("Origin")) return false;
    const std::string origin = oneHeader(request, "Origin");
    const std::string host = oneHeader(request, "Host");
    return origin != "http://" + host && origin != "https://" + host;
}

/// The library's threads. Connections beyond the limit wait in the system's queue and use no file
/// descriptor.
class BoundedPool : public httplib::ThreadPool
{
public:
    /// \a ends is called when the library has stopped listening.
    explicit BoundedPool(std::function<void()> ends) :
        ThreadPool(kConnections),
        _ends(std::move(ends))
    {
    }

    void shutdown() override
    {
        _ends();
        ThreadPool::shutdown();
    }

    void enqueue(std::function<void()> serve) override
    {
        base::Lock lock(_mutex);
        while (_taken == kConnections)
            _left.wait(lock);
        ++_taken;
        ThreadPool::enqueue(
            [this, serve = std::move(serve)]
            {
                serve();
                const base::Lock leaving(_mutex);
                --_taken;
                _left.notifyOne();
            });
    }

private:
    const std::function<void()> _ends;
    base::Mutex _mutex;
    base::Condition _left;
    std::size_t _taken MIDAIR_GUARDED_BY(_mutex) = 0;
};

/// A connection with limits of time and size for the whole head and answer. The library's own
/// stream limits only the time of each read and not the line length, so a slow or endless sender
/// could hold a thread or the memory forever.
class BoundedStream : public httplib::Stream
{
public:
    explicit BoundedStream(int socket) : _socket(socket) {}

    /// The library reads one byte at a time, and none after the head.
    ssize_t read(char* to, std::size_t size) override
    {
        if (_head == kHeadBytes || !isReady(POLLIN, _headEnd_s)) return -1;
        const ssize_t got = ::recv(_socket, to, std::min(size, kHeadBytes - _head), MSG_DONTWAIT);
        _head += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
        return got;
    }
    ssize_t write(const char* from, std::size_t size) override
    {
        if (_answerEnd_s == 0.0) _answerEnd_s = base::steadySeconds() + kAnswer_s;
        std::size_t done = 0;
        while (done < size)
        {
            if (!isReady(POLLOUT, _answerEnd_s)) return -1;
            const ssize_t sent =
                ::send(_socket, from + done, size - done, MSG_NOSIGNAL | MSG_DONTWAIT);
            if (sent < 0) return -1;
            done += static_cast<std::size_t>(sent);
        }
        return static_cast<ssize_t>(size);
    }
    /// Drains the other side's data: closing a socket with unread bytes would reset the connection
    /// and lose the answer.
    void finish() const
    {
        ::shutdown(_socket, SHUT_WR);
        std::array<char, 4096> rest{};
        const double end_s = base::steadySeconds() + kDrain_s;
        for (std::size_t left = kDrainBytes; left > 0 && isReady(POLLIN, end_s);)
        {
            const ssize_t got =
                ::recv(_socket, rest.data(), std::min(left, rest.size()), MSG_DONTWAIT);
            if (got <= 0) return;
            left -= static_cast<std::size_t>(got);
        }
    }
    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    void get_remote_ip_and_port(std::string& address, int&) const override
    {
        sockaddr_storage peer{};
        socklen_t size = sizeof(peer);
        auto* const any = reinterpret_cast<sockaddr*>(&peer);
        std::array<char, NI_MAXHOST> text{};
        if (::getpeername(_socket, any, &size) == 0 &&
            ::getnameinfo(any, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0)
            address = text.data();
    }
    void get_local_ip_and_port(std::string&, int&) const override {}
    socket_t socket() const override { return _socket; }

private:
    /// Waits until the socket can be read (POLLIN) or written (POLLOUT), or the other side has hung
    /// up. Returns false after \a end_s.
    bool isReady(short events, double end_s) const
    {
        pollfd polled{_socket, events, 0};
        for (double left_s = 1.0; left_s > 0.0;)
        {
            left_s = end_s - base::steadySeconds();
            if (left_s > 0.0 && ::poll(&polled, 1, 1 + static_cast<int>(1e3 * left_s)) > 0)
                return true;
        }
        return false;
    }

    const int _socket;
    const double _headEnd_s = base::steadySeconds() + kHead_s;
    double _answerEnd_s = 0.0; ///< 0: nothing written yet
    std::size_t _head = 0;     ///< bytes so far
};

} // namespace

/// The library's server with such streams, one request per connection.
class BoundedServer : public httplib::Server
{
public:
    /// The library's server makes the whole program ignore SIGPIPE, so restore the program's own
    /// setting. Threads of the page block all signals.
    static std::unique_ptr<BoundedServer> make()
    {
        struct sigaction before = {};
        ::sigaction(SIGPIPE, nullptr, &before);
        auto server = std::make_unique<BoundedServer>();
        ::sigaction(SIGPIPE, &before, nullptr);
        return server;
    }
    ~BoundedServer() override
    {
        if (_listener >= 0) ::close(_listener);
    }
    /// Keeps the bound port even if the library closes its own socket.
    bool keepPort()
    {
        _listener = ::fcntl(svr_sock_, F_DUPFD_CLOEXEC, 0);
        return _listener >= 0 && ::listen(_listener, kBacklog) == 0;
    }
    /// For use after the library has closed its socket because of an error of accept(): stop()
    /// would close an unrelated file with the same number.
    void renewSocket()
    {
        if (svr_sock_ != INVALID_SOCKET) svr_sock_ = ::fcntl(_listener, F_DUPFD_CLOEXEC, 0);
    }
    /// Hangs up on all connections from now on.
    void setEnded() { _isEnded = true; }

private:
    bool process_and_close_socket(int socket) override
    {
        ::fcntl(socket, F_SETFD, FD_CLOEXEC);
        if (!_isEnded) serve(socket);
        ::close(socket);
        return true;
    }
    void serve(int socket)
    try
    {
        BoundedStream stream(socket);
        bool isClosed = false;
        // Ranges and compressed answers are not supported.
        process_request(stream,
                        true,
                        isClosed,
                        [](httplib::Request& request)
                        {
                            request.ranges.clear();
                            request.headers.erase("Range");
                            request.headers.erase("Accept-Encoding");
                        });
        stream.finish();
    }
    catch (...)
    {
        std::fprintf(
            stderr, "the operator's page: connection closed: %s\n", base::whatWasThrown().c_str());
    }

    int _listener = -1;
    std::atomic<bool> _isEnded{false};
};

/// Answers HTTP requests, one per connection:
///
///     GET  /  /status.json  /metrics  /healthz  /picture  /favicon.ico
///     POST /mute  /unmute      with "Authorization: Bearer TOKEN"
///
/// Refuses an untrusted Host (421), requests of another site's page (403; links to / are allowed),
/// a body (413) and a POST without the token (401).
class Monitor::Page : public std::enable_shared_from_this<Page>
{
public:
    Page(std::string name,
         std::string token,
         std::vector<std::string> hosts,
         std::shared_ptr<MonitorSource> source) :
        _name(std::move(name)),
        _token(std::move(token)),
        _hosts(std::move(hosts)),
        _source(std::move(source)),
        _watch(std::make_shared<MonitorWatch>(_source))
    {
        limit();
        answer();
    }

    /// Starts serving on \a address. Returns the port. Throws std::runtime_error: "can't listen on
    /// 127.0.0.1:8080: Address already in use".
    int listen(const MonitorAddress& address)
    {
        const bool isAny = address.port == 0;
        const int any = isAny ? _server->bind_to_any_port(address.host) : 0;
        const bool isBound = isAny ? any > 0 : _server->bind_to_port(address.host, address.port);
        if (!isBound || !_server->keepPort())
            throw std::runtime_error(fmt::format(
                "can't listen on {}: {}", address.text(), std::generic_category().message(errno)));
        _watch->begin();
        _serving = startThread([self = shared_from_this()] { self->serve(); });
        return isAny ? any : address.port;
    }

    /// Stops listening and waits for requests in progress.
    void end()
    {
        _isEnded = true;
        _server->setEnded();
        // A stop before the server runs would be lost.
        while (!_server->is_running() &&
               _serving.wait_for(milliseconds(1)) != std::future_status::ready)
        {
        }
        _server->stop();
        if (_serving.wait_for(kEndWait) != std::future_status::ready)
            std::fprintf(stderr, "the operator's page: an answer hangs and is abandoned\n");
        _watch->end();
    }

private:
    void limit()
    {
        _server->new_task_queue = [this]
        { return new BoundedPool([this] { _server->renewSocket(); }); };
        // Allows a port whose last connections have just closed, but not one that another program
        // listens on, which the library's own SO_REUSEPORT would allow.
        _server->set_socket_options(
            [](int socket)
            {
                const int on = 1;
                ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
            });
    }

    void answer()
    {
        _server->set_default_headers({{"Content-Security-Policy", kPolicy},
                                      {"X-Content-Type-Options", "nosniff"},
                                      {"X-Frame-Options", "DENY"},
                                      {"Referrer-Policy", "no-referrer"},
                                      {"Cross-Origin-Resource-Policy", "same-origin"},
                                      {"Cross-Origin-Opener-Policy", "same-origin"},
                                      {"Cache-Control", "no-store"}});
        // Routes requests before the library's own routing, which uses regular expressions, and
        // before it reads a body.
        _server->set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response)
            {
                route(request, response);
                return httplib::Server::HandlerResponse::Handled;
            });
        _server->set_exception_handler(
            [](const httplib::Request&, httplib::Response& response, const auto&)
            { refuse(response, 500, "internal error"); });
        _server->set_error_handler(
            [](const httplib::Request&, httplib::Response& response)
            {
                if (response.body.empty()) refuse(response, response.status, "bad request");
            });
        _server->set_logger(
            [this](const httplib::Request&, const httplib::Response& response)
            {
                const base::Lock lock(_mutex);
                ++_answers[response.status];
            });
    }

    /// The library stops listening after most errors of accept(). Most are temporary: no free file
    /// descriptor, or a caller has gone.
    void serve()
    {
        while (!_server->listen_after_bind() && !_isEnded)
        {
            std::fprintf(stderr, "the operator's page: a connection failed; still listening\n");
            std::this_thread::sleep_for(kPause);
        }
    }

    MonitorState state() const
    {
        MonitorState state{_name, 0.0, _watch->view(), _source->pictureCost(), {}};
        state.now_s = base::steadySeconds();
        const base::Lock lock(_mutex);
        state.answers = _answers;
        return state;
    }

    void route(const httplib::Request& request, httplib::Response& response)
    {
        if (!isTrustedHost(oneHeader(request, "Host"), _hosts))
            return refuse(response, 421, "unknown host name; allow it with --monitor-host NAME");
        if (isForeign(request))
            return refuse(response, 403, "requests from other sites are refused");
        if (hasBody(request)) return refuse(response, 413, "requests with a body are refused");
        const bool isAction = request.path == "/mute" || request.path == "/unmute";
        const auto shown = _looks.find(request.path);
        if (!isAction && shown == _looks.end()) return refuse(response, 404, "page not found");
        const bool isLook = request.method == "GET" || request.method == "HEAD";
        if (isAction ? request.method != "POST" : !isLook)
        {
            response.set_header("Allow", isAction ? "POST" : "GET, HEAD");
            return refuse(response, 405, isAction ? "use POST" : "use GET");
        }
        if (isAction) return mute(request, response);
        (this->*shown->second)(response);
    }

    void showPage(httplib::Response& response) const
    {
        // Only scripts and styles with this answer's nonce are allowed.
        const std::string nonce = newToken();
        response.headers.erase("Content-Security-Policy");
        response.set_header("Content-Security-Policy",
                            fmt::format("{}; script-src 'nonce-{}'; style-src 'nonce-{}'; "
                                        "connect-src 'self'; img-src 'self' blob:",
                                        kPolicy,
                                        nonce,
                                        nonce));
        response.set_content(std::regex_replace(kPage, std::regex("NONCE"), nonce),
                             "text/html; charset=utf-8");
    }
    void showStatus(httplib::Response& response) const
    {
        response.set_content(statusJson(state()), "application/json");
    }
    void showMetrics(httplib::Response& response) const
    {
        response.set_content(metricsText(state()), "text/plain; version=0.0.4; charset=utf-8");
    }
    void showHealth(httplib::Response& response) const
    {
        const std::string problem = healthProblem(state());
        if (!problem.empty()) return refuse(response, 503, problem);
        response.set_content("ok\n", kTextType);
    }
    void showNoIcon(httplib::Response& response) const { response.status = 204; }
    void showPicture(httplib::Response& response) const
    {
        const MonitorPicture picture = _source->picture();
        if (picture.jpeg.empty())
        {
            const std::string problem = _source->pictureCost().problem;
            return refuse(response, 503, problem.empty() ? "there is no picture yet" : problem);
        }
        response.set_header("X-Midair-Age-ms",
                            fmt::format("{:.0f}", 1e3 * (base::steadySeconds() - picture.taken_s)));
        response.set_content(picture.jpeg, "image/jpeg");
    }

    void mute(const httplib::Request& request, httplib::Response& response)
    {
        constexpr std::string_view kScheme = "Bearer ";
        const std::string given = oneHeader(request, "Authorization");
        // The scheme is case-insensitive (RFC 9110, 11.1).
        const bool isToken = ::strncasecmp(given.c_str(), kScheme.data(), kScheme.size()) == 0 &&
                             isSameToken(given.substr(kScheme.size()), _token);
        const std::string what = request.path.substr(1);
        if (!isToken)
        {
            if (!given.empty())
                _watch->note(
                    fmt::format("refused: {} with a wrong token by {}", what, peerOf(request)));
            response.set_header("WWW-Authenticate", "Bearer");
            return refuse(response, 401, "the token is missing or wrong");
        }
        act(what == "mute",
            operatorName(oneHeader(request, "X-Midair-Operator"), peerOf(request)),
            response);
    }

    /// The source may hang: it is called on a separate thread, which is then abandoned, and the
    /// operator is told.
    void act(bool isMute, const std::string& who, httplib::Response& response)
    {
        const auto outcome = std::make_shared<MuteOutcome>();
        const std::shared_ptr<void> counted(nullptr,
                                            [self = shared_from_this()](void*) { --self->_mutes; });
        if (++_mutes > kMostMutes)
            return refuse(response, 503, "earlier mutes are still waiting for the program");
        std::future<void> done = startThread([isMute, who, outcome, counted, watch = _watch]
                                             { *outcome = watch->setMuted(isMute, who); });
        if (done.wait_for(kMuteWait) != std::future_status::ready)
            return refuse(response,
                          504,
                          "the program doesn't answer; the request may not have been carried out");
        done.get(); // throws what the source has thrown
        response.set_content(muteJson(isMute, *outcome), "application/json");
    }

    const std::map<std::string, void (Page::*)(httplib::Response&) const> _looks = {
        {"/", &Page::showPage},
        {"/status.json", &Page::showStatus},
        {"/metrics", &Page::showMetrics},
        {"/healthz", &Page::showHealth},
        {"/picture", &Page::showPicture},
        {"/favicon.ico", &Page::showNoIcon}};
    const std::string _name;
    const std::string _token;
    const std::vector<std::string> _hosts; ///< names for isTrustedHost()
    const std::shared_ptr<MonitorSource> _source;
    const std::shared_ptr<MonitorWatch> _watch;
    const std::unique_ptr<BoundedServer> _server = BoundedServer::make();
    std::future<void> _serving;
    std::atomic<bool> _isEnded{false};
    std::atomic<int> _mutes{0}; ///< in progress

    mutable base::Mutex _mutex;
    std::map<int, std::uint64_t> _answers MIDAIR_GUARDED_BY(_mutex); ///< by HTTP status
};

Monitor::Monitor(const MonitorOptions& options,
                 const std::string& name,
                 std::shared_ptr<MonitorSource> source)
{
    MonitorAddress address;
    try
    {
        address = MonitorAddress::parse(options.address);
    }
    catch (const std::exception& error)
    {
        throw std::runtime_error(std::string("--monitor: ") + error.what());
    }
    _token = options.tokenFile.empty() ? newToken() : tokenOfFile(options.tokenFile);
    _page = std::make_shared<Page>(name, _token, options.hosts, std::move(source));
    address.port = _port = _page->listen(address);
    const std::string secret = options.tokenFile.empty()
                                   ? "#token=" + _token
                                   : fmt::format(" (its token is in {})", options.tokenFile);
    std::fprintf(
        stderr, "the operator's page is http://%s/%s\n", address.text().c_str(), secret.c_str());
    if (!address.isLoopback())
        std::fprintf(
            stderr,
            "the operator's page is visible to everybody who can reach %s and is not encrypted\n",
            address.text().c_str());
}

Monitor::~Monitor()
{
    _page->end();
}

} // namespace midair::samples
