// The running server, over its port: many at once, slow ones, malformed ones, and ones that hang.
#include "samples/shared/monitor/Monitor.h"
#include "tests/Eventually.h"
#include "tests/samples/shared/monitor/FakeInstallation.h"
#include "tests/samples/shared/monitor/Request.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

using namespace midair::samples;

namespace
{
std::atomic<int> acceptError{0};
std::atomic<int> acceptErrors{0}; ///< so many times

} // namespace

/// Stands before the C library's, for the library that serves, too.
extern "C" int accept(int socket, sockaddr* from, socklen_t* size)
{
    if (acceptErrors > 0)
    {
        --acceptErrors;
        errno = acceptError;
        return -1;
    }
    return ::accept4(socket, from, size, 0);
}

namespace
{

class Server : public testing::Test
{
protected:
    /// Until the page has read the installation it says that it hasn't.
    void SetUp() override
    {
        EXPECT_TRUE(eventually([&] { return statusOf(ask(requestHead("GET /healthz"))) == 200; }));
    }
    static std::string ask(const Monitor& monitor, const std::string& head)
    {
        const RawClient client(monitor.port());
        client.send(head);
        return client.receive();
    }
    std::string ask(const std::string& head) const { return ask(_monitor, head); }
    std::string mute() const { return requestHead("POST /mute", own(_monitor)); }
    static std::string own(const Monitor& monitor)
    {
        return "Authorization: Bearer " + monitor.token() + "\r\n";
    }

    std::shared_ptr<FakeInstallation> _installation = std::make_shared<FakeInstallation>();
    Monitor _monitor{{":0", "", {}}, "test", _installation};
};

/// Whose pictures are more than a socket takes at once.
std::shared_ptr<FakeInstallation> largeInstallation()
{
    auto installation = std::make_shared<FakeInstallation>();
    installation->jpeg = std::string(12U << 20U, 'x');
    return installation;
}

constexpr int kConnections = 16; ///< that are served at a time

} // namespace

TEST_F(Server, IsSpokenToByAnOrdinaryClient)
{
    httplib::Client client("127.0.0.1", _monitor.port());
    const auto page = client.Get("/");
    ASSERT_TRUE(page);
    EXPECT_EQ(page->status, 200);
    EXPECT_NE(page->body.find("<!DOCTYPE html>"), std::string::npos);
    const auto picture = client.Get("/picture", {{"Range", "bytes=0-1"}});
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->status, 200) << "parts aren't given";
    EXPECT_EQ(picture->body, "\xFF\xD8picture");
    const auto refused = client.Post("/mute");
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 401);
    const auto done =
        client.Post("/mute", {{"Authorization", "Bearer " + _monitor.token()}}, "", "");
    ASSERT_TRUE(done);
    EXPECT_EQ(done->status, 200) << done->body;
    EXPECT_EQ(_installation->read().statistics.state, osgMidair::ArrayState::MUTED);
}

TEST_F(Server, APortHasOneOwner)
{
    try
    {
        const Monitor second(
            {"127.0.0.1:" + std::to_string(_monitor.port()), "", {}}, "test", _installation);
        FAIL() << "two listen on one port";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_EQ(error.what(),
                  "can't listen on 127.0.0.1:" + std::to_string(_monitor.port()) +
                      ": Address already in use");
    }
}

TEST_F(Server, LeavesTheProgramsSignalsAlone)
{
    struct sigaction now = {};
    ASSERT_EQ(::sigaction(SIGPIPE, nullptr, &now), 0);
    EXPECT_EQ(now.sa_handler, SIG_DFL);
}

