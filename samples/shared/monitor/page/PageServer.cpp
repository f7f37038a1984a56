#include "samples/shared/monitor/page/PageServer.h"

#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/monitor/page/BoundedStream.h"
#include "samples/shared/monitor/page/Metrics.h"
#include "samples/shared/monitor/page/MonitorToken.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <MonitorPage.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr const char* kTextType = "text/plain; charset=utf-8";
constexpr int kBacklog = 64;
constexpr std::chrono::milliseconds kPause{100};
/// Mutes that hang: each has a thread.
constexpr int kMostMutes = 8;
constexpr const char* kPolicy = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; "
                                "form-action 'none'";

/// Returns the one value of a header; empty if there is none, or several, of which each may be
/// meant.
std::string oneHeader(const httplib::Request& request, const char* name)
{
    return request.get_header_value_count(name) == 1 ? request.get_header_value(name)
                                                     : std::string();
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

/// Returns true for what a page of another site makes a browser send. Browsers say so themselves;
/// other programs say nothing.
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

bool isPage(const std::string& path)
{
    constexpr std::array<std::string_view, 6> kPages = {
        "/", "/status.json", "/metrics", "/healthz", "/picture", "/favicon.ico"};
    return std::find(kPages.begin(), kPages.end(), path) != kPages.end();
}

void showPage(httplib::Response& response)
{
    // It makes scripts and styles of this answer the page's own.
    const std::string nonce = newToken();
    const std::string place = "NONCE";
    std::string page = kPage;
    for (std::size_t at = page.find(place); at != std::string::npos; at = page.find(place, at))
        page.replace(at, place.size(), nonce);
    response.headers.erase("Content-Security-Policy");
    response.set_header("Content-Security-Policy",
                        fmt::format("{}; script-src 'nonce-{}'; style-src 'nonce-{}'; "
                                    "connect-src 'self'; img-src 'self' blob:",
                                    kPolicy,
                                    nonce,
                                    nonce));
    response.set_content(page, "text/html; charset=utf-8");
}

} // namespace

/// For the library, which ends it at errors that pass, too: no reason to hang up on anybody.
class PageServer::Queue : public httplib::TaskQueue
{
public:
    explicit Queue(PageServer& server) : _server(server) {}
    void enqueue(std::function<void()> serving) override { _server.take(std::move(serving)); }
    void shutdown() override {}

private:
    PageServer& _server;
};

PageServer::PageServer(std::string name,
                       PageAccess access,
                       std::shared_ptr<MonitorWatch> watch,
                       std::shared_ptr<PictureSource> picture,
                       const PageLimits& limits) :
    _name(std::move(name)),
    _access(std::move(access)),
    _watch(std::move(watch)),
    _picture(std::move(picture)),
    _limits(limits),
    _mutes(std::make_shared<std::atomic<int>>(0))
{
    ::sigaction(SIGPIPE, &before, nullptr);
    set_default_headers({{"Content-Security-Policy", kPolicy},
                         {"X-Content-Type-Options", "nosniff"},
                         {"X-Frame-Options", "DENY"},
                         {"Referrer-Policy", "no-referrer"},
                         {"Cross-Origin-Resource-Policy", "same-origin"},
                         {"Cross-Origin-Opener-Policy", "same-origin"},
                         {"Cache-Control", "no-store"}});
    // All is decided before the library looks for a handler, which it does by regular expressions,
    // and before it reads a body.
    set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response)
        {
            route(request, response);
            return HandlerResponse::Handled;
        });
    set_exception_handler([](const httplib::Request&, httplib::Response& response, const auto&)
                          { refuse(response, 500, "something went wrong here"); });
    // What is too long, too slow or no text ends for the library as if it were cut off.
    set_error_handler(
        [](const httplib::Request&, httplib::Response& response)
        {
            if (response.body.empty()) refuse(response, response.status, "that is no request");
        });
    // A port whose last connections are only just closed is free; one that another program listens
    // on isn't, as it would be with the library's own SO_REUSEPORT.
    set_socket_options(
        [](int socket)
        {
            const int on = 1;
            ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
        });
    new_task_queue = [this] { return new Queue(*this); };
}

