#include "haptics/base/text/JsonLines.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/JsonValue.h"

#include <string>

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

const std::string kText = R"({
 "a": 1,
 "list": [
  {"x": 1},
  {
   "x": {
    "y": [1,
     2]
   }
  }
 ],
 "b": {"a": 3}
})";

} // namespace

TEST(JsonLines, NameTheLineOfAValue)
{
    EXPECT_EQ(jsonLine(kText, ""), 1U);
    EXPECT_EQ(jsonLine(kText, "a"), 2U);
    EXPECT_EQ(jsonLine(kText, "list"), 3U);
    EXPECT_EQ(jsonLine(kText, "list[0].x"), 4U);
    EXPECT_EQ(jsonLine(kText, "list[1]"), 5U);
    EXPECT_EQ(jsonLine(kText, "list[1].x"), 6U);
    EXPECT_EQ(jsonLine(kText, "list[1].x.y"), 7U);
    EXPECT_EQ(jsonLine(kText, "b.a"), 12U);
    EXPECT_EQ(jsonLine(kText, "c"), 1U);
}

TEST(JsonLines, RefuseDepthAndDoubleKeys)
{
    EXPECT_NO_THROW(requirePlainJson(kText, "f", 5));
    EXPECT_NO_THROW(requirePlainJson("[1, ", "f", 5)); // not JSON, which parseJson() says
    EXPECT_THROW(requirePlainJson(kText, "f", 4), InputError);
    try
    {
        requirePlainJson("{\"a\": {},\n\"b\": {\"c\": 1,\n\"c\": 2}}", "f", 5);
        ADD_FAILURE() << "it must be refused";
    }
    catch (const InputError& error)
    {
        EXPECT_STREQ(error.what(), "f, line 3: the key 'c' is there twice in its object");
    }
}

TEST(JsonLines, PathsAreThoseOfErrors)
{
    const JsonValue::Json json = parseJson(kText, "f");
    const std::string source = "f";
    const JsonValue root(source, json);
    try
    {
        (void)root.required("list", "a list")[1].required("x", "y").string();
        ADD_FAILURE() << "it must be refused";
    }
    catch (const JsonError& error)
    {
        EXPECT_EQ(error.path, "list[1].x");
        EXPECT_EQ(error.what(), "f: " + error.reason);
        EXPECT_EQ(jsonLine(kText, error.path), 6U);
    }
}
