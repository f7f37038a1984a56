#include "haptics/base/text/MessageLog.h"

#include <string>
#include <type_traits>

#include <gtest/gtest.h>

using namespace midair::base;

static_assert(!std::is_constructible_v<Message, std::string>, "no message without a code");
static_assert(!std::is_default_constructible_v<Message>);

namespace
{

Message report(const std::string& text)
{
    return {MessageCode::SOLVER_REPORT, text};
}

} // namespace

TEST(MessageLog, NumbersMakeNoOtherMessage)
{
    MessageLog log;
    EXPECT_TRUE(log.say(report("12 of 100 points fall short by 3.5e-3 Pa")));
    EXPECT_FALSE(log.say(report("7 of 80 points fall short by 12 Pa")));
    ASSERT_EQ(log.messages().size(), 1u);
    EXPECT_EQ(log.messages()[0].count, 2u);
    EXPECT_EQ(log.all()[0], "7 of 80 points fall short by 12 Pa") << "the newest text";
}

TEST(MessageLog, NamesMakeOne)
{
    EXPECT_EQ(withoutNumbers("board2: 3 of 4.5 at \"box 7\" -1e+3, 2."),
              "board2: # of # at \"box 7\" -#, #.");
    MessageLog log;
    const MessageCode code = MessageCode::OBJECT_INVALID;
    EXPECT_TRUE(log.say(report("scene \"box 1\" is inside")));
    EXPECT_TRUE(log.say(report("scene \"box 2\" is inside")));
    EXPECT_TRUE(log.say(about(code, "Scene/box 1", "has 3 triangles")));
    EXPECT_TRUE(log.say(about(code, "Scene/box 2", "has 3 triangles")));
    EXPECT_FALSE(log.say(about(code, "Scene/box 2", "has 4 triangles")));
    EXPECT_EQ(log.messages().size(), 4u);
}

TEST(MessageLog, ACodeIsOneMessageAtEachNode)
{
    MessageLog log;
    EXPECT_TRUE(log.say({MessageCode::DEVICE_LOST, "device: unplugged"}));
    EXPECT_FALSE(log.say({MessageCode::DEVICE_LOST, "device: a stall"}));
    EXPECT_TRUE(log.say({MessageCode::DEVICE_LOST, "device: a stall", "Scene"}));
    EXPECT_EQ(log.all(), (std::vector<std::string>{"device: a stall", "device: a stall"}));
    EXPECT_EQ(log.messages()[0].count, 2u);
}

// It used to take a hundred messages and was deaf after that.
TEST(MessageLog, IsNeverFull)
{
    MessageLog log;
    log.say({MessageCode::DEVICE_LOST, "device: unplugged"});
    for (std::size_t i = 0; i < 3 * MessageLog::kMost; ++i)
        EXPECT_TRUE(log.say(
            about(MessageCode::OBJECT_INVALID, "box" + std::to_string(i), "has no triangles")));
    EXPECT_EQ(log.messages().size(), MessageLog::kMost);
    EXPECT_EQ(log.added(), 3 * MessageLog::kMost + 1);
    EXPECT_EQ(log.all().front(), "device: unplugged") << "the least severe go first";
    EXPECT_EQ(log.all().back(), "box299: has no triangles");
    EXPECT_TRUE(log.say({MessageCode::DEVICE_FAULT, "device: plays nothing"}));
}

