#include "device/FieldQueue.h"

#include "device/usb/UsbConnection.h"
#include "tests/device/Fields.h"

#include <random>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

DeviceReport reportOf(const FieldQueue& queue)
{
    DeviceReport report;
    queue.addTo(report);
    return report;
}

bool addsUp(const DeviceReport& report)
{
    return report.sent ==
           report.played + report.dropped + report.lost + report.refused + report.pending;
}

DriveSignal numbered(int number)
{
    return evenField(4, static_cast<std::uint8_t>(number), 200);
}

} // namespace

TEST(FieldQueue, has_the_newest_wait_and_counts_the_one_it_overtakes)
{
    FieldQueue queue;
    EXPECT_EQ(queue.put(numbered(1), 0.1, nullptr), nullptr);
    EXPECT_EQ(queue.put(numbered(2), 0.2, nullptr), nullptr);
    const FieldQueue::Field& field = queue.takeOff(7);
    EXPECT_EQ(field.signal, numbered(2));
    EXPECT_EQ(field.sentAt_s, 0.2);
    EXPECT_TRUE(field.committed); // nobody to wait for
    EXPECT_FALSE(queue.waits());
    const auto playing = queue.settleUntil(7, 7);
    ASSERT_TRUE(playing.has_value());
    EXPECT_EQ(*playing, numbered(2));
    const DeviceReport report = reportOf(queue);
    EXPECT_EQ(report.sent, 2U);
    EXPECT_EQ(report.dropped, 1U);
    EXPECT_EQ(report.played, 1U);
    EXPECT_EQ(report.pending, 0U);
}

TEST(FieldQueue, loses_what_is_older_than_the_field_that_was_answered)
{
    FieldQueue queue;
    for (const std::uint32_t sequence : {0xFFFFFFFEU, 0xFFFFFFFFU, 1U, 2U}) // wraps around, past 0
    {
        queue.put(numbered(static_cast<int>(sequence & 7U)), 0, nullptr);
        queue.takeOff(sequence);
    }
    EXPECT_FALSE(queue.settleUntil(0, 1).has_value()); // an answer to nothing of ours
    EXPECT_EQ(reportOf(queue).pending, 4U);
    EXPECT_EQ(*queue.settleUntil(1, 1), numbered(1));
    const DeviceReport report = reportOf(queue);
    EXPECT_EQ(report.played, 1U);
    EXPECT_EQ(report.lost, 2U);
    EXPECT_EQ(report.pending, 1U);
}

TEST(FieldQueue, repeats_a_failed_field_once_and_none_that_is_overtaken)
{
    FieldQueue queue;
    queue.put(numbered(1), 0, nullptr);
    queue.takeOff(1);
    queue.fail(1);
    EXPECT_EQ(queue.repeatFailed(), nullptr);
    ASSERT_TRUE(queue.waits());
    EXPECT_EQ(queue.takeOff(2).signal, numbered(1));
    queue.fail(2);
    queue.repeatFailed();
    EXPECT_FALSE(queue.waits());
    EXPECT_EQ(reportOf(queue).lost, 1U); // for the second time
    queue.put(numbered(3), 0, nullptr);
    queue.takeOff(3);
    queue.fail(3);
    queue.put(numbered(4), 0, nullptr);
    queue.repeatFailed();
    EXPECT_EQ(reportOf(queue).dropped, 1U);
    EXPECT_EQ(queue.takeOff(4).signal, numbered(4));
}

TEST(FieldQueue, holds_a_commit_back_until_all_in_the_joint_are_ready)
{
    FieldQueue queue;
    const auto joint = std::make_shared<JointCommit>(2);
    const JointCommit other(2);
    queue.put(numbered(1), 0, joint);
    EXPECT_FALSE(queue.takeOff(5).committed);
    EXPECT_TRUE(queue.isStaged());
    EXPECT_EQ(queue.stagedAs(5), joint);
    EXPECT_EQ(queue.stagedAs(4), nullptr);
    EXPECT_FALSE(queue.loseUnconfirmed(100, 0.5)); // its commit is still to come
    EXPECT_FALSE(queue.releaseFor(other));
    EXPECT_FALSE(queue.dropFor(other));
    EXPECT_FALSE(queue.isCommitDue());
    EXPECT_TRUE(queue.releaseFor(*joint));
    EXPECT_TRUE(queue.isCommitDue());
    queue.newest().committed = true;
    EXPECT_FALSE(queue.isStaged());
    EXPECT_TRUE(queue.loseUnconfirmed(100, 0.5));
    EXPECT_EQ(reportOf(queue).lost, 1U);
}

