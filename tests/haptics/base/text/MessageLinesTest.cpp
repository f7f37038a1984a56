#include "haptics/base/text/MessageLog.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

constexpr int kAtOnce = MessageLog::kFirstLines;

/// A user's log, and the lines that it has printed.
struct PrintedLog
{
    midair::test::SetClock clock;
    std::vector<MessageLog::Line> lines;
    MessageLog log{[this](const MessageLog::Line& line) { lines.push_back(line); }, clock};

    // Words, since numbers make no other message.
    void say(int i, double at_s)
    {
        say({MessageCode::SOLVER_REPORT, std::string(static_cast<std::size_t>(i) + 1, 'x')}, at_s);
    }
    void say(Message message, double at_s)
    {
        clock.jump(at_s - clock.now_s());
        log.say(std::move(message));
    }
};

} // namespace

TEST(MessageLog, PrintsTheFirstLinesAndThenOneASecond)
{
    PrintedLog to;
    for (int i = 0; i < kAtOnce; ++i)
    {
        to.say(i, 5.0);
        ASSERT_EQ(to.lines.size(), static_cast<std::size_t>(i) + 1);
        EXPECT_EQ(to.lines.back().text, std::string(static_cast<std::size_t>(i) + 1, 'x'));
        EXPECT_EQ(to.lines.back().severity, Severity::NOTICE);
    }
    to.lines.clear();
    to.say({MessageCode::SOLVER_REPORT, "a"}, 5.1);
    to.say({MessageCode::SOLVER_REPORT, "b"}, 5.2);
    to.say({MessageCode::SOLVER_REPORT, "c"}, 5.9);
    EXPECT_TRUE(to.lines.empty());
    to.say({MessageCode::SOLVER_REPORT, "else", "Scene"}, 5.9);
    EXPECT_EQ(to.lines.size(), 1u) << "another path";
    to.say({MessageCode::DEVICE_LOST, "device"}, 5.9);
    EXPECT_EQ(to.lines.size(), 2u) << "another code";
    to.log.printDue(5.9);
    EXPECT_EQ(to.lines.size(), 2u);
    to.log.printDue(6.0);
    ASSERT_EQ(to.lines.size(), 3u);
    EXPECT_EQ(to.lines[2].text.find("c (2 messages \"solver.report\""), 0U) << to.lines[2].text;
    to.log.printDue(9.0);
    EXPECT_EQ(to.lines.size(), 3u) << "told";
    to.say({MessageCode::SOLVER_REPORT, "d"}, 9.0);
    ASSERT_EQ(to.lines.size(), 4u);
    EXPECT_EQ(to.lines[3].text, "d");
    to.say({MessageCode::SOLVER_REPORT, "d"}, 99.0);
    EXPECT_EQ(to.lines.size(), 4u) << "the same is counted, and no line";
}

TEST(MessageLog, OneThatComesAfterThePauseTellsOfThoseThatWait)
{
    PrintedLog to;
    for (int i = 0; i < kAtOnce + 3; ++i)
        to.say(i, 1.0);
    to.say({MessageCode::SOLVER_REPORT, "y"}, 2.5);
    ASSERT_EQ(to.lines.size(), static_cast<std::size_t>(kAtOnce) + 1);
    EXPECT_EQ(to.lines.back().text.find("y (3 messages \"solver.report\""), 0U)
        << to.lines.back().text;
    to.log.printDue(9.0);
    EXPECT_EQ(to.lines.size(), static_cast<std::size_t>(kAtOnce) + 1);
}

// A terminal obeys control characters; a log whose messages another takes over leaves them as they
// are.
TEST(MessageLog, AUserSeesPrintableTextAlone)
{
    PrintedLog to;
    to.say({MessageCode::SOLVER_REPORT, "red \x1b[31m", "Scene\n"}, 1.0);
    ASSERT_EQ(to.lines.size(), 1u);
    EXPECT_EQ(to.lines[0].text, "red ?[31m");
    EXPECT_EQ(to.log.messages()[0].path, "Scene?");
    MessageLog other;
    other.say({MessageCode::SOLVER_REPORT, "red \x1b[31m"});
    EXPECT_EQ(other.all()[0], "red \x1b[31m");
}

TEST(MessageLog, TakesWhatIsNewOfALogOnce)
{
    MessageLog from;
    PrintedLog to;
    from.say({MessageCode::DEVICE_LOST, "lost"});
    to.log.takeNew(from.messages());
    to.log.takeNew(from.messages());
    from.say({MessageCode::ARRAY_DEAD, "dead"});
    to.log.takeNew(from.messages());
    EXPECT_EQ(to.log.all(), (std::vector<std::string>{"lost", "dead"}));
    EXPECT_EQ(to.log.messages()[0].count, 1u);
    EXPECT_EQ(to.lines.size(), 2u);
    std::size_t told = 0;
    EXPECT_EQ(to.log.newTexts(told).size(), 2u);
    EXPECT_TRUE(to.log.newTexts(told).empty());
}
