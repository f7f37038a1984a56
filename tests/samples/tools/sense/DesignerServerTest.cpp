// The server of the AdapTics Designer over its port, with a client of WebSocket++'s.
#include "samples/tools/sense/DesignerServer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/threads/Mutex.h"
#include "samples/tools/sense/PingWatch.h"
#include "tests/Eventually.h"
#include "tests/samples/tools/sense/FakeOutput.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>
#include <websocketpp/client.hpp>
#include <websocketpp/config/asio_no_tls_client.hpp>

using namespace midair::samples;
using nlohmann::json;

namespace
{

/// A connection with a thread of its own.
class Client
{
public:
    Client(int port, const std::string& origin, const std::string& resource = "/")
    {
        _client.clear_access_channels(websocketpp::log::alevel::all);
        _client.clear_error_channels(websocketpp::log::elevel::all);
        _client.init_asio();
        _client.set_open_handler([this](auto) { isOpen = true; });
        _client.set_close_handler([this](auto) { finish(); });
        _client.set_fail_handler([this](auto) { finish(); });
        _client.set_message_handler(
            [this](auto, const auto& message)
            {
                const midair::base::Lock lock(_mutex);
                _messages.push_back(message->get_payload());
            });
        websocketpp::lib::error_code error;
        _connection =
            _client.get_connection("ws://127.0.0.1:" + std::to_string(port) + resource, error);
        if (!origin.empty()) _connection->append_header("Origin", origin);
        _client.connect(_connection);
        _thread = std::thread([this] { _client.run(); });
    }
    ~Client()
    {
        close();
        _thread.join();
    }

    void send(const std::string& text) { send(text, websocketpp::frame::opcode::text); }
    void sendBinary(const std::string& text) { send(text, websocketpp::frame::opcode::binary); }
    void close()
    {
        websocketpp::lib::error_code error;
        _client.close(_connection, websocketpp::close::status::normal, "", error);
    }
    bool opens() const
    {
        return eventually([this] { return isOpen || isOver; }) && isOpen;
    }
    bool ends() const
    {
        return eventually([this] { return isOver.load(); });
    }
    int status() const { return _connection->get_response_code(); }
    int closeCode() const { return _connection->get_remote_close_code(); }
    std::string closeReason() const { return _connection->get_remote_close_reason(); }
    std::vector<std::string> messages()
    {
        const midair::base::Lock lock(_mutex);
        return _messages;
    }

    std::atomic<bool> isOpen{false};
    std::atomic<bool> isOver{false};

private:
    using Endpoint = websocketpp::client<websocketpp::config::asio_client>;

    void finish() { isOver = true; }
    void send(const std::string& text, websocketpp::frame::opcode::value kind)
    {
        websocketpp::lib::error_code error;
        _client.send(_connection, text, kind, error);
    }

    Endpoint _client;
    Endpoint::connection_ptr _connection;
    midair::base::Mutex _mutex;
    std::vector<std::string> _messages;
    std::thread _thread;
};

class DesignerServers : public testing::Test
{
protected:
    /// Other threads look only at these.
    struct Watched : FakeOutput
    {
        void begin() override
        {
            FakeOutput::begin();
            isHeard = true;
        }
        void end() override
        {
            FakeOutput::end();
            isHeard = false;
        }
        void update(double) override { ++updates; }
        std::optional<SenseHand> hand() const override
        {
            return isHandSeen ? std::optional<SenseHand>(handAbove(0.15)) : std::nullopt;
        }
        std::atomic<bool> isHandSeen{false};
        std::atomic<bool> isHeard{false};
        std::atomic<int> updates{0};
    };

    DesignerServers()
    {
        DesignerServerOptions options;
        options.port = 0;
        options.mostBytes = 100000;
        options.origins = {"https://designer.example/"};
        _server = std::make_unique<DesignerServer>(_output,
                                                   options,
                                                   [this](const std::string& what)
                                                   {
                                                       const midair::base::Lock lock(_mutex);
                                                       _told.push_back(what);
                                                   });
        _thread = std::thread([this] { _server->run(); });
    }
    ~DesignerServers() override
    {
        _server->stop();
        _thread.join();
        EXPECT_FALSE(_output.isHeard);
    }

