#include "haptics/sensation/SensationReader.h"

#include "haptics/base/InputError.h"
#include "haptics/sensation/SensationValues.h"
#include "tests/haptics/sensation/Patterns.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::haptics;
using namespace patterns;

namespace
{

/// All that a pattern may have.
Json wholePattern()
{
    Json json = pattern({standard(0.0, coords(1, 2, 3)), pause(10.0), stop(20.0)});
    json["keyframes"][0]["brush"] = circle(number(5.0), number(70.0));
    json["keyframes"][0]["intensity"] = intensity(number(1.0));
    json["keyframes"][1]["cjumps"] = Json::array({jump("p", "lt", 1.0, 0.0)});
    define(json, "p", {{"default", 0.0}, {"min", -1.0}, {"max", 1.0}});
    return json;
}

std::string errorOf(const std::string& text)
{
    try
    {
        readSensation(text, "t.adaptics");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "";
}

std::string errorOf(const std::function<void(Json&)>& change)
{
    Json json = wholePattern();
    change(json);
    return errorOf(json.dump(1));
}

void expectRefused(const std::function<void(Json&)>& change, const std::string& field)
{
    const std::string error = errorOf(change);
    EXPECT_EQ(error.rfind("t.adaptics, line ", 0), 0U) << error;
    EXPECT_NE(error.find(": " + field + " "), std::string::npos) << error << "\nnot: " << field;
}

Json formulaOf(const std::string& type, const Json& value)
{
    return {{"type", type}, {"value", value}};
}

Json sumOf(int depth)
{
    const Json one = formulaOf("constant", 1.0);
    Json sum = one;
    for (int k = 1; k < depth; ++k)
        sum = formulaOf("add", Json::array({sum, one}));
    return {{"type", "formula"}, {"value", sum}};
}

} // namespace

TEST(SensationReader, ReadsTheThreeRevisionsAndNoOther)
{
    for (const char* revision : {"0.1.0-alpha.3", "0.1.0-alpha.2", "0.0.10-alpha.1"})
        EXPECT_EQ(errorOf([&](Json& json) { json["$REVISION"] = revision; }), "") << revision;
    expectRefused([](Json& json) { json["$REVISION"] = "0.1.0-alpha.4"; }, "$REVISION");
    expectRefused([](Json& json) { json["$DATA_FORMAT"] = "other"; }, "$DATA_FORMAT");
}

TEST(SensationReader, IgnoresUnknownKeysAndTakesNullForMissing)
{
    EXPECT_EQ(errorOf(
                  [](Json& json)
                  {
                      json["projection"] = "palm";
                      json["keyframes"][0]["brush"]["brush"]["params"]["more"] = 1;
                      json["keyframes"][1]["brush"] = nullptr;
                      json["keyframes"][1]["intensity"] = nullptr;
                      json["user_parameter_definitions"]["p"]["min"] = nullptr;
                  }),
              "");
}

TEST(SensationReader, SortsKeyframesAndReadsTheOldNameOfParameters)
{
    Json json = wholePattern();
    std::swap(json["keyframes"][0], json["keyframes"][2]);
    json["keyframes"][2]["intensity"] = intensity({{"type", "dynamic"}, {"value", "q"}});
    const auto sensation = read(json);
    EXPECT_EQ(sensation->keyframes.front().kind, SensationKeyframe::Kind::STANDARD);
    EXPECT_EQ(sensation->keyframes.back().kind, SensationKeyframe::Kind::STOP);
    ASSERT_EQ(sensation->parameters.size(), 2U);
    EXPECT_TRUE(sensation->parameters[0].isDefined);
    EXPECT_EQ(sensation->parameters[1].name, "q");
    EXPECT_FALSE(sensation->parameters[1].isDefined);
}

TEST(SensationReader, RefusesWhatIsBrokenByItsField)
{
    for (const char* key : {"$DATA_FORMAT",
                            "$REVISION",
                            "name",
                            "keyframes",
                            "pattern_transform",
                            "user_parameter_definitions"})
        EXPECT_NE(errorOf([&](Json& json) { json.erase(key); }).find(std::string("lacks '") + key),
                  std::string::npos)
            << key;
    const std::string first = "keyframes[0]";
    expectRefused([](Json& json) { json["keyframes"][0].erase("cjumps"); }, first);
    expectRefused([](Json& json) { json["keyframes"][0].erase("coords"); }, first);
    expectRefused([](Json& json) { json["keyframes"][0]["type"] = "start"; }, first + ".type");
    expectRefused([](Json& json) { json["keyframes"][2]["time"] = "20"; }, "keyframes[2].time");
    expectRefused([](Json& json) { json["keyframes"][0]["coords"]["coords"]["z"] = number(1.0); },
                  first + ".coords.coords.z");
    expectRefused([](Json& json)
                  { json["keyframes"][0]["coords"]["transition"] = variant("bezier"); },
                  first + ".coords.transition.name");
    expectRefused([](Json& json) { json["keyframes"][0]["coords"]["transition"].erase("params"); },
                  first + ".coords.transition");
    expectRefused([](Json& json)
                  { json["keyframes"][0]["brush"]["brush"]["params"]["radius"] = 5; },
                  first + ".brush.brush.params.radius");
    expectRefused([](Json& json) { json["keyframes"][0]["brush"]["brush"]["name"] = "point"; },
                  first + ".brush.brush.name");
    expectRefused([](Json& json)
                  { json["keyframes"][1]["cjumps"][0]["condition"]["operator"] = variant("eq"); },
                  "keyframes[1].cjumps[0].condition.operator.name");
    expectRefused([](Json& json) { json["user_parameter_definitions"]["p"]["min"] = 2; },
                  "user_parameter_definitions.p.min");
    expectRefused([](Json& json) { json["user_parameter_definitions"]["p"].erase("step"); },
                  "user_parameter_definitions.p");
    expectRefused([](Json& json)
                  { json["pattern_transform"]["playback_speed"] = formulaOf("f32", 1); },
                  "pattern_transform.playback_speed.type");
    expectRefused(
        [](Json& json)
        {
            json["pattern_transform"]["intensity_factor"] =
                formulaOf("formula", formulaOf("add", Json::array({formulaOf("constant", 1)})));
        },
        "pattern_transform.intensity_factor.value.value");
    expectRefused(
        [](Json& json) {
            json["pattern_transform"]["intensity_factor"] =
                formulaOf("formula", formulaOf("Constant", 1));
        },
        "pattern_transform.intensity_factor.value.type");
}

TEST(SensationReader, NamesTheLine)
{
    std::string text = wholePattern().dump(1);
    const std::size_t at = text.find("\"radius\"");
    const auto line = std::count(text.begin(), text.begin() + static_cast<long>(at), '\n') + 1;
    const std::size_t value = text.find("5.0", at);
    text.replace(value, 3, "\"5\"");
    EXPECT_EQ(errorOf(text),
              "t.adaptics, line " + std::to_string(line + 2) +
                  ": keyframes[0].brush.brush.params.radius.value is \"5\"; it must be a number");
    // Texts that aren't JSON have the parser's line.
    EXPECT_NE(errorOf("{\n\"name\": }").find("line 2"), std::string::npos);
    EXPECT_EQ(errorOf("{\n\"a\": 1,\n\"a\": 2}"),
              "t.adaptics, line 3: the key 'a' is there twice in its object");
}

TEST(SensationReader, HasLimits)
{
    const auto deep = [](int depth)
    { return [depth](Json& json) { json["pattern_transform"]["playback_speed"] = sumOf(depth); }; };
    EXPECT_EQ(errorOf(deep(64)), "");
    EXPECT_NE(errorOf(deep(65)).find("deeper than 64"), std::string::npos);
    EXPECT_NE(errorOf(std::string(100000, '[')).find("line 1: nests deeper"), std::string::npos);
    EXPECT_NE(errorOf(std::string(kMostSensationBytes + 1, ' ')).find("bytes"), std::string::npos);
    const auto frames = [](std::size_t count)
    {
        return errorOf([count](Json& json)
                       { json["keyframes"] = std::vector<Json>(count, stop(1.0)); });
    };
    EXPECT_EQ(frames(10000), "");
    EXPECT_NE(frames(10001).find("keyframes has 10001 entries"), std::string::npos);
}

TEST(SensationReader, LoadsFilesAndClassics)
{
    EXPECT_EQ(loadSensation(MIDAIR_TEST_DATA "/sensations/turned.adaptics").name, "turned");
    EXPECT_EQ(loadSensation("circle").name, "circle");
    try
    {
        loadSensation("circel");
        ADD_FAILURE() << "it must be refused";
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_NE(std::string(error.what()).find("did you mean circle?"), std::string::npos)
            << error.what();
    }
}

TEST(SensationReader, RefusesTheSharedFilesThatAreBroken)
{
    const std::filesystem::path folder = MIDAIR_ROOT "/../shared/cases/sensations";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no ../shared/cases/sensations";
    for (const char* name : {"bezier", "no_cjumps", "formula_arity", "plain_number"})
        EXPECT_THROW(loadSensation((folder / name).string() + ".adaptics"),
                     midair::base::InputError)
            << name;
}
