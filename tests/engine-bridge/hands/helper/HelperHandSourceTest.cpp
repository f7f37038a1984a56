// With a shell as the helper: what ends, hangs or can't be started. The kit's own helper is tried
// in tests/plugin/hands.
#include "engine-bridge/hands/helper/HelperHandSource.h"

#include "engine-bridge/hands/helper/HelperProcess.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/hands/osc/OscDatagrams.h"

#include <array>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>
#include <sys/socket.h>

namespace midair::bridge
{

namespace
{

HelperOptions shell(const std::string& script)
{
    HelperOptions options;
    options.command = {"/bin/sh", "-c", script};
    options.name = "helper test";
    options.retry_s = 0.05;
    return options;
}

std::string firstMessage(HelperHandSource& source)
{
    std::vector<std::string> messages;
    eventually([&] { return !(messages = source.takeMessages()).empty(); });
    return messages.empty() ? "" : messages[0];
}

bool isAlive(int process)
{
    return ::kill(process, 0) == 0;
}

} // namespace

TEST(HelperHandSource, OneThatEndsIsStartedAgainAndTold)
{
    HelperHandSource source(shell("exit 3"));
    const std::string message = firstMessage(source); // a busy machine may see a later one
    EXPECT_EQ(message.rfind("helper test: the helper closed its socket, and the helper ended "
                            "with 3; no hands, it is started again in ",
                            0),
              0U)
        << message;
    EXPECT_TRUE(eventually([&] { return source.started() >= 3; }));
    EXPECT_TRUE(
        eventually([&] { return source.status().find("; no hands") != std::string::npos; }));
}

TEST(HelperHandSource, OneThatIsKilledIsTold)
{
    HelperHandSource source(shell("kill -9 $$"));
    EXPECT_NE(firstMessage(source).find("was killed by signal 9"), std::string::npos);
}

TEST(HelperHandSource, OneThatCantBeStartedIsTold)
{
    HelperOptions options = shell("");
    options.command = {"/nowhere/midair-hands"};
    options.retry_s = 25.0; // else a busy machine sees the second message first
    HelperHandSource source(options);
    EXPECT_EQ(firstMessage(source),
              "helper test: the helper \"/nowhere/midair-hands\" can't be started: No such file or "
              "directory; no hands, it is started again in 25 s");
}

TEST(HelperHandSource, OneThatSaysNothingIsEnded)
{
    HelperOptions options = shell("exec sleep 100");
    options.patience_s = 0.2;
    HelperHandSource source(options);
    ASSERT_TRUE(eventually([&] { return source.process() > 0; }));
    const int process = source.process();
    EXPECT_NE(firstMessage(source).find(
                  "the helper has sent nothing for 0.2 s, and the helper was killed by signal 9"),
              std::string::npos);
    EXPECT_FALSE(isAlive(process));
}

TEST(HelperHandSource, EndsItsHelper)
{
    int process = 0;
    {
        HelperHandSource source(shell("trap '' TERM INT HUP; exec sleep 100"));
        ASSERT_TRUE(eventually([&] { return source.process() > 0; }));
        process = source.process();
        EXPECT_TRUE(isAlive(process));
    }
    EXPECT_FALSE(isAlive(process));
}

TEST(HelperProcess, GetsTheSocketAndNoOtherFile)
{
    // A shell has no OSC, but can tell its open files: 0, 1, 2, the socket, and that of the
    // listing.
    HelperProcess helper({"/bin/sh", "-c", "echo /proc/self/fd/* >&3; read line <&3; exit 0"});
    std::array<char, 1000> bytes{};
    ssize_t size = 0;
    ASSERT_TRUE(eventually(
        [&] {
            return (size = ::recv(helper.socket(), bytes.data(), bytes.size(), MSG_DONTWAIT)) > 0;
        }));
    const std::string files(bytes.data(), static_cast<std::size_t>(size));
    EXPECT_NE(files.find("/fd/3"), std::string::npos) << files;
    EXPECT_EQ(files.find("/fd/5"), std::string::npos) << files;
    EXPECT_EQ(helper.end(), "ended with 0");
}

} // namespace midair::bridge
