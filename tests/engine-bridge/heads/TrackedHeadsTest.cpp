// Heads by OpenXR, of the tests' runtime, and by OSC.
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/hands/osc/OscSender.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/engine-bridge/hands/openxr/OpenXrHands.h"

#include <cmath>

#include <oscpack/osc/OscOutboundPacketStream.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

std::string headMessage(const std::vector<float>& numbers, const char* address = kOscHead)
{
    std::vector<char> room(kMostOscBytes);
    osc::OutboundPacketStream out(room.data(), room.size());
    out << osc::BeginMessage(address);
    for (const float number : numbers)
        out << number;
    out << osc::EndMessage;
    return std::string(out.Data(), out.Size());
}

/// An inbox, and what it is sent.
struct HeadInbox
{
    OscInbox inbox{"osc: test"};
    Head head;

    void take(const std::string& bytes, double now_s, const std::string& sender = "a")
    {
        inbox.take(bytes.data(), bytes.size(), sender, now_s);
    }
    bool isAt(double now_s) { return inbox.latestHead(now_s, head); }
};

/// A head source beside the hands of the fake runtime.
struct OpenXrHeads : OpenXrHands
{
    void SetUp() override
    {
        OpenXrHands::SetUp();
        source = openHead("openxr:");
    }
    void show(const Vector3d& place)
    {
        const Eigen::Vector3f p = place.cast<float>();
        FakeAccess()->head = XrPosef{{0, 0, 0, 1}, {p.x(), p.y(), p.z()}};
    }
    bool headComes(bool comes = true)
    {
        return eventually(
            [&]
            {
                const bool is = source->headAt(7.0, head);
                for (const std::string& message : source->takeMessages())
                    said.push_back(message);
                return is == comes;
            });
    }
    void TearDown() override
    {
        FakeAccess()->blocked.clear();
        source.reset();
        OpenXrHands::TearDown();
    }

    std::shared_ptr<HeadSource> source;
    Head head;
};

} // namespace

TEST_F(OpenXrHeads, AreThoseOfTheViewSpaceTurnedUpright)
{
    show(Vector3d(0.1, 1.6, 0.4));
    ASSERT_TRUE(headComes());
    EXPECT_EQ(head.time_s, 7.0);
    EXPECT_LT((head.pose.translation() - Vector3d(0.1, -0.4, 1.6)).norm(), 1e-6);
    EXPECT_LT((head.pose.linear() * -Vector3d::UnitZ() - Vector3d::UnitY()).norm(), 1e-6);
    EXPECT_GE(head.age_s, 0.0);
    EXPECT_EQ(FakeAccess()->located, 0) << "no hands, as nobody has asked for them";
    EXPECT_TRUE(source->setHorizon(0.03));
    EXPECT_TRUE(eventually(
        [&]
        {
            source->headAt(7.0, head);
            return FakeAccess()->headAhead == 30000000;
        }));
    FakeAccess()->head.reset(); // what the runtime only guesses is no head
    EXPECT_TRUE(headComes(false));
    show(Vector3d(0.0, 1.6, 0.0));
    EXPECT_TRUE(headComes());
    EXPECT_EQ(said, std::vector<std::string>());
}

TEST_F(OpenXrHeads, ShareTheInstanceWithTheHands)
{
    const std::shared_ptr<HandSource> hands = openHands("openxr:");
    show(Vector3d(0.0, 1.6, 0.0));
    FakeAccess()->hands[1] = fakeHand(handAt(1, kTip));
    ASSERT_TRUE(headComes());
    EXPECT_TRUE(eventually([&] { return hands->frameAt(0.0, frame); }));
    EXPECT_TRUE(source->headAt(0.0, head));
    EXPECT_EQ(FakeAccess()->instances, 1);
}

TEST_F(OpenXrHeads, AreThoseOfNowWhereTheRuntimeTellsNoLaterOnes)
{
    FakeAccess()->predicts = false;
    show(Vector3d(0.0, 1.6, 0.0));
    source->setHorizon(0.03);
    ASSERT_TRUE(headComes());
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0],
              "openxr: Fake XR 1.2.3 doesn't predict the head (XR_ERROR_TIME_INVALID): its present "
              "pose is used. prediction=kalman predicts it");
}

TEST_F(OpenXrHeads, AreLostWhileTheRuntimeRefusesThem)
{
    show(Vector3d(0.0, 1.6, 0.0));
    ASSERT_TRUE(headComes());
    FakeAccess()->failures["xrLocateSpace"] = XR_ERROR_RUNTIME_FAILURE;
    EXPECT_TRUE(headComes(false));
    EXPECT_EQ(said.at(0),
              "openxr: Fake XR 1.2.3: xrLocateSpace: XR_ERROR_RUNTIME_FAILURE; no head as long as "
              "that lasts");
    FakeAccess()->failures.clear();
    EXPECT_TRUE(headComes());
    XrPosef wrong{{0, 0, 0, 3}, {0, 0, 0}};
    FakeAccess()->head = wrong;
    EXPECT_TRUE(headComes(false));
    wrong.orientation.w = 1.0F;
    wrong.position.x = std::nanf("");
    FakeAccess()->head = wrong;
    EXPECT_TRUE(headComes(false));
}

