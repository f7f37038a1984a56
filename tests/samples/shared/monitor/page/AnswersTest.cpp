// What the page answers, and what it refuses.
#include "samples/shared/monitor/Monitor.h"
#include "samples/shared/monitor/page/MonitorAccess.h"
#include "tests/Eventually.h"
#include "tests/samples/shared/monitor/FakeInstallation.h"
#include "tests/samples/shared/monitor/Request.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace midair::samples;

namespace
{

class Answers : public testing::Test
{
protected:
    Answers() { awaitReading(); }

    /// Waits until something was read that was so at this moment.
    void awaitReading() const
    {
        const int before = _installation->reads;
        EXPECT_TRUE(eventually([&] { return _installation->reads >= before + 2; }));
    }
    std::string ask(const std::string& head) const
    {
        const RawClient client(_monitor.port());
        client.send(head);
        return client.receive();
    }
    std::string post(const std::string& path, const std::string& lines = {})
    {
        return ask(requestHead("POST " + path,
                               "Authorization: Bearer " + _monitor.token() + "\r\n" + lines));
    }
    nlohmann::json status()
    {
        for (;;) // on a busy machine a reading may be old at once
        {
            awaitReading();
            nlohmann::json now =
                nlohmann::json::parse(bodyOf(ask(requestHead("GET /status.json"))));
            if (!now.at("array").is_null()) return now;
        }
    }
    bool isWell()
    {
        for (int i = 0; i < 100; ++i)
        {
            awaitReading();
            if (statusOf(ask(requestHead("GET /healthz"))) == 200) return true;
        }
        return false;
    }

    std::shared_ptr<FakeInstallation> _installation = std::make_shared<FakeInstallation>();
    Monitor _monitor{{":0", "", {"gallery"}}, "test: star", _installation};
};

} // namespace

TEST_F(Answers, EachPageHasItsType)
{
    ASSERT_TRUE(isWell());
    for (const auto& [path, type] :
         {std::pair{"/", "text/html; charset=utf-8"},
          std::pair{"/status.json", "application/json"},
          std::pair{"/metrics", "text/plain; version=0.0.4; charset=utf-8"},
          std::pair{"/healthz", "text/plain; charset=utf-8"},
          std::pair{"/picture", "image/jpeg"},
          std::pair{"/picture?n=7", "image/jpeg"}})
    {
        const std::string answer = ask(requestHead(std::string("GET ") + path));
        EXPECT_EQ(statusOf(answer), 200) << path;
        EXPECT_NE(answer.find(std::string("\r\nContent-Type: ") + type + "\r\n"), std::string::npos)
            << answer;
        EXPECT_NE(answer.find("\r\nX-Content-Type-Options: nosniff\r\n"), std::string::npos);
        EXPECT_NE(answer.find("\r\nX-Frame-Options: DENY\r\n"), std::string::npos);
        EXPECT_NE(answer.find("frame-ancestors 'none'"), std::string::npos);
        EXPECT_NE(answer.find("\r\nCache-Control: no-store\r\n"), std::string::npos);
        EXPECT_EQ(answer.find("Access-Control-Allow"), std::string::npos);
    }
    EXPECT_EQ(statusOf(ask(requestHead("GET /favicon.ico"))), 204);
    EXPECT_EQ(bodyOf(ask(requestHead("HEAD /status.json"))), "");
    EXPECT_EQ(statusOf(ask(requestHead("HEAD /status.json"))), 200);
}

TEST_F(Answers, SayTheForceAsAllOthersDo)
{
    _installation->change([](MonitorReading& reading)
                          { reading.statistics.fingertipForce_N = 12.34e-3; });
    EXPECT_EQ(status().at("error").at("fingertip"), "12 mN");
}

