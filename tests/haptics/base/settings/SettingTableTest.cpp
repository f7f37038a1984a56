#include "haptics/base/settings/SettingTable.h"

#include "haptics/base/settings/SettingText.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::base;

// Not in a nameless namespace: functions of templates made for its structs would count as unused.
namespace kites
{

enum class Colour
{
    RED = 1,
    BLUE = 4
};

struct Air
{
    double wind = 0.5;
    std::string name = "west";
};

struct Kite : Air
{
    bool flies = true;
    int tails = 2;
    Colour colour = Colour::RED;
    double length = 0.0;
};

} // namespace kites

using namespace kites;

namespace midair::base
{

template struct Setting<Air>;
template bool isSame(const Member<Air>&, const Air&, const Air&);
template struct Setting<Kite>;
template bool isSame(const Member<Kite>&, const Kite&, const Kite&);

} // namespace midair::base

namespace
{

const SettingTable<Air>& airTable()
{
    static const SettingTable<Air> table(
        {Row<Air>("wind", &Air::wind, "how it blows").range(0.0, 40.0, "m/s").variable("WIND"),
         Row<Air>("name", &Air::name, "where from")});
    return table;
}

const SettingTable<Kite>& table()
{
    static const SettingTable<Kite> table(joined<Kite>(
        {inherited<Kite>(airTable().rows()),
         {Row<Kite>("flies", &Kite::flies, "in the air"),
          Row<Kite>("tails", &Kite::tails, "how many").range(1, 9),
          Row<Kite>("colour", choiceOf<Kite, &Kite::colour>(), "what it looks like")
              .words({{"red", "RED", 1}, {"blue", "BLUE", 4}}),
          Row<Kite>("length", &Kite::length, "of the line").range(1.0, kNoEnd, "m").orZero()}}));
    return table;
}

std::string problem(const Kite& kite)
{
    RangeCheck check("kite: ");
    std::string error;
    EXPECT_FALSE(table().check(kite, check).passed(&error));
    return error;
}

} // namespace

TEST(SettingTableOfAnyStruct, ReadsEachKindOfValue)
{
    Kite kite;
    std::string error;
    for (const auto& [name, text] :
         std::vector<std::pair<std::string, std::string>>{{"wind", " 12.5"},
                                                          {"name", "the sea"},
                                                          {"flies", "no"},
                                                          {"tails", "3"},
                                                          {"colour", "blue"},
                                                          {"length", "1e3"}})
        EXPECT_TRUE(table().set(kite, name, text, error)) << error;
    EXPECT_EQ(kite.wind, 12.5);
    EXPECT_EQ(kite.name, "the sea");
    EXPECT_FALSE(kite.flies);
    EXPECT_EQ(kite.tails, 3);
    EXPECT_EQ(kite.colour, Colour::BLUE);
    EXPECT_EQ(kite.length, 1000.0);
    EXPECT_TRUE(table().repair(kite).empty());
}

TEST(SettingTableOfAnyStruct, SomeNumbersHaveNames)
{
    const Setting<Kite> row = Row<Kite>("tails", &Kite::tails, "how many")
                                  .range(1, 9)
                                  .named({{"plain", "plain", 1}, {"festive", "festive", 7}});
    Kite kite;
    EXPECT_TRUE(row.assign(kite, " Festive "));
    EXPECT_EQ(kite.tails, 7);
    EXPECT_TRUE(row.assign(kite, "3"));
    EXPECT_EQ(kite.tails, 3);
    for (const char* text : {"", "fest", "festive plain", "7x"})
        EXPECT_FALSE(row.assign(kite, text)) << text;
    EXPECT_EQ(kite.tails, 3);
    EXPECT_EQ(row.expected(), "a number, 1 .. 9, plain (1), festive (7)");
    EXPECT_EQ(row.values(), "1 .. 9, plain (1), festive (7)");
    EXPECT_EQ(row.defaultText(), "2");
}

TEST(SettingTableOfAnyStruct, SaysWhatItUnderstandsAndLeavesTheRest)
{
    Kite kite;
    std::string error;
    const auto said = [&](const char* name, const char* text)
    {
        EXPECT_FALSE(table().set(kite, name, text, error)) << name;
        EXPECT_TRUE(table().areSame(kite, Kite())) << name;
        return error;
    };
    EXPECT_EQ(said("wind", "strong"), "wind is \"strong\", should be a number, 0 .. 40 m/s");
    EXPECT_EQ(said("flies", "maybe"), "flies is \"maybe\", should be true or false");
    EXPECT_EQ(said("tails", "2.5"), "tails is \"2.5\", should be a number, 1 .. 9");
    EXPECT_EQ(said("colour", "green"), "colour is \"green\", should be one of red, blue");
    EXPECT_EQ(said("weight", "1"),
              "unknown option \"weight\"; known are wind, name, flies, tails, colour, length");
}

TEST(SettingTableOfAnyStruct, ChecksAndRepairsRanges)
{
    Kite kite;
    kite.tails = 20;
    EXPECT_EQ(problem(kite), "kite: tails is 20; it must be within 1 .. 9");
    kite = {};
    kite.wind = NAN;
    EXPECT_EQ(problem(kite), "kite: wind is nan m/s; it must be within 0 .. 40");
    kite = {};
    kite.length = INFINITY;
    EXPECT_EQ(problem(kite), "kite: length is inf; it must be a number, 0 or at least 1 m");
    kite.colour = static_cast<Colour>(7);
    kite.tails = 0;
    EXPECT_EQ(table().repair(kite),
              (std::vector<std::string>{
                  "tails is 0, should be 1 .. 9; 2 is used",
                  "colour is number 7, should be one of red, blue; the default is used",
                  "length is inf, should be 0 or at least 1; 0 is used"}));
    EXPECT_TRUE(table().areSame(kite, Kite()));
}

TEST(SettingTableOfAnyStruct, KeepsWhatItsBaseSays)
{
    const Setting<Kite>* wind = table().find("wind");
    ASSERT_NE(wind, nullptr);
    EXPECT_EQ(wind->variable, "WIND");
    EXPECT_EQ(wind->summary(), "how it blows (0 .. 40 m/s; default 0.5)");
    Kite strong;
    strong.wind = 20.0;
    EXPECT_EQ(wind->summary(strong), "how it blows (0 .. 40 m/s; default 20)");
    EXPECT_FALSE(table().areSame(strong, Kite()));
    const SettingTable<Air> own({Row<Air>("wind", &Air::wind, "")
                                     .parsedBy([](Air&, const std::string&) { return false; })});
    EXPECT_THROW(inherited<Kite>(own.rows()), std::logic_error);
}
