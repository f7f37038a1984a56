#include "samples/tools/sense/DesignerServer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/tools/sense/PingWatch.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <exception>
#include <regex>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <websocketpp/config/asio_no_tls.hpp>
#include <websocketpp/server.hpp>

namespace midair::samples
{

namespace
{

constexpr long kMostWait_ms = 20;
constexpr double kTick_s = 1.0 / 60.0; // between two
constexpr double kFarewell_s = 0.25;   // for the last messages to leave
constexpr long kHandshake_ms = 2000;   // for a request, and for an answer at the end
constexpr std::size_t kMostUnread = std::size_t(1) << 20; // bytes that a client may leave unread
constexpr std::size_t kMostTold = 100;                    // sentences about strangers

std::string lowerCase(std::string text)
{
    std::transform(text.begin(),
                   text.end(),
                   text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

/// Returns a sentence about a page that may not connect.
std::string refusalOf(const std::string& origin)
{
    const std::string shown = base::printable(origin, 100);
    try
    {
        return fmt::format("refused a page of {}; --origin {} allows it", shown, originFrom(shown));
    }
    catch (const base::InputError&)
    {
        return fmt::format("refused a page of {}", shown);
    }
}

} // namespace

std::string originFrom(const std::string& origin)
{
    static const std::regex pattern(
        R"((https?://(?:[a-z0-9._-]{1,255}|\[[0-9a-f:.]{2,45}\])(?::[0-9]{1,5})?)/?|(null))");
    const std::string lower = lowerCase(base::trimmed(origin)).substr(0, 400);
    std::smatch match;
    if (!std::regex_match(lower, match, pattern))
        throw base::InputError(fmt::format(
            "the origin \"{}\" should be https://HOST, http://HOST:PORT, or null for a page from a "
            "file",
            base::printable(origin, 100)));
    return match[2].matched ? match[2].str() : match[1].str();
}

bool isAllowedOrigin(const std::string& origin, const std::vector<std::string>& allowed)
{
    if (origin.empty()) return true;
    if (origin.size() > 400) return false;
    static const std::regex own(R"(https?://(?:localhost|127\.0\.0\.1)(?::[0-9]{1,5})?)");
    const std::string lower = lowerCase(origin);
    return std::regex_match(lower, own) ||
           std::find(allowed.begin(), allowed.end(), lower) != allowed.end();
}

/// The server and its one client. All but stop() is on the thread of run().
class DesignerServer::Endpoint
{
public:
    Endpoint(SenseOutput& output,
             const DesignerServerOptions& options,
             std::function<void(const std::string&)> tell) :
        _output(output),
        _session(output, tell),
        _tell(std::move(tell))
    {
        for (const std::string& origin : options.origins)
            _origins.push_back(originFrom(origin));
        listen(options);
    }

    int port() const { return _port; }

    void run(const std::function<bool()>& isStopAsked)
    {
        _isStopAsked = isStopAsked;
        _next_s = base::steadySeconds();
        tick();
        _server.run();
    }

    void stop() { _isStopping = true; }

private:
    using Server = websocketpp::server<websocketpp::config::asio>;
    using Handle = websocketpp::connection_hdl;
    using Code = websocketpp::close::status::value;

    void listen(const DesignerServerOptions& options)
    {
        try
        {
            _server.clear_access_channels(websocketpp::log::alevel::all);
            _server.clear_error_channels(websocketpp::log::elevel::all);
            _server.init_asio();
            _server.set_reuse_addr(true);
            _server.set_max_message_size(options.mostBytes);
            _server.set_max_http_body_size(1024);
            _server.set_open_handshake_timeout(kHandshake_ms);
            _server.set_close_handshake_timeout(kHandshake_ms);
            _server.set_validate_handler([this](const Handle& handle)
                                         { return isWelcome(handle); });
            _server.set_http_handler([this](const Handle& handle) { answerBrowser(handle); });
            _server.set_open_handler([this](const Handle& handle) { open(handle); });
            _server.set_close_handler([this](const Handle& handle) { closed(handle); });
            _server.set_fail_handler([](const Handle&) {}); // refused, or no WebSocket
            _server.set_pong_handler([this](const Handle& handle, const std::string&)
                                     { hear(handle); });
            _server.set_message_handler(
                [this](const Handle& handle, const Server::message_ptr& message)
                { take(handle, *message); });
            _server.listen(asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(),
                                                   static_cast<unsigned short>(options.port)));
            _server.start_accept();
            asio::error_code error;
            _port = _server.get_local_endpoint(error).port();
        }
        catch (const websocketpp::exception& error)
        {
            throw base::InputError(fmt::format("port {} of 127.0.0.1 can't be had: {}; choose "
                                               "another with --port, or 0 for any",
                                               options.port,
                                               error.what()));
        }
    }

    bool isWelcome(const Handle& handle)
    {
        const Server::connection_ptr connection = _server.get_con_from_hdl(handle);
        const std::string origin = connection->get_request_header("Origin");
        namespace code = websocketpp::http::status_code;
        if (!isAllowedOrigin(origin, _origins))
        {
            tellOnce(refusalOf(origin));
            connection->set_body("This page may not play on this array.\n");
            connection->set_status(code::forbidden);
            return false;
        }
        if (connection->get_resource() != "/")
        {
            connection->set_body("The device is at /.\n");
            connection->set_status(code::not_found);
            return false;
        }
        return true;
    }

    void answerBrowser(const Handle& handle)
    {
        const Server::connection_ptr connection = _server.get_con_from_hdl(handle);
        connection->set_body("midair-sense: connect the AdapTics Designer to this address.\n");
        connection->set_status(websocketpp::http::status_code::upgrade_required);
    }

    void open(const Handle& handle)
    {
        if (_isStopping) return close(handle, websocketpp::close::status::going_away, "ending");
        if (hasClient())
        {
            tellOnce("refused a second client, as one plays already");
            return close(handle,
                         websocketpp::close::status::try_again_later,
                         "another client plays on this array");
        }
        _client = handle;
        _watch.begin(base::steadySeconds());
        _tell("a client has connected");
    }

    void closed(const Handle& handle)
    {
        if (!isClient(handle)) return;
        const Server::connection_ptr connection = _server.get_con_from_hdl(handle);
        const bool isLarge =
            connection->get_local_close_code() == websocketpp::close::status::message_too_big;
        const std::string why = isLarge ? ", as its message was too large" : "";
        leave("the client has disconnected" + why);
    }

    /// Forgets the client; the array is silent.
    void leave(const std::string& why)
    {
        _client.reset();
        _session.reset();
        _told.clear();
        _tell(why);
    }

    void hear(const Handle& handle)
    {
        if (isClient(handle)) _watch.hear(base::steadySeconds());
    }

    void take(const Handle& handle, const Server::message_ptr::element_type& message)
    {
        if (!isClient(handle)) return;
        hear(handle);
        if (message.get_opcode() != websocketpp::frame::opcode::text)
        {
            leave("the client has sent a message that isn't text");
            return close(
                handle, websocketpp::close::status::unsupported_data, "only text is understood");
        }
        send(_session.take(message.get_payload(), base::steadySeconds()));
    }

    void send(const std::string& text)
    {
        if (text.empty() || !hasClient()) return;
        websocketpp::lib::error_code error;
        const Server::connection_ptr connection = _server.get_con_from_hdl(_client, error);
        if (error || connection->get_buffered_amount() > kMostUnread) return;
        connection->send(text, websocketpp::frame::opcode::text);
    }

    void close(const Handle& handle, Code code, const std::string& reason)
    {
        websocketpp::lib::error_code error; // it may have gone
        _server.close(handle, code, reason, error);
    }

    void tick()
    {
        const double now_s = base::steadySeconds();
        if (_isStopAsked && _isStopAsked()) _isStopping = true;
        if (_isStopping && _end_s == 0.0) beginEnd(now_s);
        if (hasClient()) look(now_s);
        _output.update(now_s);
        if (_end_s > 0.0 && now_s >= _end_s) return _server.stop();
        _next_s = std::max(_next_s + kTick_s, now_s);
        const auto wait_ms =
            std::clamp(static_cast<long>(1e3 * (_next_s - now_s)), 0L, kMostWait_ms);
        _server.set_timer(wait_ms,
                          [this](const websocketpp::lib::error_code& error)
                          {
                              if (!error) tick();
                          });
    }

    void look(double now_s)
    {
        if (_watch.isLost(now_s))
        {
            const Handle gone = _client;
            leave(fmt::format("the client hasn't answered for {} s", PingWatch::kLost_s));
            return close(gone, websocketpp::close::status::policy_violation, "no answer to pings");
        }
        send(_session.update(now_s));
        send(_session.tracking());
        websocketpp::lib::error_code error;
        if (_watch.takePing(now_s)) _server.ping(_client, "", error);
    }

    void beginEnd(double now_s)
    {
        _end_s = now_s + kFarewell_s;
        websocketpp::lib::error_code error;
        _server.stop_listening(error);
        _session.reset();
        if (hasClient()) close(_client, websocketpp::close::status::going_away, "ending");
    }

    bool hasClient() const { return !_client.expired(); }
    bool isClient(const Handle& handle) const
    {
        return hasClient() && !handle.owner_before(_client) && !_client.owner_before(handle);
    }

    void tellOnce(const std::string& what)
    {
        if (_told.size() < kMostTold && _told.insert(what).second) _tell(what);
    }

    SenseOutput& _output;
    DesignerSession _session;
    std::function<void(const std::string&)> _tell;
    std::function<bool()> _isStopAsked;
    std::vector<std::string> _origins;
    Server _server;
    int _port = 0;
    Handle _client; ///< that plays; empty: none
    PingWatch _watch;
    std::set<std::string> _told;
    double _next_s = 0.0; ///< of the next tick
    double _end_s = 0.0;  ///< run() returns then; 0: nobody has asked for it
    std::atomic<bool> _isStopping{false};
};

DesignerServer::DesignerServer(SenseOutput& output,
                               const DesignerServerOptions& options,
                               std::function<void(const std::string&)> tell) :
    _endpoint(std::make_unique<Endpoint>(output, options, std::move(tell)))
{
}

DesignerServer::~DesignerServer() = default;

int DesignerServer::port() const
{
    return _endpoint->port();
}

void DesignerServer::run(const std::function<bool()>& isStopAsked)
{
    _endpoint->run(isStopAsked);
}

void DesignerServer::stop()
{
    _endpoint->stop();
}

} // namespace midair::samples
