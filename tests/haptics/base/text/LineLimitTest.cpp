#include "haptics/base/text/MessageLog.h"

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

Message told(const std::string& text)
{
    return {MessageCode::SOLVER_REPORT, text};
}

} // namespace

TEST(LineLimit, LetsTheFirstThroughAndThenOneASecond)
{
    LineLimit limit;
    for (int i = 0; i < LineLimit::kFirst; ++i)
    {
        const auto line = limit.take(told("first " + std::to_string(i)), 5.0);
        ASSERT_TRUE(line);
        EXPECT_EQ(line->text, "first " + std::to_string(i));
        EXPECT_EQ(line->severity, Severity::NOTICE);
    }
    EXPECT_FALSE(limit.take(told("a"), 5.1));
    EXPECT_FALSE(limit.take(told("b"), 5.2));
    EXPECT_FALSE(limit.take(told("c"), 5.9));
    EXPECT_TRUE(limit.take({MessageCode::SOLVER_REPORT, "else", "Scene"}, 5.9)) << "another path";
    EXPECT_TRUE(limit.take({MessageCode::DEVICE_LOST, "device"}, 5.9)) << "another code";
    EXPECT_TRUE(limit.due(5.9).empty());
    const auto due = limit.due(6.0);
    ASSERT_EQ(due.size(), 1u);
    EXPECT_EQ(due[0].text, "c (2 messages \"solver.report\" before it are left out here)");
    EXPECT_TRUE(limit.due(9.0).empty()) << "told";
    const auto later = limit.take(told("d"), 9.0);
    ASSERT_TRUE(later);
    EXPECT_EQ(later->text, "d");
}

TEST(LineLimit, OneThatComesAfterThePauseTellsOfThoseThatWait)
{
    LineLimit limit;
    for (int i = 0; i < LineLimit::kFirst + 3; ++i)
        limit.take(told("x"), 1.0);
    const auto line = limit.take(told("y"), 2.5);
    ASSERT_TRUE(line);
    EXPECT_EQ(line->text, "y (3 messages \"solver.report\" before it are left out here)");
    EXPECT_TRUE(limit.due(9.0).empty());
}