PageServer::~PageServer()
{
    if (_listener >= 0) ::close(_listener);
}

int PageServer::listen(const MonitorAddress& address)
{
    const bool isAny = address.port == 0;
    const int any = isAny ? bind_to_any_port(address.host) : -1;
    const bool isBound = isAny ? any > 0 : bind_to_port(address.host, address.port);
    // The library lets five callers wait; a browser has more.
    if (!isBound || ::listen(svr_sock_, kBacklog) != 0)
        throw std::runtime_error(fmt::format(
            "can't listen on {}: {}", address.text(), std::generic_category().message(errno)));
    _listener = svr_sock_.exchange(INVALID_SOCKET);
    _threads.start("the operator's page", [self = shared_from_this()] { self->serveAll(); });
    return isAny ? any : address.port;
}

/// The library gives up at most errors of accept(), of which most pass: another program took the
/// last file, or a caller has gone.
void PageServer::serveAll()
{
    for (base::Lock lock(_mutex); !_isEnded;)
    {
        lock.unlock();
        svr_sock_ = ::fcntl(_listener, F_DUPFD_CLOEXEC, 0); // which the library closes
        if (svr_sock_ != INVALID_SOCKET) listen_after_bind();
        lock.lock();
        if (!_isEnded) _left.waitFor(lock, kPause);
    }
}

void PageServer::end()
{
    {
        const base::Lock lock(_mutex);
        _isEnded = true;
        for (const int socket : _sockets)
            ::shutdown(socket, SHUT_RDWR);
    }
    _left.notifyAll();
    ::shutdown(_listener, SHUT_RDWR);
    if (!_threads.finish(2.0))
        std::fprintf(stderr, "the operator's page: an answer hangs; it is left to itself\n");
}

/// Has a connection served by a thread. If there are too many it hangs up on the oldest: whoever
/// sends or reads slowly must not keep others out.
void PageServer::take(std::function<void()> serving)
{
    {
        base::Lock lock(_mutex);
        while (_taken >= _limits.connections)
        {
            if (!_sockets.empty()) ::shutdown(_sockets.front(), SHUT_RDWR);
            // The next one is hung up on if this one's answer is still being made.
            if (!_sockets.empty()) _sockets.splice(_sockets.end(), _sockets, _sockets.begin());
            _left.waitFor(lock, kPause);
        }
        ++_taken;
    }
    const auto serveAndLeave = [self = shared_from_this(), serving = std::move(serving)]
    {
        serving();
        const base::Lock lock(self->_mutex);
        --self->_taken;
        self->_left.notifyAll();
    };
    try
    {
        _threads.start("a thread of the operator's page", serveAndLeave);
    }
    catch (const std::system_error&)
    {
        serveAndLeave(); // there is no thread but this one
    }
}

bool PageServer::process_and_close_socket(int socket)
{
    serve(socket);
    return true;
}

void PageServer::serve(int socket)
{
    ::fcntl(socket, F_SETFD, FD_CLOEXEC);
    {
        const base::Lock lock(_mutex);
        _sockets.push_back(socket);
        if (_isEnded) ::shutdown(socket, SHUT_RDWR);
    }
    BoundedStream stream(socket, _limits);
    try
    {
        bool isClosed = false;
        // Parts and compressed answers aren't given.
        process_request(stream,
                        true,
                        isClosed,
                        [](httplib::Request& request)
                        {
                            request.ranges.clear();
                            request.headers.erase("Range");
                            request.headers.erase("Accept-Encoding");
                        });
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "the operator's page hangs up: %s\n", error.what());
    }
    {
        // Whoever has an answer is the first to be hung up on where others wait for one.
        const base::Lock lock(_mutex);
        _sockets.remove(socket);
        _sockets.push_front(socket);
    }
    stream.finish();
    {
        const base::Lock lock(_mutex);
        if (stream.status() > 0) ++_counts.answers[stream.status()];
        _sockets.remove(socket);
    }
    ::close(socket);
}

MonitorState PageServer::state() const
{
    MonitorState state;
    state.name = _name;
    state.view = _watch->view();
    state.now_s = base::steadySeconds();
    state.picture.problem = "this program shows none";
    if (_picture) state.picture = _picture->cost();
    const base::Lock lock(_mutex);
    state.page = _counts;
    return state;
}

