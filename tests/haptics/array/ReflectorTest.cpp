// Reflectors in files: read back, and refused by the name of the field that is wrong.
#include "haptics/array/Reflector.h"

#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

const std::string kReflectorPlace =
    R"("position_m": [0, 0, 0.3], "normal": [0, 0, -2], "accuracy_mm": 0.2)";
const std::string kReflectorSides = R"(, "along": [1, 0, 0], "size_m": [0.3, 0.2])";

std::string reflectorList(const std::string& item)
{
    return R"({"reflectors": [{)" + item + "}]}";
}

std::string reflectorMessage(const std::string& json)
{
    try
    {
        reflectorsFromJson(json, "r.json");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

TEST(ReflectorFile, IsRead)
{
    const auto all =
        reflectorsFromJson(reflectorList(kReflectorPlace + kReflectorSides +
                                         R"(, "name": "table", "reflection": 0.9, "comment": "oak",
                                     "reflectionPhase_rad": -0.5)"),
                           "r.json");
    ASSERT_EQ(all.size(), 1U);
    const Reflector& one = all.front();
    EXPECT_EQ(one.called(0), "reflector 'table'");
    EXPECT_EQ(one.normal, -Eigen::Vector3d::UnitZ());
    EXPECT_EQ(one.across(), Eigen::Vector3d(0.0, -1.0, 0.0));
    EXPECT_EQ(one.size_m, Eigen::Vector2d(0.3, 0.2));
    EXPECT_EQ(one.reflection, 0.9);
    EXPECT_EQ(one.reflectionPhase_rad, -0.5);
    EXPECT_EQ(one.accuracy_mm, 0.2);
    EXPECT_EQ(reflectorsFromJson("{\"reflectors\": " + reflectorsToJson(all) + "}", ""), all);
    EXPECT_EQ(one.mirrored({0.1, 0.2, 0.25}), Eigen::Vector3d(0.1, 0.2, 0.35));
    EXPECT_NEAR(one.distanceTo({0.18, 0.14, 0.3}), 0.05, 1e-12);
    EXPECT_NEAR(one.distanceTo({0.1, 0.0, 0.28}), 0.02, 1e-12);

    const auto endless = reflectorsFromJson(reflectorList(kReflectorPlace), "r.json");
    EXPECT_TRUE(std::isinf(endless.front().size_m[0]));
    EXPECT_EQ(endless.front().called(0), "reflector 0");
    EXPECT_TRUE(areValid(endless));
    EXPECT_EQ(reflectorsFromJson("{\"reflectors\": " + reflectorsToJson(endless) + "}", ""),
              endless);
}

TEST(ReflectorFile, WhatIsWrongIsNamed)
{
    const auto refuses = [](const std::string& json, const std::string& start)
    { EXPECT_EQ(reflectorMessage(json).find("r.json: " + start), 0U) << reflectorMessage(json); };
    refuses("{}", "lacks 'reflectors'");
    refuses(R"({"reflectors": 3})", "reflectors is 3; it must be a list");
    refuses(reflectorList(R"("normal": [0, 0, 1])"), "reflectors[0] lacks 'position_m'");
    refuses(reflectorList(R"("position_m": [0, 0, 0], "normal": [0, 0, 0])"),
            "reflectors[0].normal is [0,0,0]");
    refuses(reflectorList(R"("position_m": [0, 0, 300], "normal": [0, 0, 1])"),
            "reflectors[0].position_m is [0,0,300]");
    refuses(reflectorList(R"("position_m": [0, 0, 0], "normal": [0, 0, 1])"),
            "reflectors[0] lacks 'accuracy_mm'");
    refuses(reflectorList(kReflectorPlace + R"(, "size_m": [1, 1])"),
            "reflectors[0] lacks 'along'");
    refuses(reflectorList(kReflectorPlace + R"(, "size_m": [1, 0], "along": [1, 0, 0])"),
            "reflectors[0].size_m is [1,0]");
    refuses(reflectorList(kReflectorPlace + R"(, "size_m": [1, 1], "along": [0, 0, 1])"),
            "reflectors[0].along is [0,0,1]");
    refuses(reflectorList(kReflectorPlace + R"(, "reflection": 1.1)"),
            "reflectors[0].reflection is 1.1");
    refuses(reflectorList(kReflectorPlace + R"(, "reflectionPhase_rad": "x")"),
            "reflectors[0].reflectionPhase_rad is \"x\"");
    refuses(reflectorList(kReflectorPlace + R"(, "colour": 1)"),
            "reflectors[0] has the unknown key 'colour'");
    std::string nine = "{" + kReflectorPlace + "}";
    for (int k = 1; k < 9; ++k)
        nine += ", {" + kReflectorPlace + "}";
    refuses("{\"reflectors\": [" + nine + "]}",
            "reflectors can't be used: reflectors are 9; at most 8 are possible");
}

TEST(ReflectorFile, ArraysHaveTheirOwn)
{
    TransducerArray array = TransducerArray::fromJson(
        R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "point",
            "transducers": [{"position_m": [0, 0, 0], "normal": [0, 0, 1]}],
            "reflectors": [{)" +
            kReflectorPlace + kReflectorSides + "}]}",
        "a.json");
    ASSERT_EQ(array.reflectors.size(), 1U);
    EXPECT_EQ(TransducerArray::fromJson(array.toJson(), "b.json").reflectors, array.reflectors);
    std::string error;
    EXPECT_TRUE(array.isValid(&error)) << error;
    array.reflectors.front().reflection = NAN;
    EXPECT_FALSE(array.isValid(&error));
    EXPECT_EQ(error, "reflector 0: its reflection is nan; it must be within 0 .. 1");
    array.reflectors.assign(9, Reflector());
    EXPECT_FALSE(array.isValid(&error));
    EXPECT_EQ(error, "reflectors are 9; at most 8 are possible");
}
