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
