// Hands from other programs: by OSC, and by the kit's helper, in a scene.
#include "tests/Eventually.h"
#include "tests/fake-openxr/FakeRuntime.h"
#include "tests/plugin/KitTest.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osgMidair/HandSender>
#include <osgMidair/HandSource>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

constexpr std::size_t kIndexTip = 10;

std::string errorOf(const std::string& uri)
{
    std::string error;
    EXPECT_FALSE(openHandSource(uri, error));
    return error;
}

/// A port that was free just now.
std::string freePort()
{
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof any;
    EXPECT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&any), size), 0);
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&any), &size);
    ::close(socket);
    return std::to_string(ntohs(any.sin_port));
}

/// Kills a child of this process; false if there is none.
bool killHelper()
{
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
    {
        std::ifstream children(thread.path() / "children");
        int child = 0;
        if (children >> child) return ::kill(child, SIGKILL) == 0;
    }
    return false;
}

} // namespace

TEST(HandsByOsc, AreInTheSceneAndVanish)
{
    BoxScene box;
    const std::string uri = "osc:?port=" + freePort();
    box.scene->setHands(uri);
    std::string error;
    const osg::ref_ptr<HandSender> sender = HandSender::open(uri, error);
    ASSERT_TRUE(sender) << error;
    HeadlessViewer viewer(box.scene);
    double time = 0.0;
    EXPECT_TRUE(viewer.framesUntil(
        [&]
        {
            sender->send({openHand(0, osg::Vec3d(0.0, 0.0, 0.3), osg::Quat()),
                          openHand(1, osg::Vec3d(0.1, 0.0, 0.3), osg::Quat())},
                         time += 0.004);
            return box.scene->getStatistics().hands == 2;
        }));
    EXPECT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().hands == 0; }));
    EXPECT_EQ(box.scene->getStatistics().messages, std::vector<std::string>());
}

TEST(HandsByOsc, ArePlacedByTheMatrixOfTheirName)
{
    const std::string port = "osc:?port=" + freePort();
    std::string error;
    const osg::ref_ptr<HandSource> source =
        openHandSource(port + "&matrix=1 0 0 0  0 0 1 0  0 -1 0 0  0 0 1 1", error);
    ASSERT_TRUE(source) << error;
    const osg::ref_ptr<HandSender> sender = HandSender::open(port, error);
    std::vector<Hand> hands;
    double time = 0.0;
    ASSERT_TRUE(eventually(
        [&]
        {
            sender->send({openHand(1, osg::Vec3d(0.1, 0.2, 0.3), osg::Quat())}, time += 0.004);
            return source->getHands(0.0, hands);
        }));
    EXPECT_LT((hands[0].joints[kIndexTip].position - osg::Vec3d(0.1, -0.3, 1.2)).length(), 1e-6);
}

TEST(HandsByOsc, NamesThatAreWrongAreToldWithWhatIsRight)
{
    EXPECT_EQ(
        errorOf("osc:?address=localhost"),
        "hand source \"osc:?address=localhost\": address=localhost should be a numeric address "
        "of this machine: 127.0.0.1, or 0.0.0.0 for all of them");
    EXPECT_NE(errorOf("osc:?port=0").find("port"), std::string::npos);
    EXPECT_EQ(errorOf("osc:?prot=9000"),
              "hand source \"osc:?prot=9000\": unknown parameter \"prot\"; known are address, "
              "matrix, port");
    EXPECT_EQ(errorOf("openxr:?process=other"),
              "hand source \"openxr:?process=other\": process=other should be own or helper");
    EXPECT_EQ(errorOf("openxr:?helper=/bin/sh"),
              "hand source \"openxr:?helper=/bin/sh\": helper=/bin/sh takes process=helper");
    std::string error;
    EXPECT_FALSE(HandSender::open("udp:", error));
    EXPECT_EQ(error, "receiver of hands \"udp:\": should be osc:?address=..&port=..");
}

