#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"

#include <functional>

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

std::string refusal(const std::function<void()>& read)
{
    try
    {
        read();
    }
    catch (const InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(IndexList, NumbersAndRanges)
{
    EXPECT_EQ(parseIndices("", "dead"), std::vector<int>());
    EXPECT_EQ(parseIndices("  ", "dead"), std::vector<int>());
    EXPECT_EQ(parseIndices("17,400-403", "dead"), (std::vector<int>{17, 400, 401, 402, 403}));
    EXPECT_EQ(parseIndices(" 9 , 3 - 4,0", "dead"), (std::vector<int>{0, 3, 4, 9}));
    EXPECT_EQ(parseIndices("0-65535", "dead").size(), 65536U);
}

TEST(IndexList, AnythingElseIsRefused)
{
    for (const char* part :
         {"x", "", "1.5", "-1", "4-3", "1-", "-", "65536", "1-2-3", "1e9", "1:2"})
        EXPECT_EQ(refusal([&] { parseIndices(std::string("7,") + part, "dead"); }),
                  std::string("dead has \"") + part +
                      "\", should be numbers of transducers and ranges of them, 0 to 65535: 17, "
                      "400-410");
    EXPECT_EQ(refusal([] { parseIndices("5,1-9", "dead"); }),
              "dead has 5 twice; it must be there once");
}

// A text of a megabyte can't ask for gigabytes.
TEST(IndexList, RangesDontPileUp)
{
    std::string text = "0-65535";
    for (int k = 0; k < 10000; ++k)
        text += ",0-65535";
    EXPECT_EQ(refusal([&] { parseIndices(text, "dead"); }),
              "dead has 0 twice; it must be there once");
}

TEST(IndexList, EachWithANumber)
{
    using Numbers = std::vector<std::pair<int, double>>;
    EXPECT_EQ(parseIndexedNumbers("", "weak", 10.0), Numbers());
    EXPECT_EQ(parseIndexedNumbers("9:0.5, 3-4 : 2", "weak", 10.0),
              (Numbers{{3, 2.0}, {4, 2.0}, {9, 0.5}}));
    for (const char* part : {"9", "9:", "9:0", "9:-1", "9:10.1", "9:nan", "9:0,5", ":1", "x:1"})
        EXPECT_NE(refusal([&] { parseIndexedNumbers(part, "weak", 10.0); }), "") << part;
    EXPECT_EQ(refusal([] { parseIndexedNumbers("9:0", "weak", 10.0); }),
              "weak has \"9:0\", should be transducers, 0 to 65535, each with a number above 0, at "
              "most 10: 17:0.5, 400-410:0.8");
}
