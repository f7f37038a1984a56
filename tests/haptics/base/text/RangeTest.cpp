#include "haptics/base/text/Range.h"

#include "tests/CommaLocale.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using midair::base::RangeCheck;

namespace
{

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string errorOf(const RangeCheck& check)
{
    std::string error = "nothing is wrong";
    const bool passed = check.passed(&error);
    EXPECT_EQ(passed, error == "nothing is wrong");
    EXPECT_EQ(check.passed(nullptr), passed);
    return error;
}

TEST(RangeCheck, TakesTheEndsOfARangeAsTheyAreSaid)
{
    EXPECT_EQ(errorOf(RangeCheck().within("a", 0.0, 0.0, 1.0).within("a", 1.0, 0.0, 1.0)),
              "nothing is wrong");
    EXPECT_EQ(errorOf(RangeCheck().atLeast("a", 2.0, 2.0)), "nothing is wrong");
    EXPECT_EQ(errorOf(RangeCheck().above("a", 2.0, 2.0)), "a is 2; it must be above 2");
    EXPECT_EQ(errorOf(RangeCheck().within("a", 1.25, 0.0, 1.0)),
              "a is 1.25; it must be within 0 .. 1");
    EXPECT_EQ(errorOf(RangeCheck().atLeast("a", 1.5, 2.0)), "a is 1.5; it must be at least 2");
    EXPECT_EQ(errorOf(RangeCheck().check(false, "a", 1.0, "0 or 2 and up")),
              "a is 1; it must be 0 or 2 and up");
}

TEST(RangeCheck, TakesNeitherNanNorInfinity)
{
    EXPECT_EQ(errorOf(RangeCheck().within("a", NAN, 0.0, 1.0)),
              "a is nan; it must be within 0 .. 1");
    EXPECT_EQ(errorOf(RangeCheck().atLeast("a", NAN, 0.0)), "a is nan; it must be at least 0");
    EXPECT_EQ(errorOf(RangeCheck().atLeast("a", kInfinity, 0.0)),
              "a is inf; it must be finite and at least 0");
    EXPECT_EQ(errorOf(RangeCheck().above("a", kInfinity, 0.0)),
              "a is inf; it must be finite and above 0");
}

TEST(RangeCheck, TellsTheFirstThatIsWrongWithItsOwnerAndUnit)
{
    EXPECT_EQ(errorOf(RangeCheck("box ")
                          .within("width", 1.0, 0.0, 2.0)
                          .above("height", -1.0, 0.0, " m")
                          .above("depth", -2.0, 0.0)
                          .require(false, "is shut")),
              "box height is -1 m; it must be above 0");
    EXPECT_EQ(errorOf(RangeCheck("the box ").require(false, "is shut")), "the box is shut");
}

// "a is 1; it must be within 0 .. 1" would contradict itself.
TEST(RangeCheck, RoundsNoValueIntoItsRange)
{
    EXPECT_EQ(errorOf(RangeCheck().within("a", 1.0000001, 0.0, 1.0)),
              "a is 1.0000001; it must be within 0 .. 1");
    EXPECT_EQ(errorOf(RangeCheck().atLeast("a", 249.99999, 250.0, " Pa")),
              "a is 249.99999 Pa; it must be at least 250");
    EXPECT_EQ(errorOf(RangeCheck().within("a", 1.5e7, 0.0, 1e6)),
              "a is 1.5e+07; it must be within 0 .. 1e+06");
}

TEST(RangeCheck, WritesNumbersTheSameInEveryLocale)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    EXPECT_EQ(errorOf(RangeCheck().within("a", 12345.5, 0.5, 1.0)),
              "a is 12345.5; it must be within 0.5 .. 1");
}

} // namespace