TEST(HandsByOsc, TheToolSendsARecording)
{
    const std::string uri = "osc:?port=" + freePort();
    std::string error;
    const osg::ref_ptr<HandSource> source = openHandSource(uri, error);
    ASSERT_TRUE(source) << error;
    bool ok = false;
    std::string said;
    std::thread tool(
        [&]
        {
            said = run(stock(MIDAIR_BIN "/midair-hands") +
                           " send " MIDAIR_ROOT
                           "/samples/scenes/hands/tap.csv --loop --seconds 2 --to '" +
                           uri + "'",
                       ok);
        });
    std::vector<Hand> hands;
    EXPECT_TRUE(eventually([&] { return source->getHands(0.0, hands); }));
    tool.join();
    EXPECT_TRUE(ok) << said;
    EXPECT_EQ(said, "sent 500 datagrams to " + uri + "\n");
}

TEST(HandsByOsc, TheToolSendsTheHeadsOfARecordingAsWell)
{
    const std::string file = testing::TempDir() + "head-and-hand.csv";
    {
        std::ifstream in(MIDAIR_ROOT "/samples/scenes/hands/tap.csv");
        std::ofstream out(file);
        out << in.rdbuf() << "0,0,head,0.1,-0.4,0.3,0,0,0,1,0,1,1\n";
        out << "0.1,0,head,0.1,-0.4,0.3,0,0,0,1,0,1,1\n";
    }
    const std::string uri = "osc:?port=" + freePort();
    std::string error;
    const osg::ref_ptr<HeadSource> source = openHeadSource(uri, error);
    ASSERT_TRUE(source) << error;
    Head head;
    EXPECT_FALSE(source->getHead(0.0, head));
    bool ok = false;
    std::string said;
    std::thread tool(
        [&]
        {
            said = run(stock(MIDAIR_BIN "/midair-hands") + " send " + file +
                           " --loop --seconds 2 --to '" + uri + "'",
                       ok);
        });
    EXPECT_TRUE(eventually([&] { return source->getHead(0.0, head); }));
    tool.join();
    EXPECT_TRUE(ok) << said;
    EXPECT_LT((head.position - osg::Vec3d(0.1, -0.4, 0.3)).length(), 1e-6);
}

// The runtime is in the helper: this program's own has no instance.
TEST(HandsOfAHelper, ComeFromItsRuntimeAndItIsStartedAgain)
{
    setenv("XR_RUNTIME_JSON", MIDAIR_FAKE_OPENXR, 1);
    setenv("MIDAIR_FAKE_HAND", "right", 1); // for the helper
    std::string error;
    const osg::ref_ptr<HandSource> source = openHandSource("openxr:?process=helper", error);
    ASSERT_TRUE(source) << error;
    std::vector<Hand> hands;
    std::string said;
    const auto isThere = [&]
    {
        for (const std::string& message : source->takeMessages())
            said += message + "\n";
        return source->getHands(0.0, hands);
    };
    ASSERT_TRUE(eventually(isThere)) << source->getStatus() << said;
    EXPECT_EQ(hands.size(), 1U);
    EXPECT_EQ(hands[0].id, 1);
    EXPECT_EQ(said, "");
    EXPECT_EQ(FakeAccess()->alive, 0);
    // It crashes: that is told, and hands come back.
    ASSERT_TRUE(killHelper());
    ASSERT_TRUE(eventually([&] { return !isThere(); }));
    ASSERT_TRUE(eventually(isThere)) << said;
    EXPECT_NE(said.find("the helper was killed by signal 9; no hands, it is started again in 1 s"),
              std::string::npos)
        << said;
    unsetenv("MIDAIR_FAKE_HAND");
}

TEST(HandsOfAHelper, WhatItMissesIsAMessage)
{
    std::string error;
    const osg::ref_ptr<HandSource> source =
        openHandSource("openxr:?process=helper&loader=libmidair_no_such_loader.so.1", error);
    ASSERT_TRUE(source) << error;
    std::vector<std::string> messages;
    ASSERT_TRUE(eventually([&] { return !(messages = source->takeMessages()).empty(); }));
    EXPECT_EQ(
        messages[0].find("openxr: the loader can't be loaded (libmidair_no_such_loader.so.1:"), 0U)
        << messages[0];
}