void PageServer::route(const httplib::Request& request, httplib::Response& response)
{
    if (!isTrustedHost(oneHeader(request, "Host"), _access.hosts))
        return refuse(
            response, 421, "this page isn't known by that name; --monitor-host NAME makes it so");
    if (isForeign(request))
        return refuse(response, 403, "another site's page may not use this one");
    if (hasBody(request)) return refuse(response, 413, "no request has a body here");
    const bool isAction = request.path == "/mute" || request.path == "/unmute";
    const bool isLook = request.method == "GET" || request.method == "HEAD";
    if (!isAction && !isPage(request.path)) return refuse(response, 404, "there is no such page");
    if (isAction ? request.method != "POST" : !isLook)
    {
        response.set_header("Allow", isAction ? "POST" : "GET, HEAD");
        return refuse(response, 405, isAction ? "it takes a POST" : "it takes a GET");
    }
    if (isAction) return mute(request, response);
    show(request.path, response);
}

void PageServer::show(const std::string& path, httplib::Response& response) const
{
    if (path == "/") return showPage(response);
    if (path == "/picture") return showPicture(response);
    if (path == "/status.json")
        return response.set_content(statusJson(state()), "application/json");
    if (path == "/metrics")
        return response.set_content(metricsText(state()),
                                    "text/plain; version=0.0.4; charset=utf-8");
    if (path == "/favicon.ico")
    {
        response.status = 204;
        return;
    }
    const std::string problem = healthProblem(state());
    if (!problem.empty()) return refuse(response, 503, problem);
    response.set_content("ok\n", kTextType);
}

void PageServer::showPicture(httplib::Response& response) const
{
    const MonitorPicture picture = _picture ? _picture->newest() : MonitorPicture();
    if (picture.bytes.empty())
    {
        const std::string problem = _picture ? _picture->cost().problem : "";
        return refuse(response, 503, problem.empty() ? "there is no picture yet" : problem);
    }
    response.set_header("X-Midair-Age-ms",
                        fmt::format("{:.0f}", 1e3 * (base::steadySeconds() - picture.taken_s)));
    response.set_content(picture.bytes, picture.type);
}

void PageServer::mute(const httplib::Request& request, httplib::Response& response) const
{
    constexpr std::string_view kScheme = "Bearer ";
    const std::string given = oneHeader(request, "Authorization");
    // The scheme's case doesn't matter (RFC 9110, 11.1).
    const bool isToken = ::strncasecmp(given.c_str(), kScheme.data(), kScheme.size()) == 0 &&
                         isSameToken(given.substr(kScheme.size()), _access.token);
    const std::string what = request.path.substr(1);
    if (!isToken)
    {
        if (!given.empty())
            _watch->note(
                fmt::format("refused: {} with a wrong token by {}", what, request.remote_addr));
        response.set_header("WWW-Authenticate", "Bearer");
        return refuse(response, 401, "the token is missing or wrong");
    }
    act(what == "mute",
        operatorName(oneHeader(request, "X-Midair-Operator"), request.remote_addr),
        response);
}

/// The source may hang; it does so on a thread that is left behind, and the operator is told.
void PageServer::act(bool isMute, const std::string& who, httplib::Response& response) const
{
    const auto outcome = std::make_shared<std::optional<MuteOutcome>>();
    const std::shared_ptr<void> counted(nullptr, [mutes = _mutes](void*) { --*mutes; });
    if (++*_mutes > kMostMutes) return refuse(response, 503, "the mutes before this one hang");
    PatientThreads thread;
    thread.start("a mute of the operator's page",
                 [isMute, who, outcome, counted, watch = _watch]
                 { *outcome = watch->setMuted(isMute, who); });
    if (!thread.finish(_limits.mute_s))
        return refuse(response,
                      504,
                      "the program doesn't answer: whatever was asked for may not have been "
                      "done");
    if (!*outcome) return refuse(response, 500, "something went wrong here");
    response.set_content(muteJson(isMute, **outcome), "application/json");
}

} // namespace midair::samples