// A solver whose report has a name in it fills no log, and its count goes on.
TEST(MessageLog, OfOneCodeAndPathTheNewestTextsStay)
{
    const auto word = [](std::size_t i) { return std::string(1 + i / 26, char('a' + i % 26)); };
    MessageLog log;
    EXPECT_TRUE(log.say({MessageCode::FIELD_SILENCED, "no level is quiet enough"}));
    EXPECT_TRUE(log.say(about(MessageCode::PROPERTY_INVALID, "box", "spacing is wrong")));
    EXPECT_TRUE(log.say(about(MessageCode::PROPERTY_INVALID, "box", "side is wrong")));
    for (std::size_t i = 0; i < 300; ++i)
        EXPECT_TRUE(log.say(report("point " + word(i) + " falls short")));
    const auto& all = log.messages();
    ASSERT_EQ(all.size(), 3 + MessageLog::kMostAlike);
    EXPECT_EQ(all[0].text, "no level is quiet enough");
    EXPECT_EQ(all[1].text, "box: spacing is wrong") << "two properties of one node";
    EXPECT_EQ(all[2].text, "box: side is wrong");
    std::uint64_t count = 0;
    for (std::size_t i = 3; i < all.size(); ++i)
    {
        EXPECT_EQ(all[i].text, "point " + word(300 - 11 + i) + " falls short");
        count += all[i].count;
    }
    EXPECT_EQ(count, 300u);
    // One that is said again is new among them.
    log.say(report(all[3].text));
    log.say(report("another"));
    EXPECT_EQ(log.messages()[3].text, "point " + word(300 - 8) + " falls short");
}

TEST(MessageLog, AFaultGoesForNoWarning)
{
    MessageLog log;
    EXPECT_TRUE(log.say({MessageCode::FIELD_SILENCED, "no level is quiet enough"}));
    for (std::size_t i = 0; i < 2 * MessageLog::kMost; ++i)
        log.say(about(MessageCode::PROPERTY_SILENCED, "box" + std::to_string(i), "a pressure"));
    EXPECT_EQ(log.messages().size(), MessageLog::kMost);
    EXPECT_EQ(log.messages()[0].code, MessageCode::FIELD_SILENCED)
        << "of other faults there are more";
    log.say(report("a report"));
    EXPECT_EQ(log.messages().size(), MessageLog::kMost);
    for (const Message& message : log.messages())
        EXPECT_EQ(message.severity(), Severity::FAULT);
}

// Where nothing has others of its code and path beside it the severity decides.
TEST(MessageLog, WhatHasOthersBesideItGoesFirst)
{
    MessageLog log;
    log.say(report("alone"));
    for (std::size_t i = 0; i < MessageLog::kMost - 3; ++i)
        log.say(about(MessageCode::OBJECT_INVALID, "box" + std::to_string(i), "is flat"));
    log.say({MessageCode::HANDS_SOURCE, "the tracker is lost"});
    log.say({MessageCode::HANDS_SOURCE, "the tracker is back"});
    ASSERT_EQ(log.messages().size(), MessageLog::kMost);
    log.say({MessageCode::OBJECT_INVALID, "one more"});
    ASSERT_EQ(log.messages().size(), MessageLog::kMost);
    EXPECT_EQ(log.all().front(), "alone") << "though it is a notice";
    EXPECT_EQ(log.all()[MessageLog::kMost - 2], "the tracker is back");
    log.say(about(MessageCode::OBJECT_INVALID, "box", "is flat"));
    EXPECT_EQ(log.all().front(), "box0: is flat") << "the least severe has gone";
}

// A pipeline that is made anew counts from the beginning.
TEST(MessageLog, TheNewerTextOfAnotherLogStays)
{
    MessageLog first;
    MessageLog second;
    MessageLog to;
    first.say(report("3 points"));
    first.say(report("4 points"));
    to.take(first.messages()[0]);
    second.say(report("5 points"));
    EXPECT_FALSE(to.take(second.messages()[0]));
    EXPECT_EQ(to.all()[0], "5 points");
    EXPECT_FALSE(to.take(first.messages()[0]));
    EXPECT_EQ(to.all()[0], "5 points");
    EXPECT_EQ(to.messages()[0].count, 2u);
}

TEST(MessageLog, TakesCountsOfAnotherOver)
{
    MessageLog from;
    MessageLog to;
    from.say(report("3 points"));
    EXPECT_TRUE(to.take(from.messages()[0]));
    from.say(report("4 points"));
    EXPECT_FALSE(to.take(from.messages()[0]));
    EXPECT_FALSE(to.take(from.messages()[0])) << "the same once more";
    EXPECT_EQ(to.messages()[0].count, 2u);
    EXPECT_EQ(to.all()[0], "4 points");
}