TEST_F(Answers, ThePageNeedsNothingFromElsewhere)
{
    const std::string one = ask(requestHead("GET /"));
    const std::size_t at = one.find("script-src 'nonce-");
    ASSERT_NE(at, std::string::npos);
    const std::string nonce = one.substr(at + 18, 32);
    EXPECT_NE(one.find("<script nonce=\"" + nonce + "\">"), std::string::npos);
    EXPECT_NE(one.find("<style nonce=\"" + nonce + "\">"), std::string::npos);
    EXPECT_EQ(ask(requestHead("GET /")).find(nonce), std::string::npos) << "a nonce comes once";
    const std::string page = bodyOf(one);
    for (const char* outside :
         {"http:", "https:", "//cdn", "src=", "@import", "innerHTML", "NONCE"})
        EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST_F(Answers, RefusesWhatIsNotForIt)
{
    const std::string own = "Authorization: Bearer " + _monitor.token() + "\r\n";
    const auto refused = [&](int status, const std::string& head)
    {
        EXPECT_EQ(statusOf(ask(head)), status) << head;
        EXPECT_EQ(_installation->mutes, 0) << head;
    };
    refused(404, requestHead("GET /nothing"));
    refused(404, requestHead("GET /../../etc/passwd"));
    refused(404, requestHead("GET /mute/"));
    refused(405, requestHead("GET /mute", own));
    refused(405, requestHead("POST /", own));
    refused(405, requestHead("DELETE /status.json"));
    refused(405, requestHead("PUT /mute", own));
    refused(401, requestHead("POST /mute"));
    refused(401, requestHead("POST /mute", "Authorization: Bearer wrong\r\n"));
    refused(401, requestHead("POST /mute", "Authorization: " + _monitor.token() + "\r\n"));
    refused(401, requestHead("POST /mute?token=" + _monitor.token()));
    refused(401, requestHead("POST /mute", "Cookie: token=" + _monitor.token() + "\r\n"));
    refused(401, requestHead("POST /mute", own + own));
    refused(413, requestHead("POST /mute", own + "Content-Length: 5\r\n") + "hello");
    refused(413, requestHead("POST /mute", own + "Transfer-Encoding: chunked\r\n"));
    refused(400, "POST\r\n\r\n");
    refused(400, "\r\n\r\n");
    // DNS rebinding: another name that leads here.
    refused(421, "POST /mute HTTP/1.1\r\nHost: evil.example\r\n" + own + "\r\n");
    refused(421, "GET /status.json HTTP/1.1\r\nHost: evil.example:80\r\n\r\n");
    refused(421, "GET / HTTP/1.1\r\n\r\n");
    refused(421, "GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n");
    // What another site's page sends, token or not.
    refused(403, requestHead("POST /mute", own + "Origin: http://evil.example\r\n"));
    refused(403, requestHead("POST /mute", own + "Origin: null\r\n"));
    refused(403, requestHead("POST /mute", own + "Sec-Fetch-Site: cross-site\r\n"));
    refused(403, requestHead("POST /mute", own + "Sec-Fetch-Site: same-site\r\n"));
    refused(403, requestHead("GET /picture", "Sec-Fetch-Site: cross-site\r\n"));
    refused(403,
            requestHead("GET /status.json",
                        "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\n"));
    EXPECT_EQ(statusOf(ask(requestHead(
                  "GET /", "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\n"))),
              200)
        << "a link may be followed";
    EXPECT_EQ(statusOf(ask("GET / HTTP/1.1\r\nHost: gallery:8080\r\n\r\n")), 200);
}

TEST_F(Answers, MutesAndSaysWhoDidIt)
{
    const std::string answer = post("/mute", "X-Midair-Operator: Anna%20%C3%84\r\n");
    ASSERT_EQ(statusOf(answer), 200) << answer;
    const nlohmann::json done = nlohmann::json::parse(bodyOf(answer));
    EXPECT_EQ(done.at("isConfirmed"), true);
    EXPECT_EQ(done.at("state"), "muted");
    nlohmann::json now = status();
    EXPECT_EQ(now.at("array").at("state"), "muted");
    EXPECT_EQ(now.at("mute").at("by"), "Anna Ä (127.0.0.1)");
    EXPECT_EQ(
        statusOf(post("/unmute", "Origin: http://localhost\r\nSec-Fetch-Site: same-origin\r\n")),
        200);
    now = status();
    EXPECT_EQ(now.at("array").at("state"), "playing");
    EXPECT_EQ(now.at("mute").at("by"), "127.0.0.1");
    std::string told;
    for (const nlohmann::json& event : now.at("events"))
        told += event.at("text").get<std::string>() + "\n";
    EXPECT_NE(told.find("muted by Anna Ä (127.0.0.1)\n"), std::string::npos) << told;
    EXPECT_NE(told.find("unmuted by 127.0.0.1\n"), std::string::npos) << told;
    EXPECT_EQ(told.find("a key, a switch or the program"), std::string::npos) << told;
    _installation->setMuted(true);
    EXPECT_EQ(status().at("mute").at("by"), "a key, a switch or the program");
}

// A visitor touches and lets go, again and again.
TEST_F(Answers, WhatAnOperatorDidIsNotPushedOutByTouches)
{
    using osgMidair::ArrayState;
    const auto setState = [&](ArrayState state)
    {
        _installation->change([&](MonitorReading& reading) { reading.statistics.state = state; });
        awaitReading();
    };
    ASSERT_EQ(statusOf(post("/mute", "X-Midair-Operator: Anna\r\n")), 200);
    ASSERT_EQ(statusOf(post("/unmute", "X-Midair-Operator: Anna\r\n")), 200);
    setState(ArrayState::LOST);
    for (int touch = 0; touch < 16; ++touch)
    {
        setState(ArrayState::PLAYING);
        setState(ArrayState::SILENT);
    }
    std::string told;
    const nlohmann::json now = status();
    for (const nlohmann::json& event : now.at("events"))
        told += event.at("text").get<std::string>() + "\n";
    for (const char* kept : {"\nmuted by Anna (127.0.0.1)\n",
                             "\nunmuted by Anna (127.0.0.1)\n",
                             "\nthe array is unplugged or has failed\n"})
        EXPECT_NE(told.find(kept), std::string::npos) << told;
    const nlohmann::json newest = now.at("events").at(0);
    EXPECT_NE(newest.at("text").get<std::string>().find("nothing to play"), std::string::npos);
    EXPECT_GE(newest.at("count"), 31);
}

TEST_F(Answers, AMuteThatFailsIsToldAndHidesNobodyElses)
{
    _installation->isBroken = true;
    EXPECT_EQ(statusOf(post("/mute")), 500);
    _installation->isBroken = false;
    EXPECT_TRUE(status().at("mute").is_null());
    _installation->setMuted(true);
    EXPECT_EQ(status().at("mute").at("by"), "a key, a switch or the program");
    EXPECT_EQ(statusOf(post("/unmute")), 200);
}

TEST_F(Answers, SaysThatAMuteIsNotConfirmed)
{
    _installation->isDeaf = true;
    const nlohmann::json done = nlohmann::json::parse(bodyOf(post("/mute")));
    EXPECT_EQ(done.at("isConfirmed"), false);
    EXPECT_EQ(done.at("state"), "playing");
}

TEST_F(Answers, NamesThatAreHostileStayTexts)
{
    const std::string hostile = "</script><script>alert(1)</script>\"'\n\\\xFF\xC3\x01";
    _installation->change(
        [&](MonitorReading& reading)
        {
            reading.statistics.device = hostile;
            reading.array = hostile;
            osgMidair::HapticMessage message;
            message.code = "device.lost";
            message.severity = osgMidair::HapticMessage::FAULT;
            message.path = hostile;
            message.text = hostile;
            message.count = 3;
            reading.statistics.told = {message};
        });
    const nlohmann::json now = status(); // parses
    const std::string shown = now.at("messages").at(0).at("text");
    EXPECT_EQ(shown, "</script><script>alert(1)</script>\"'\n\\\xEF\xBF\xBD\xEF\xBF\xBD\x01");
    EXPECT_EQ(now.at("messages").at(0).at("severity"), "fault");
    EXPECT_EQ(bodyOf(ask(requestHead("GET /"))).find("alert(1)"), std::string::npos);
    EXPECT_EQ(operatorName("%0d%0aSet-Cookie:%20x%zz%4", "192.0.2.7"),
              "Set-Cookie: xzz%4 (192.0.2.7)");
    EXPECT_EQ(operatorName(std::string(100, 'n'), "::1"), std::string(40, 'n') + " (::1)");
    EXPECT_EQ(operatorName("", "::1"), "::1");
}

TEST_F(Answers, AFrameLoopThatStandsStillIsToldWithItsAge)
{
    EXPECT_TRUE(isWell());
    _installation->runs = false;
    nlohmann::json now;
    EXPECT_TRUE(eventually(
        [&]
        {
            now = status();
            return now.at("frames").at("isStanding") == true;
        }));
    EXPECT_GT(now.at("frames").at("age_s").get<double>(), 1.0);
    EXPECT_EQ(now.at("array").at("state"), "playing") << "which is still so";
    const std::string health = ask(requestHead("GET /healthz"));
    EXPECT_EQ(statusOf(health), 503);
    EXPECT_NE(health.find("the frame loop"), std::string::npos) << health;
}

TEST_F(Answers, OfAProgramThatHangsNothingIsShownAsIfItWereSo)
{
    _installation->hang(true);
    nlohmann::json now;
    EXPECT_TRUE(eventually(
        [&]
        {
            now = nlohmann::json::parse(bodyOf(ask(requestHead("GET /status.json"))));
            return now.at("reading").at("isOld") == true;
        }));
    EXPECT_GT(now.at("reading").at("age_s").get<double>(), 1.0);
    for (const char* part : {"array", "error", "latency_ms", "exposure", "fields", "messages"})
        EXPECT_TRUE(now.at(part).is_null()) << part;
    const std::string metrics = bodyOf(ask(requestHead("GET /metrics")));
    EXPECT_NE(metrics.find("\nmidair_up 0\n"), std::string::npos) << metrics;
    EXPECT_EQ(metrics.find("midair_array_state"), std::string::npos) << metrics;
    EXPECT_EQ(statusOf(ask(requestHead("GET /healthz"))), 503);
    _installation->hang(false);
}

TEST_F(Answers, AnArrayThatIsLostIsNotWell)
{
    for (const auto state :
         {osgMidair::ArrayState::LOST, osgMidair::ArrayState::FAULT, osgMidair::ArrayState::CLOSED})
    {
        _installation->change([&](MonitorReading& reading) { reading.statistics.state = state; });
        awaitReading();
        EXPECT_EQ(bodyOf(ask(requestHead("GET /healthz"))),
                  std::string("the array is ") + midair::bridge::stateName(state) + "\n");
    }
}