    std::unique_ptr<Client> client(const std::string& origin = "",
                                   const std::string& resource = "/") const
    {
        return std::make_unique<Client>(_server->port(), origin, resource);
    }
    /// Returns a client whose pattern is playing.
    std::unique_ptr<Client> playing()
    {
        auto one = client("http://localhost:8080");
        EXPECT_TRUE(one->opens());
        one->send(updatePattern(pattern(1e6)));
        one->send(updateParameters(json::object()));
        one->send(updatePlaystart(0.0));
        EXPECT_TRUE(eventually([&] { return _output.isHeard.load(); }));
        return one;
    }
    bool isTold(const std::string& what)
    {
        return eventually(
            [&]
            {
                const midair::base::Lock lock(_mutex);
                return std::any_of(_told.begin(),
                                   _told.end(),
                                   [&](const std::string& one)
                                   { return one.find(what) != std::string::npos; });
            });
    }
    bool isSilent()
    {
        return eventually([&] { return !_output.isHeard; });
    }

    Watched _output;
    midair::base::Mutex _mutex;
    std::vector<std::string> _told;
    std::unique_ptr<DesignerServer> _server;
    std::thread _thread;
};

} // namespace

TEST_F(DesignerServers, AnswersWithWhatIsPlayed)
{
    const auto one = playing();
    ASSERT_TRUE(eventually([&] { return one->messages().size() > 3; }));
    for (const std::string& text : one->messages())
    {
        const json message = json::parse(text);
        EXPECT_EQ(message["cmd"], "playback_update");
        EXPECT_FALSE(message["data"]["evals"].empty());
        EXPECT_EQ(message["data"]["evals"][0]["stop"], false);
    }
    EXPECT_GT(_output.updates, 3);
    one->send("{");
    ASSERT_TRUE(eventually(
        [&]
        {
            const std::vector<std::string> all = one->messages();
            return std::any_of(all.begin(),
                               all.end(),
                               [](const std::string& text)
                               { return json::parse(text)["cmd"] == "error"; });
        }));
    EXPECT_TRUE(isSilent());
    EXPECT_FALSE(one->isOver) << "a mistake doesn't end the connection";
}

// Its messages come between those of playing, as the published device sends them.
TEST_F(DesignerServers, SendsTheHandWhetherOrNotAPatternIsPlayed)
{
    const auto one = client("http://localhost:8080");
    ASSERT_TRUE(one->opens());
    const auto framesOf = [&](bool withHand)
    {
        std::size_t count = 0;
        for (const std::string& text : one->messages())
            if (json::parse(text)["cmd"] == "tracking_data")
                count += trackingFrameIn(text)["hand"].is_object() == withHand ? 1 : 0;
        return count;
    };
    _output.isHandSeen = true;
    EXPECT_TRUE(eventually([&] { return framesOf(true) > 3; }));
    EXPECT_EQ(framesOf(false), 0U);
    _output.isHandSeen = false;
    EXPECT_TRUE(eventually([&] { return framesOf(false) == 1; }));
}

TEST_F(DesignerServers, IsSilentWhenItsClientHasGone)
{
    auto one = playing();
    one->close();
    EXPECT_TRUE(isSilent());
    EXPECT_TRUE(isTold("has disconnected"));
    one.reset();
    const auto next = playing(); // there is room for another
    EXPECT_FALSE(next->isOver);
}

TEST_F(DesignerServers, RefusesForeignPages)
{
    for (const std::string origin : {"https://evil.example",
                                     "http://localhost.evil.example",
                                     "http://127.0.0.1.evil.example:80",
                                     "https://designer.example.org",
                                     "https://designer.example:444",
                                     "null"})
    {
        const auto one = client(origin);
        EXPECT_FALSE(one->opens()) << origin;
        EXPECT_EQ(one->status(), 403) << origin;
        EXPECT_TRUE(isTold("--origin " + origin)) << origin;
    }
    const auto page = client("file://");
    EXPECT_FALSE(page->opens());
    EXPECT_TRUE(isTold("refused a page of file://"));
    for (const std::string origin : {"",
                                     "http://localhost",
                                     "https://LOCALHOST:443",
                                     "http://127.0.0.1:8000",
                                     "https://designer.example"})
    {
        const auto one = client(origin);
        EXPECT_TRUE(one->opens()) << origin << one->status();
        one->close();
        EXPECT_TRUE(one->ends());
    }
    const auto elsewhere = client("", "/other");
    EXPECT_FALSE(elsewhere->opens());
    EXPECT_EQ(elsewhere->status(), 404);
}

