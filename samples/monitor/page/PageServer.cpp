#include "samples/monitor/page/PageServer.h"

#include "samples/monitor/page/Metrics.h"
#include "samples/monitor/page/MonitorToken.h"
#include "samples/monitor/page/Page.h"
#include "samples/monitor/server/MonitorAddress.h"
#include "samples/monitor/server/PlainAnswer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <mutex>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <httplib.h>
#include <strings.h>

namespace midair::samples
{

namespace
{

constexpr const char* kTextType = "text/plain; charset=utf-8";
constexpr const char* kPolicy = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; "
                                "form-action 'none'";

/// A request's text as the library reads it; keeps what it writes.
class TextStream : public httplib::Stream
{
public:
    TextStream(std::string_view text, std::string peer) : _left(text), _peer(std::move(peer)) {}

    std::string take() { return std::move(_written); }

    bool is_readable() const override { return !_left.empty(); }
    bool is_writable() const override { return true; }
    ssize_t read(char* to, std::size_t size) override
    {
        const std::size_t count = std::min(size, _left.size());
        std::memcpy(to, _left.data(), count);
        _left.remove_prefix(count);
        return static_cast<ssize_t>(count);
    }
    ssize_t write(const char* from, std::size_t size) override
    {
        _written.append(from, size);
        return static_cast<ssize_t>(size);
    }
    void get_remote_ip_and_port(std::string& address, int& port) const override
    {
        address = _peer;
        port = 0;
    }
    void get_local_ip_and_port(std::string& address, int& port) const override
    {
        address.clear();
        port = 0;
    }
    socket_t socket() const override { return 0; }

private:
    std::string_view _left;
    std::string _peer;
    std::string _written;
};

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

/// Returns what makes scripts and styles of this answer the page's own.
std::string newNonce()
{
    return newToken();
}

double steadyNow_s()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace

class PageServer::Http : private httplib::Server
{
public:
    Http(std::string name,
         PageAccess access,
         std::shared_ptr<MonitorWatch> watch,
         std::shared_ptr<PictureSource> picture) :
        _name(std::move(name)),
        _access(std::move(access)),
        _watch(std::move(watch)),
        _picture(std::move(picture))
    {
        set_default_headers({{"Content-Security-Policy", kPolicy},
                             {"X-Content-Type-Options", "nosniff"},
                             {"X-Frame-Options", "DENY"},
                             {"Referrer-Policy", "no-referrer"},
                             {"Cross-Origin-Resource-Policy", "same-origin"},
                             {"Cross-Origin-Opener-Policy", "same-origin"},
                             {"Cache-Control", "no-store"}});
        // All is decided before the library looks for a handler, which it does by regular
        // expressions, and before it reads a body.
        set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response)
            {
                route(request, response);
                return HandlerResponse::Handled;
            });
        set_exception_handler([](const httplib::Request&, httplib::Response& response, const auto&)
                              { refuse(response, 500, "something went wrong here"); });
    }

    std::string answer(const std::string& head, const std::string& peer)
    {
        std::string text;
        try
        {
            TextStream stream(head, peer);
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
            text = stream.take();
        }
        catch (...)
        {
            text = plainAnswer(500, "something went wrong here");
        }
        if (text.empty()) text = plainAnswer(400, "that is no HTTP request");
        count(text);
        return text;
    }

private:
    void count(const std::string& answer)
    {
        int status = 0;
        if (answer.size() > 12) std::from_chars(answer.data() + 9, answer.data() + 12, status);
        const std::lock_guard<std::mutex> lock(_mutex);
        ++_counts.answers[status];
    }

    MonitorState state() const
    {
        MonitorState state;
        state.name = _name;
        state.view = _watch->view();
        state.now_s = steadyNow_s();
        state.picture.problem = "this program shows none";
        if (_picture) state.picture = _picture->cost();
        const std::lock_guard<std::mutex> lock(_mutex);
        state.page = _counts;
        return state;
    }