TEST(OscHeads, ComeWithATimeOrWithout)
{
    HeadInbox in;
    EXPECT_FALSE(in.isAt(10.0));
    in.take(headMessage({0.1F, 0.2F, 0.5F, 0, 0, 0, 1}), 10.0);
    ASSERT_TRUE(in.isAt(10.02));
    EXPECT_LT((in.head.pose.translation() - Vector3d(0.1, 0.2, 0.5)).norm(), 1e-6);
    EXPECT_NEAR(in.head.age_s, 0.02, 1e-9);
    in.take(headMessage({2.0F, 0.01F, 0.3F, 0.2F, 0.5F, 0, 0, 0, 1}), 10.05);
    ASSERT_TRUE(in.isAt(10.06));
    EXPECT_NEAR(in.head.pose.translation().x(), 0.3, 1e-6);
    EXPECT_NEAR(in.head.age_s, 0.02, 1e-6);
    in.take(headMessage({1.0F, 0.0F, 0.4F, 0.2F, 0.5F, 0, 0, 0, 1}), 10.07);
    EXPECT_EQ(in.inbox.counts().late, 1u);
    in.take(headMessage({3.0F, 0.0F, 0.4F, 0.2F, 0.5F, 0, 0, 0, 1}), 10.08, "b");
    EXPECT_EQ(in.inbox.counts().ofOthers, 1u);
    EXPECT_NEAR(in.head.pose.translation().x(), 0.3, 1e-6);
    EXPECT_FALSE(in.isAt(10.1501)) << "lost a tenth of a second after its last message";
    EXPECT_EQ(in.inbox.counts().heads, 2u);
}

TEST(OscHeads, ThatCantBeAreLeftOut)
{
    HeadInbox in;
    in.take(headMessage({0, 0, 0, 0, 0, 0, 2}), 1.0);
    in.take(headMessage({2000, 0, 0, 0, 0, 0, 1}), 1.0);
    in.take(headMessage({std::nanf(""), 0, 0, 0, 0, 0, 1}), 1.0);
    EXPECT_EQ(in.inbox.counts().jointsLeftOut, 3u);
    in.take(headMessage({0, 0, 0, 0, 0, 0}), 1.0);
    in.take(headMessage({0, 0, 0, 0, 0, 0, 0, 1}), 1.0);
    in.take(headMessage({0, 99, 0, 0, 0, 0, 0, 0, 1}), 1.0);
    EXPECT_EQ(in.inbox.counts().malformed, 3u);
    in.take(headMessage({0, 0, 0, 0, 0, 0, 1}, "/midair/haed"), 1.0);
    EXPECT_EQ(in.inbox.counts().unknown, 1u);
    EXPECT_FALSE(in.isAt(1.0));
    std::size_t told = 0;
    const std::vector<std::string> said = in.inbox.messages(told);
    ASSERT_EQ(said.size(), 3u);
    EXPECT_NE(said[0].find("an impossible head (0 0 0, turn 2 long) is left out"),
              std::string::npos)
        << said[0];
    EXPECT_NE(said[2].find("(did you mean /midair/hand or /midair/head?)"), std::string::npos)
        << said[2];
}

TEST(OscHeads, ShareAPortWithTheHands)
{
    HeadInbox in;
    OscWriter writer;
    Head head;
    head.time_s = 1.0;
    head.age_s = 0.02;
    head.pose = Eigen::Translation3d(0, 0.1, 0.5) * Eigen::AngleAxisd(0.3, Vector3d::UnitY());
    const std::size_t size = writer.head(head);
    in.take(std::string(writer.data(), size), 10.0);
    ASSERT_TRUE(in.isAt(10.0));
    EXPECT_TRUE(in.head.pose.isApprox(head.pose, 1e-6));
    EXPECT_NEAR(in.head.age_s, 0.02, 1e-6);
    // A second sender has to be read while nobody sends a head that is asked for.
    EXPECT_TRUE(in.inbox.mayBeOf("b", 10.2));
    const std::size_t both =
        writer.hands({openHandWithIndexTipAt(0, Vector3d::Zero(), Eigen::Quaterniond::Identity()),
                      openHandWithIndexTipAt(1, Vector3d::Zero(), Eigen::Quaterniond::Identity())},
                     1.0);
    in.take(std::string(writer.data(), both), 10.2);
    EXPECT_TRUE(in.inbox.mayBeOf("b", 10.21)) << "the head is lost";
    EXPECT_EQ(in.inbox.status(), "osc: test: 2 hands, 1 heads");
}

TEST(OscReceiver, AHeadArrives)
{
    OscOptions any;
    any.port = 0;
    int port = 0;
    {
        const OscReceiver probe(any);
        ASSERT_TRUE(eventually([&] { return (port = probe.port()) != 0; }));
    }
    const auto source = openHead("osc:?port=" + std::to_string(port));
    OscOptions to;
    to.port = port;
    OscSender sender(to);
    Head sent;
    sent.pose.translation() = Vector3d(0.0, -0.3, 0.5);
    Head head;
    EXPECT_TRUE(eventually(
        [&]
        {
            sent.time_s = base::steadySeconds();
            sender.send(sent);
            return source->headAt(3.0, head);
        }));
    EXPECT_EQ(head.time_s, 3.0);
    EXPECT_LT((head.pose.translation() - Vector3d(0.0, -0.3, 0.5)).norm(), 1e-6);
    EXPECT_EQ(source->takeMessages(), std::vector<std::string>());
}

} // namespace midair::bridge