TEST_F(DesignerServers, RefusesASecondClientWithAReason)
{
    const auto one = playing();
    const auto second = client();
    ASSERT_TRUE(second->ends());
    EXPECT_EQ(second->closeCode(), 1013);
    EXPECT_NE(second->closeReason().find("another client plays"), std::string::npos);
    EXPECT_TRUE(isTold("second client"));
    EXPECT_TRUE(_output.isHeard) << "the first one plays on";
    EXPECT_FALSE(one->isOver);
}

TEST_F(DesignerServers, ClosesOnWhatIsTooLargeOrNoText)
{
    {
        const auto one = playing();
        one->send(std::string(200000, ' '));
        ASSERT_TRUE(one->ends());
        EXPECT_EQ(one->closeCode(), 1009);
        EXPECT_TRUE(isSilent());
        EXPECT_TRUE(isTold("too large"));
    }
    const auto other = playing();
    other->sendBinary("{}");
    ASSERT_TRUE(other->ends());
    EXPECT_EQ(other->closeCode(), 1003);
    EXPECT_TRUE(isSilent());
}

TEST_F(DesignerServers, AConnectionThatBreaksSilences)
{
    // By hand: WebSocket++ would close it politely.
    const int raw = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(_server->port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(raw, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    const std::string head = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
                             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    ASSERT_EQ(::send(raw, head.data(), head.size(), 0), static_cast<ssize_t>(head.size()));
    EXPECT_TRUE(isTold("a client has connected"));
    ::close(raw);
    EXPECT_TRUE(isTold("has disconnected"));
    EXPECT_FALSE(playing()->isOver);
}

TEST_F(DesignerServers, StopSilencesAndSaysGoodbye)
{
    const auto one = playing();
    _server->stop();
    ASSERT_TRUE(one->ends());
    EXPECT_EQ(one->closeCode(), 1001);
    EXPECT_TRUE(isSilent());
}

TEST_F(DesignerServers, APortHasOneOwner)
{
    FakeOutput other;
    DesignerServerOptions options;
    options.port = _server->port();
    try
    {
        const DesignerServer second(other, options, [](const std::string&) {});
        FAIL() << "two listen on one port";
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_NE(std::string(error.what()).find("in use"), std::string::npos) << error.what();
    }
}

TEST(DesignerOrigins, AreReadAsBrowsersSendThem)
{
    EXPECT_EQ(originFrom("https://Designer.Example/"), "https://designer.example");
    EXPECT_EQ(originFrom(" http://host:8080"), "http://host:8080");
    EXPECT_EQ(originFrom("http://[::1]:80"), "http://[::1]:80");
    EXPECT_EQ(originFrom("null"), "null");
    for (const char* wrong :
         {"", "*", "designer.example", "https://", "https://a/b", "ftp://a", "https://a b"})
        EXPECT_THROW(originFrom(wrong), midair::base::InputError) << wrong;
    EXPECT_TRUE(isAllowedOrigin("null", {"null"}));
    EXPECT_FALSE(isAllowedOrigin("http://localhost:80000000", {}));
    EXPECT_FALSE(isAllowedOrigin("http://localhost/", {}));
    EXPECT_FALSE(isAllowedOrigin("http://localhost, http://evil.example", {}));
    EXPECT_FALSE(isAllowedOrigin(std::string(100000, 'x'), {}));
}

TEST(PingWatches, LoseAClientThatDoesNotAnswer)
{
    PingWatch watch;
    watch.begin(100.0);
    EXPECT_FALSE(watch.takePing(100.4));
    EXPECT_TRUE(watch.takePing(100.5));
    EXPECT_FALSE(watch.takePing(100.6)) << "one each 0.5 s";
    double now_s = 100.0;
    for (; now_s < 101.9; now_s += 1.0 / 60.0)
        EXPECT_FALSE(watch.isLost(now_s)) << now_s;
    watch.hear(now_s);
    for (const double end_s = now_s + 1.9; now_s < end_s; now_s += 1.0 / 60.0)
        EXPECT_FALSE(watch.isLost(now_s)) << now_s;
    for (const double end_s = now_s + 0.3; now_s < end_s; now_s += 1.0 / 60.0)
        watch.isLost(now_s);
    EXPECT_TRUE(watch.isLost(now_s));
    // While nobody looks, answers can't be heard.
    watch.begin(200.0);
    EXPECT_FALSE(watch.isLost(210.0));
    EXPECT_FALSE(watch.isLost(210.4));
}