    void route(const httplib::Request& request, httplib::Response& response)
    {
        if (!isTrustedHost(oneHeader(request, "Host"), _access.hosts))
            return refuse(response,
                          421,
                          "this page isn't known by that name; --monitor-host NAME makes it so");
        if (isForeign(request))
            return refuse(response, 403, "another site's page may not use this one");
        if (hasBody(request)) return refuse(response, 413, "no request has a body here");
        const bool isAction = request.path == "/mute" || request.path == "/unmute";
        const bool isLook = request.method == "GET" || request.method == "HEAD";
        if (!isAction && !isPage(request.path))
            return refuse(response, 404, "there is no such page");
        if (isAction ? request.method != "POST" : !isLook)
        {
            response.set_header("Allow", isAction ? "POST" : "GET, HEAD");
            return refuse(response, 405, isAction ? "it takes a POST" : "it takes a GET");
        }
        if (isAction) return mute(request, response);
        show(request.path, response);
    }

    static bool isPage(const std::string& path)
    {
        constexpr std::array<std::string_view, 6> kPages = {
            "/", "/status.json", "/metrics", "/healthz", "/picture", "/favicon.ico"};
        return std::find(kPages.begin(), kPages.end(), path) != kPages.end();
    }

    void show(const std::string& path, httplib::Response& response)
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

    static void showPage(httplib::Response& response)
    {
        const std::string nonce = newNonce();
        response.headers.erase("Content-Security-Policy");
        response.set_header("Content-Security-Policy",
                            fmt::format("{}; script-src 'nonce-{}'; style-src 'nonce-{}'; "
                                        "connect-src 'self'; img-src 'self' blob:",
                                        kPolicy,
                                        nonce,
                                        nonce));
        response.set_content(pageHtml(nonce), "text/html; charset=utf-8");
    }

    void showPicture(httplib::Response& response)
    {
        const MonitorPicture picture = _picture ? _picture->newest() : MonitorPicture();
        if (picture.bytes.empty())
        {
            const std::string problem = _picture ? _picture->cost().problem : "";
            return refuse(response, 503, problem.empty() ? "there is no picture yet" : problem);
        }
        response.set_header("X-Midair-Age-ms",
                            fmt::format("{:.0f}", 1e3 * (steadyNow_s() - picture.taken_s)));
        response.set_content(picture.bytes, picture.type);
    }

    void mute(const httplib::Request& request, httplib::Response& response)
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
        const bool isMute = what == "mute";
        const MuteOutcome outcome = _watch->setMuted(
            isMute, operatorName(oneHeader(request, "X-Midair-Operator"), request.remote_addr));
        response.set_content(muteJson(isMute, outcome), "application/json");
    }

    std::string _name;
    PageAccess _access;
    std::shared_ptr<MonitorWatch> _watch;
    std::shared_ptr<PictureSource> _picture;
    mutable std::mutex _mutex; ///< guards the counts
    PageCounts _counts;
};

PageServer::PageServer(std::string name,
                       PageAccess access,
                       std::shared_ptr<MonitorWatch> watch,
                       std::shared_ptr<PictureSource> picture)
{
    // The library's server makes the whole program ignore SIGPIPE, which is for the program to say.
    struct sigaction before = {};
    ::sigaction(SIGPIPE, nullptr, &before);
    _http = std::make_unique<Http>(
        std::move(name), std::move(access), std::move(watch), std::move(picture));
    ::sigaction(SIGPIPE, &before, nullptr);
}

PageServer::~PageServer() = default;

std::string PageServer::answer(const std::string& head, const std::string& peer)
{
    return _http->answer(head, peer);
}

std::string operatorName(const std::string& name, const std::string& peer)
{
    constexpr std::size_t kMost = 40;
    std::string shown;
    for (std::size_t i = 0; i < name.size() && shown.size() < kMost; ++i)
    {
        unsigned int code = static_cast<unsigned char>(name[i]);
        if (name[i] == '%' && i + 2 < name.size())
        {
            const char* const digits = name.data() + i + 1;
            const auto read = std::from_chars(digits, digits + 2, code, 16);
            if (read.ec != std::errc() || read.ptr != digits + 2) continue;
            i += 2;
        }
        if (code >= 0x20 && code != 0x7F) shown += static_cast<char>(code);
    }
    return shown.empty() ? peer : fmt::format("{} ({})", shown, peer);
}

} // namespace midair::samples
