#include "engine-bridge/hands/osc/OscInbox.h"

#include "tests/engine-bridge/hands/osc/OscDatagrams.h"

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

class Inbox : public testing::Test
{
protected:
    void take(const std::string& bytes, double now_s, const std::string& sender = "a")
    {
        inbox.take(bytes.data(), bytes.size(), sender, now_s);
    }
    std::size_t handsAt(double now_s)
    {
        return inbox.latest(now_s, frame) ? frame.hands.size() : 0;
    }

    OscInbox inbox{"osc: test"};
    HandFrame frame;
    std::size_t told = 0;
};

} // namespace

TEST_F(Inbox, AHandIsLostATenthOfASecondAfterItsLastMessage)
{
    EXPECT_EQ(handsAt(10.0), 0U);
    Hand hand = handAt(1, 0.0);
    hand.age_s = 0.02;
    take(datagramOf({hand}, 1.0), 10.0);
    EXPECT_EQ(handsAt(10.0), 1U);
    EXPECT_EQ(handsAt(10.09), 1U);
    EXPECT_NEAR(frame.hands[0].age_s, 0.11, 1e-6);
    EXPECT_EQ(handsAt(10.1001), 0U);
    EXPECT_TRUE(frame.hands.empty());
}

TEST_F(Inbox, EachHandIsLostForItself)
{
    take(datagramOf({handAt(0, 0.0), handAt(1, 0.1)}, 1.0), 10.0);
    EXPECT_EQ(handsAt(10.05), 2U);
    take(datagramOf({handAt(1, 0.1)}, 1.06), 10.06);
    ASSERT_EQ(handsAt(10.11), 1U);
    EXPECT_EQ(frame.hands[0].id, 1);
    HandMessage none; // the tracker has lost it
    none.time_s = 1.1;
    none.valid = 0;
    take(none.bytes(), 10.11);
    EXPECT_EQ(handsAt(10.11), 0U);
}

TEST_F(Inbox, WhatIsOutOfOrderIsIgnoredAndToldOnce)
{
    take(datagramOf({handAt(1, 0.2)}, 2.0), 10.0);
    take(datagramOf({handAt(1, 0.1)}, 1.9), 10.01);
    take(datagramOf({handAt(1, 0.1)}, 2.0), 10.02);
    ASSERT_EQ(handsAt(10.03), 1U);
    EXPECT_NEAR(frame.hands[0].joints[INDEX_TIP].position.x(), 0.2, 1e-6);
    EXPECT_EQ(inbox.counts().late, 2U);
    const std::vector<std::string> messages = inbox.messages(told);
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_EQ(messages[0],
              "osc: test: a right hand is ignored, as its time 1.900000 s isn't after 2.000000 s, "
              "that of the one before");
    // A sender that starts again has another clock.
    take(datagramOf({handAt(1, 0.1)}, 0.5), 10.2);
    EXPECT_EQ(handsAt(10.2), 1U);
}

TEST_F(Inbox, ASecondSenderIsIgnoredUntilTheFirstIsSilent)
{
    take(datagramOf({handAt(1, 0.2)}, 2.0), 10.0, "first");
    EXPECT_TRUE(inbox.mayBeOf("second", 10.01)); // there is no left hand yet
    take(datagramOf({handAt(0, 0.3), handAt(1, 0.3)}, 9.0), 10.01, "second");
    ASSERT_EQ(handsAt(10.02), 2U);
    EXPECT_NEAR(frame.hands[1].joints[INDEX_TIP].position.x(), 0.2, 1e-6);
    EXPECT_EQ(inbox.counts().ofOthers, 1U);
    EXPECT_FALSE(inbox.mayBeOf("third", 10.02));
    EXPECT_TRUE(inbox.mayBeOf("third", 10.11));
    take(datagramOf({handAt(1, 0.3)}, 9.0), 10.11, "third");
    EXPECT_EQ(inbox.counts().hands, 3U);
}

TEST_F(Inbox, NonsenseIsCountedToldOnceAndTakesNothingAway)
{
    take(datagramOf({handAt(1, 0.2)}, 2.0), 10.0);
    for (int i = 0; i < 1000; ++i)
        take(std::string(static_cast<std::size_t>(i % 50), static_cast<char>(i)), 10.01);
    EXPECT_EQ(inbox.counts().malformed, 1000U);
    EXPECT_EQ(handsAt(10.02), 1U);
    EXPECT_EQ(inbox.messages(told).size(), 1U);
    EXPECT_EQ(inbox.messages(told).size(), 0U);
    EXPECT_EQ(inbox.status(), "osc: test: 1 hands; ignored: 1000 invalid datagrams");
}

} // namespace midair::bridge