TEST(FieldQueue, gives_the_joints_of_what_it_gives_up)
{
    FieldQueue queue;
    const auto first = std::make_shared<JointCommit>(2);
    const auto second = std::make_shared<JointCommit>(2);
    queue.put(numbered(1), 0, first);
    queue.takeOff(1);
    queue.put(numbered(2), 0, second);
    EXPECT_EQ(queue.settleAll(true), (std::vector<FieldQueue::Joint>{second, first}));
    const DeviceReport report = reportOf(queue);
    EXPECT_EQ(report.dropped, 1U); // it waited
    EXPECT_EQ(report.lost, 1U);
    EXPECT_EQ(report.pending, 0U);
}

// Whatever happens in whatever order, every field is in one of the five counts.
TEST(FieldQueue, counts_every_field_once)
{
    std::mt19937 random(1);
    FieldQueue queue;
    std::uint32_t sequence = 0xFFFFFF00U;
    std::vector<FieldQueue::Joint> joints;
    for (int i = 0; i < 20000; ++i)
    {
        const auto some = sequence - random() % 10;
        switch (random() % 12)
        {
        case 0:
            queue.refuse();
            break;
        case 1:
            queue.dropBeforehand();
            break;
        case 2:
            joints.push_back(std::make_shared<JointCommit>(2));
            queue.put(numbered(i), 0, joints.back());
            break;
        case 3:
        case 4:
        case 5:
            queue.put(numbered(i), 0, nullptr);
            break;
        case 6:
        case 7:
            if (queue.waits() && !queue.isFull() && !queue.isStaged()) queue.takeOff(++sequence);
            break;
        case 8:
            queue.settleUntil(some, some);
            break;
        case 9:
            queue.fail(some);
            queue.repeatFailed();
            break;
        case 10:
            if (joints.empty()) break;
            if (random() % 2 == 0)
                queue.dropFor(*joints.back());
            else if (queue.releaseFor(*joints.back()))
                queue.newest().committed = true;
            break;
        default:
            if (random() % 20 == 0)
                queue.settleAll(random() % 2 == 0);
            else
                queue.loseUnconfirmed(random() % 2, 0.5);
        }
        const DeviceReport report = reportOf(queue);
        ASSERT_TRUE(addsUp(report)) << i;
        ASSERT_EQ(report.pending > 0, queue.pending() > 0);
    }
    const DeviceReport report = reportOf(queue);
    for (const std::uint64_t count :
         {report.played, report.dropped, report.lost, report.refused, report.sent})
        EXPECT_GT(count, 100U);
}

TEST(LinkClock, knows_what_is_due)
{
    LinkClock clock;
    clock.start(10);
    EXPECT_FALSE(clock.isKeepAliveDue(10.024));
    EXPECT_TRUE(clock.isKeepAliveDue(10.026));
    EXPECT_FALSE(clock.isQuestionDue(10.2));
    EXPECT_TRUE(clock.isQuestionDue(10.26));
    EXPECT_DOUBLE_EQ(clock.nextDue_s(), 10.025);
    clock.onSubmit(11);
    EXPECT_DOUBLE_EQ(clock.nextDue_s(), 10.25);
    EXPECT_FALSE(clock.isDeviceSilent(20)); // it was not asked
    for (int i = 0; i < 3; ++i)
        clock.onQuestion(20);
    EXPECT_TRUE(clock.isDeviceSilent(20));
    clock.onAnswer(20);
    EXPECT_FALSE(clock.isDeviceSilent(22));
}

TEST(PendingMute, is_repeated_until_it_is_answered)
{
    PendingMute mute;
    EXPECT_FALSE(mute.isDue(100));
    mute.ask(0xFFFFFFFFU);
    EXPECT_TRUE(mute.isDue(100)); // it did not go out yet
    mute.onSent(100);
    EXPECT_FALSE(mute.isDue(100.01));
    EXPECT_TRUE(mute.isDue(100.03));
    mute.onAnswer(0);
    mute.onAnswer(0xFFFFFFF0U);
    EXPECT_TRUE(mute.isAwaited());
    mute.onAnswer(3); // newer: the numbers wrap around
    EXPECT_FALSE(mute.isAwaited());
}
