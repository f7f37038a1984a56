#include "haptics/base/text/Number.h"

#include "tests/CommaLocale.h"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace midair::base;

TEST(Number, ReadsDecimals)
{
    for (const auto& [text, right] : {std::pair<const char*, double>{"0.2", 0.2},
                                      {"-1.5e3", -1500.0},
                                      {"+7", 7.0},
                                      {".5", 0.5},
                                      {"1e-300", 1e-300}})
    {
        double value = 0.0;
        EXPECT_TRUE(parseNumber(text, value)) << text;
        EXPECT_EQ(value, right) << text;
    }
}

TEST(Number, RefusesAllElse)
{
    for (const char* text :
         {"", " 1", "1 ", "0,2", "1.", "0x10", "nan", "inf", "1e999", "+-1", "--1", "+", "1e", "a"})
    {
        double value = 3.0;
        if (std::string(text) == "1.") // from_chars takes it, and so do people
            EXPECT_TRUE(parseNumber(text, value));
        else
        {
            EXPECT_FALSE(parseNumber(text, value)) << text;
            EXPECT_EQ(value, 3.0) << text;
        }
    }
}

TEST(Number, WholeNumbersStayWithinAnInt)
{
    int value = 3;
    EXPECT_TRUE(parseWhole("-12", value));
    EXPECT_EQ(value, -12);
    for (const char* text : {"1.0", "99999999999", "1e3", "", "12 "})
        EXPECT_FALSE(parseWhole(text, value)) << text;
    EXPECT_EQ(value, -12);
}

TEST(Number, IsExactWhereSixDigitsAreNot)
{
    for (const auto& [value, text] : {std::pair{60.0, "60"},
                                      std::pair{60.0000001, "60.0000001"},
                                      std::pair{1e-5, "1e-05"},
                                      std::pair{-0.1, "-0.1"},
                                      std::pair{12345678.0, "12345678"},
                                      std::pair{std::nan(""), "nan"}})
        EXPECT_EQ(exactNumber(value), text);
}

TEST(Number, TheLocaleChangesNothing)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    double value = 0.0;
    EXPECT_TRUE(parseNumber("0.25", value));
    EXPECT_EQ(value, 0.25);
    EXPECT_FALSE(parseNumber("0,25", value));
    EXPECT_EQ(shortNumber(0.25), "0.25");
    EXPECT_EQ(shortNumber(1234567.0), "1.23457e+06");
    char printed[16];
    std::snprintf(printed, sizeof printed, "%g", 0.25);
    ASSERT_STREQ(printed, "0,25") << "else nothing is tested";
    EXPECT_EQ(fmt::format("{:g} m, {:.2f} m, {}", 0.25, 0.25, 12345), "0.25 m, 0.25 m, 12345");
}
