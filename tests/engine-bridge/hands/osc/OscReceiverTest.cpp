#include "engine-bridge/hands/osc/OscReceiver.h"

#include "engine-bridge/hands/osc/OscSender.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/hands/osc/OscDatagrams.h"

#include <atomic>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

OscOptions portOf(const OscReceiver& receiver)
{
    eventually([&] { return receiver.port() != 0; });
    OscOptions options;
    options.port = receiver.port();
    return options;
}

OscOptions anyPort()
{
    OscOptions options;
    options.port = 0;
    return options;
}

/// Sends any bytes.
class Stranger
{
public:
    explicit Stranger(int port) : _socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0))
    {
        const SocketAddress to = SocketAddress::parse("127.0.0.1", port);
        EXPECT_EQ(::connect(_socket, to.get(), to.size()), 0);
    }
    ~Stranger() { ::close(_socket); }
    Stranger(const Stranger&) = delete;
    Stranger& operator=(const Stranger&) = delete;

    void send(const std::string& bytes) const
    {
        ::send(_socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }

private:
    int _socket;
};

} // namespace

TEST(OscReceiver, HandsArriveAndAreLost)
{
    const OscReceiver receiver(anyPort());
    OscSender sender(portOf(receiver));
    HandFrame frame;
    double time_s = 0.0;
    const double begin_s = base::steadySeconds();
    ASSERT_TRUE(eventually(
        [&]
        {
            sender.send({handAt(0, 0.1), handAt(1, 0.2)}, time_s += 0.004);
            return receiver.inbox().latest(base::steadySeconds(), frame);
        }));
    ASSERT_EQ(frame.hands.size(), 2U);
    EXPECT_NEAR(frame.hands[1].joints[INDEX_TIP].position.x(), 0.2, 1e-6);
    EXPECT_LE(frame.hands[1].age_s, base::steadySeconds() - begin_s);
    EXPECT_TRUE(eventually([&] { return !receiver.inbox().latest(base::steadySeconds(), frame); }));
}

TEST(OscReceiver, HearsThisMachineAlone)
{
    EXPECT_EQ(OscOptions().address, "127.0.0.1");
    OscOptions named;
    named.address = "localhost";
    try
    {
        const OscReceiver receiver(named);
        FAIL();
    }
    catch (const base::InputError& error)
    {
        EXPECT_STREQ(error.what(),
                     "address=localhost should be a numeric address of this machine: 127.0.0.1, or "
                     "0.0.0.0 for all of them");
    }
}

TEST(OscReceiver, APortThatIsTakenIsTold)
{
    const OscReceiver first(anyPort());
    const OscOptions same = portOf(first);
    const OscReceiver second(same);
    std::size_t told = 0;
    std::vector<std::string> messages;
    ASSERT_TRUE(eventually([&] { return !(messages = second.inbox().messages(told)).empty(); }));
    EXPECT_NE(messages[0].find("can't be listened at (Address already in use)"), std::string::npos)
        << messages[0];
    EXPECT_NE(second.status().find("not listening"), std::string::npos);
}

TEST(OscReceiver, SourcesOfOnePortShareIt)
{
    const OscReceiver free(anyPort()); // a port that is likely free once this is gone
    OscOptions options = portOf(free);
    const auto one = OscReceiver::open(options);
    EXPECT_EQ(OscReceiver::open(options), one);
    options.port = 0;
    EXPECT_NE(OscReceiver::open(options), one);
}

TEST(OscReceiver, AFloodTakesNoHandsInAndEnds)
{
    const OscReceiver receiver(anyPort());
    const OscOptions there = portOf(receiver);
    std::atomic<bool> isOver{false};
    std::thread flood(
        [&]
        {
            const Stranger stranger(there.port);
            HandMessage wrong;
            wrong.joints = 3;
            const std::string bytes = wrong.bytes();
            while (!isOver)
                stranger.send(bytes);
        });
    EXPECT_TRUE(eventually([&] { return receiver.inbox().counts().malformed > 2000; }));
    HandFrame frame;
    EXPECT_FALSE(receiver.inbox().latest(base::steadySeconds(), frame));
    isOver = true;
    flood.join();
    // Hands are taken as soon as there is room for them again.
    OscSender sender(there);
    double time_s = 0.0;
    EXPECT_TRUE(eventually(
        [&]
        {
            sender.send({handAt(1, 0.2)}, time_s += 0.004);
            return receiver.inbox().latest(base::steadySeconds(), frame);
        }));
    std::size_t told = 0;
    EXPECT_LE(receiver.inbox().messages(told).size(), 2U); // the first one, and that it is a flood
}

TEST(OscReceiver, DatagramsOfAnySizeAreCounted)
{
    const OscReceiver receiver(anyPort());
    const Stranger stranger(portOf(receiver).port);
    for (const std::size_t size : {0, 1, 4, 100, 8192, 8193, 65507})
        stranger.send(std::string(size, 'x'));
    EXPECT_TRUE(eventually([&] { return receiver.inbox().counts().malformed == 7; }));
}

TEST(OscReceiver, APlacementMovesHands)
{
    Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
    placement.translation() << 0.0, 0.0, 1.0;
    OscHandSource source(anyPort(), placement);
    OscSender sender(portOf(source.receiver()));
    HandFrame frame;
    double time_s = 0.0;
    ASSERT_TRUE(eventually(
        [&]
        {
            sender.send({handAt(1, 0.2)}, time_s += 0.004);
            return source.frameAt(3.0, frame);
        }));
    EXPECT_EQ(frame.time_s, 3.0);
    EXPECT_NEAR(frame.hands[0].joints[INDEX_TIP].position.z(), 1.15, 1e-6);
}

} // namespace midair::bridge