// SIGPIPE, which the library ignores for the whole program, would end it there, and a handler of
// the program's would run there.
TEST_F(Server, ItsThreadsTakeNoSignalsButThoseOfACrash)
{
    const auto running = []
    {
        std::set<std::string> folders;
        for (const auto& each : std::filesystem::directory_iterator("/proc/self/task"))
            folders.insert(each.path().string());
        return folders;
    };
    EXPECT_EQ(statusOf(ask(requestHead("GET /status.json"))), 200) << "its threads run";
    const std::set<std::string> before = running();
    const Monitor monitor({":0", "", {}}, "test", _installation);
    EXPECT_EQ(statusOf(ask(monitor, requestHead("GET /status.json"))), 200);
    int threads = 0;
    for (const std::string& folder : running())
    {
        if (before.count(folder) > 0) continue;
        std::uint64_t blocked = 0;
        const auto isBlocked = [&](int signal) { return (blocked >> (signal - 1) & 1U) == 1U; };
        bool isRunning = false;
        // One that has just been made has all blocked until it runs.
        EXPECT_TRUE(eventually(
            [&]
            {
                std::ifstream status(folder + "/status");
                std::string word;
                while (word != "SigBlk:" && status >> word)
                {
                }
                isRunning = word == "SigBlk:"; // else it has ended meanwhile
                if (isRunning) status >> std::hex >> blocked;
                return !isRunning || !isBlocked(SIGSEGV);
            }));
        if (!isRunning) continue;
        EXPECT_TRUE(isBlocked(SIGPIPE) && isBlocked(SIGTERM) && isBlocked(SIGUSR1));
        ++threads;
    }
    EXPECT_GE(threads, kConnections + 2) << "one reads, one waits for callers, others serve them";
}

TEST_F(Server, WhoeverHangsUpEarlyEndsNobody)
{
    const Monitor monitor({":0", "", {}}, "test", largeInstallation());
    for (int i = 0; i < 20; ++i)
    {
        const RawClient client(monitor.port());
        EXPECT_TRUE(client.send(requestHead("GET /picture")));
    }
    EXPECT_EQ(statusOf(ask(monitor, requestHead("GET /status.json"))), 200);
}

TEST_F(Server, WhoeverStopsSendingIsHungUpOn)
{
    std::vector<std::unique_ptr<RawClient>> slow;
    for (int i = 0; i < kConnections + 4; ++i) // more than there may be
    {
        slow.push_back(std::make_unique<RawClient>(_monitor.port()));
        slow.back()->send(i % 2 == 0 ? "GET / HTTP/1.1\r\nHost: loc" : "");
    }
    EXPECT_EQ(statusOf(ask(requestHead("GET /status.json"))), 200);
}

TEST_F(Server, WhoeverStopsReadingIsHungUpOn)
{
    const Monitor monitor({":0", "", {}}, "test", largeInstallation());
    std::vector<std::unique_ptr<RawClient>> deaf;
    for (int i = 0; i < kConnections; ++i) // as many as there may be
    {
        deaf.push_back(std::make_unique<RawClient>(monitor.port()));
        deaf.back()->send(requestHead("GET /picture"));
    }
    EXPECT_EQ(statusOf(ask(monitor, requestHead("POST /mute", own(monitor)))), 200);
}

// The library's own time is one for each byte.
TEST_F(Server, WhoeverSendsAByteNowAndThenHasNoMoreTimeThanOthers)
{
    const RawClient client(_monitor.port());
    std::atomic<bool> isTold{false};
    std::thread sender(
        [&]
        {
            for (int i = 0; i < 100 && !isTold; ++i)
            {
                client.send(i == 0 ? "GET / HTTP/1.1\r\nX: " : "x");
                letPass(0.1);
            }
        });
    EXPECT_EQ(statusOf(client.receive(8.0)), 400);
    isTold = true;
    sender.join();
}

// Of a line the library keeps whatever comes.
TEST_F(Server, ALineWithoutAnEndTakesNoMemory)
{
    const RawClient client(_monitor.port());
    const std::string much(1U << 20U, 'x');
    int taken = 0;
    while (taken < 64 && client.send(much))
        ++taken;
    EXPECT_LT(taken, 16) << "it is hung up on";
    EXPECT_EQ(statusOf(ask(requestHead("GET /healthz"))), 200);
}

TEST_F(Server, ALongListOfPartsIsRead)
{
    std::string parts = "Range: bytes=0-1";
    while (parts.size() < 8000)
        parts += ",0-1";
    EXPECT_EQ(statusOf(ask(requestHead("GET /picture", parts + "\r\n"))), 200);
}

// No file is left, or a caller has gone: the library's server ends at most of them. Callers of that
// moment are hung up on.
TEST_F(Server, GoesOnAfterErrorsThatPass)
{
    for (const int error : {EMFILE, ENFILE, ENOBUFS, ECONNABORTED})
    {
        acceptError = error;
        acceptErrors = 3;
        EXPECT_TRUE(eventually(
            [&] { return statusOf(ask(requestHead("GET /healthz"))) == 200 && acceptErrors == 0; }))
            << error;
    }
}

