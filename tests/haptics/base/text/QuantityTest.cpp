// Numbers with units, yes and no, and slips of the pen.
#include "haptics/base/text/Quantity.h"

#include "haptics/base/text/Words.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

double read(const std::string& text, const std::string& unit)
{
    double value = std::nan("");
    return parseQuantity(text, unit, value) ? value : std::nan("");
}

} // namespace

TEST(Quantity, IsReadInUnitsOfItsKind)
{
    EXPECT_EQ(read("500", "Pa"), 500.0);
    EXPECT_EQ(read(" 800 Pa ", "Pa"), 800.0);
    EXPECT_EQ(read("1.2kPa", "Pa"), 1200.0);
    EXPECT_EQ(read("8cm", "m"), 0.08);
    EXPECT_EQ(read("8.6 mm", "m"), 0.0086);
    EXPECT_EQ(read("0.08", "m"), 0.08);
    EXPECT_EQ(read("5 s", "ms"), 5000.0);
    EXPECT_EQ(read("250 us", "ms"), 0.25);
    EXPECT_EQ(read("40 kHz", "Hz"), 40000.0);
    EXPECT_EQ(read("30%", ""), 0.3);
    EXPECT_EQ(read("+1e2", ""), 100.0);
    EXPECT_EQ(read("90\u00b0", "deg"), 90.0);
    EXPECT_EQ(read("1e99 Pa", "Pa"), 1e99) << "ranges are checked later";
}

TEST(Quantity, IsRefusedWhereItIsUnclear)
{
    const std::pair<const char*, const char*> wrong[] = {{"", "Pa"},
                                                         {"eight", "Pa"},
                                                         {"500,0 Pa", "Pa"},
                                                         {"500,0", "Pa"},
                                                         {"800 mm", "Pa"},
                                                         {"800 mPa", "Pa"},
                                                         {"800 Pa Pa", "Pa"},
                                                         {"5 5", "Pa"},
                                                         {"1e999 Pa", "Pa"},
                                                         {"1e308 kPa", "Pa"},
                                                         {"nan", "Pa"},
                                                         {"inf", "Pa"},
                                                         {"0x10", "Pa"},
                                                         {"8 cm", ""},
                                                         {"8 %", "m"},
                                                         {"+-8", ""}};
    for (const auto& [text, unit] : wrong)
        EXPECT_TRUE(std::isnan(read(text, unit))) << text << " in " << unit;
}

TEST(YesNo, IsReadInAnyCase)
{
    for (const char* text : {"true", "TRUE", "Yes", "on", "1", " True "})
    {
        bool value = false;
        EXPECT_TRUE(parseYesNo(text, value) && value) << text;
    }
    for (const char* text : {"false", "FALSE", "No", "OFF", "0"})
    {
        bool value = true;
        EXPECT_TRUE(parseYesNo(text, value) && !value) << text;
    }
    for (const char* text : {"", "flase", "2", "truefalse", "TRUE FALSE"})
    {
        bool value = true;
        EXPECT_FALSE(parseYesNo(text, value)) << text;
        EXPECT_TRUE(value);
    }
}

TEST(NearestWord, CountsSlipsOfThePen)
{
    EXPECT_EQ(editDistance("MaxPresure", "MaxPressure"), 1);
    EXPECT_EQ(editDistance("EGDES", "EDGES"), 1) << "two letters swapped";
    EXPECT_EQ(editDistance("enabled", "ENABLED"), 0);
    EXPECT_EQ(editDistance("", "abc"), 3);
    EXPECT_EQ(editDistance("kitten", "sitting"), 3);
}

TEST(NearestWord, IsNoneWhereNothingIsNear)
{
    const std::vector<std::string> known = {"MaxPressure", "AirPressure", "Enabled", "Reach"};
    EXPECT_EQ(nearestWords("MaxPresure", known), std::vector<std::string>{"MaxPressure"});
    EXPECT_EQ(nearestWords("Pressure", known),
              (std::vector<std::string>{"MaxPressure", "AirPressure"}));
    EXPECT_TRUE(nearestWords("Foo", known).empty());
    EXPECT_EQ(didYouMean("Enabeld", known), " (did you mean Enabled?)");
    EXPECT_EQ(didYouMean("Foo", known), "");
}