TEST_F(Server, WhatIsTooLongIsRefused)
{
    const std::string much(9000, 'x');
    EXPECT_EQ(statusOf(ask(requestHead("GET /", "X: " + much + "\r\n"))), 400);
    EXPECT_EQ(statusOf(ask(requestHead("GET /" + much))), 414);
    EXPECT_EQ(statusOf(ask(requestHead("GET /" + std::string(7000, 'a')))), 404);
    EXPECT_EQ(statusOf(ask(requestHead("POST /mute", own(_monitor) + "Content-Length: 99999\r\n") +
                           std::string(99999, 'x'))),
              413);
    EXPECT_EQ(_installation->mutes, 0);
}

TEST_F(Server, AnswersOneRequestAConnection)
{
    const std::string both = ask(requestHead("GET /healthz") + mute());
    EXPECT_EQ(statusOf(both), 200);
    EXPECT_EQ(bodyOf(both), "ok\n");
    EXPECT_EQ(_installation->mutes, 0) << "a request in another one's shadow";
}

TEST_F(Server, GoesOnAfterWhateverComes)
{
    const std::vector<std::string> seeds = {
        mute(),
        requestHead("GET /status.json", "Range: bytes=0-1,2-3,-5\r\nAccept-Encoding: br\r\n"),
        requestHead("GET /%2e%2e/%00%ff?a=%zz&&=&b", "Sec-Fetch-Site: none\r\n"),
        requestHead("POST /unmute",
                    "Expect: 100-continue\r\nContent-Length: 18446744073709551616\r\n"),
        "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11)};
    std::mt19937 random(1);
    for (int round = 0; round < 300; ++round)
    {
        std::string bytes = seeds[random() % seeds.size()];
        for (unsigned change = 0; change < random() % 6; ++change)
        {
            const std::size_t at = random() % bytes.size();
            switch (random() % 3)
            {
            case 0:
                bytes[at] = static_cast<char>(random());
                break;
            case 1:
                bytes.erase(at, 1 + random() % 5);
                break;
            default:
                bytes.insert(at, bytes.substr(random() % bytes.size(), 1 + random() % 40));
            }
            if (bytes.empty()) bytes = "G";
        }
        const RawClient client(_monitor.port());
        ASSERT_TRUE(client.isOpen()) << round;
        client.send(bytes);
        const bool isWhole = bytes.find("\r\n\r\n") != std::string::npos;
        if (!isWhole) client.finish(); // or it would wait for the rest
        const std::string answer = client.receive();
        ASSERT_TRUE(isWhole ? statusOf(answer) >= 100 : answer.empty() || statusOf(answer) >= 100)
            << bytes << "\n"
            << answer;
    }
    EXPECT_EQ(statusOf(ask(requestHead("GET /healthz"))), 200);
}

TEST_F(Server, AnswersManyAtOnceOrSaysThatItCannot)
{
    std::vector<std::thread> threads;
    std::atomic<int> answered{0};
    std::atomic<int> wrong{0};
    for (int i = 0; i < 8; ++i)
        threads.emplace_back(
            [&]
            {
                for (int k = 0; k < 25; ++k)
                {
                    const int status = statusOf(ask(requestHead("GET /status.json")));
                    if (status == 200 || status == 503)
                        ++answered;
                    else
                        ++wrong;
                }
            });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(answered, 200);
}

TEST_F(Server, AProgramThatHangsIsToldAndKeepsTheFramesGoing)
{
    _installation->hang(true);
    // The mute waits for the array to confirm it, which it can't; the page says so in time.
    const std::string answer = ask(mute());
    EXPECT_EQ(statusOf(answer), 504) << answer;
    EXPECT_NE(answer.find("may not have been"), std::string::npos);
    EXPECT_EQ(_installation->mutes, 1) << "it was done all the same";
    EXPECT_EQ(statusOf(ask(requestHead("GET /status.json"))), 200) << "others are answered";
    _installation->hang(false);
}

TEST_F(Server, MutesThatHangAreCounted)
{
    _installation->hang(true);
    std::vector<std::unique_ptr<RawClient>> clients;
    for (int i = 0; i < 12; ++i)
    {
        clients.push_back(std::make_unique<RawClient>(_monitor.port()));
        clients.back()->send(mute());
    }
    std::map<int, int> counts;
    for (const auto& each : clients)
        ++counts[statusOf(each->receive())];
    EXPECT_EQ(counts, (std::map<int, int>{{503, 4}, {504, 8}}));
    _installation->hang(false);
    int status = 0; // those that have hung go on and end
    for (int i = 0; i < 200 && status != 200; ++i)
        status = statusOf(ask(mute()));
    EXPECT_EQ(status, 200);
}

TEST(ServerEnd, HangsUpOnWhoeverIsThere)
{
    auto installation = std::make_shared<FakeInstallation>();
    std::vector<std::unique_ptr<RawClient>> clients;
    {
        const Monitor monitor({":0", "", {}}, "test", installation);
        for (int i = 0; i < kConnections + 4; ++i) // more than there may be
        {
            clients.push_back(std::make_unique<RawClient>(monitor.port()));
            clients.back()->send(i % 2 == 0 ? "GET / HTTP/1.1\r\nHost: loc" : "");
        }
        testing::internal::CaptureStderr();
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "it has left a client to itself";
    for (const auto& each : clients)
    {
        const std::string answer = each->receive();
        EXPECT_TRUE(answer.empty() || statusOf(answer) == 400) << answer;
    }
}

TEST(ServerEnd, DoesNotWaitForWhoeverNeverEnds)
{
    auto installation = std::make_shared<FakeInstallation>();
    std::atomic<bool> isOver{false};
    std::thread sender;
    const auto begin = std::chrono::steady_clock::now();
    {
        const Monitor monitor({":0", "", {}}, "test", installation);
        sender = std::thread(
            [&isOver, port = monitor.port()]
            {
                const RawClient client(port);
                client.send("GET / HTTP/1.1\r\nX: ");
                while (!isOver && client.send("x"))
                    letPass(0.1);
            });
        // It is served while it sends.
        EXPECT_TRUE(eventually(
            [&]
            {
                const RawClient other(monitor.port());
                other.send(requestHead("GET /healthz"));
                return statusOf(other.receive()) == 200;
            }));
        testing::internal::CaptureStderr();
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a head has its time";
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
    isOver = true;
    sender.join();
    EXPECT_TRUE(eventually([&] { return installation.use_count() == 1; })) << "and it ends";
}

TEST(ServerEnd, DoesNotWaitForWhatHangs)
{
    auto installation = std::make_shared<FakeInstallation>();
    const auto begin = std::chrono::steady_clock::now();
    {
        const Monitor monitor({":0", "", {}}, "test", installation);
        ASSERT_TRUE(eventually([&] { return installation->reads > 0; }));
        installation->hang(true);
        ASSERT_TRUE(eventually([&] { return installation->begun > installation->reads; }));
        testing::internal::CaptureStderr();
    }
    const std::string told = testing::internal::GetCapturedStderr();
    EXPECT_NE(told.find("reading the scene hangs"), std::string::npos) << told;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
    installation->hang(false);
    EXPECT_TRUE(eventually([&] { return installation.use_count() == 1; })) << "and it ends";
}

TEST(ServerFigures, HowLongAMuteTakes)
{
    auto installation = std::make_shared<FakeInstallation>();
    const Monitor monitor({":0", "", {}}, "test", installation);
    std::vector<double> times_ms;
    for (int i = 0; i < 50; ++i)
    {
        const auto begin = std::chrono::steady_clock::now();
        const RawClient client(monitor.port());
        client.send(requestHead(i % 2 == 0 ? "POST /mute" : "POST /unmute",
                                "Authorization: Bearer " + monitor.token() + "\r\n"));
        while (installation->mutes <= i)
            std::this_thread::yield();
        times_ms.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                .count());
        EXPECT_EQ(statusOf(client.receive()), 200);
    }
    std::sort(times_ms.begin(), times_ms.end());
    // A figure to read; no clock is judged here.
    std::printf("mute over HTTP until setMuted(): median %.2f ms, longest of 50 %.2f ms\n",
                times_ms[25],
                times_ms.back());
}
