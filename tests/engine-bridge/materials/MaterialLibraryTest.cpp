#include "engine-bridge/materials/MaterialLibrary.h"

#include "haptics/base/InputError.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

std::string errorOf(const std::string& text)
{
    MaterialLibrary library;
    try
    {
        library.add(text, "own.json");
    }
    catch (const base::InputError& error)
    {
        EXPECT_TRUE(library.names().empty()); // nothing of it is taken
        return error.what();
    }
    ADD_FAILURE() << "taken: " << text;
    return {};
}

} // namespace

TEST(MaterialLibrary, TheShippedOnesAreValidAndDiffer)
{
    const MaterialLibrary library = MaterialLibrary::ofUser();
    EXPECT_TRUE(library.problems().empty());
    const std::vector<std::string> names = {"cloth", "glass", "rubber", "sandpaper", "skin"};
    EXPECT_EQ(library.names(), names);
    for (const std::string& a : names)
    {
        ASSERT_TRUE(library.find(a));
        EXPECT_TRUE(library.find(a)->isValid());
        for (const std::string& b : names)
            EXPECT_EQ(*library.find(a) == *library.find(b), a == b);
    }
    EXPECT_EQ(library.find("Glass"), nullptr);
    EXPECT_GT(library.find("glass")->stiffness_N_m, library.find("skin")->stiffness_N_m);
    EXPECT_EQ(library.find("glass")->roughness, 0.0);
    EXPECT_GT(library.find("sandpaper")->roughness, library.find("cloth")->roughness);
}

TEST(MaterialLibrary, AFileOfOnesOwnReplacesAndAdds)
{
    MaterialLibrary library = MaterialLibrary::ofUser();
    library.add(R"({"materials": {"glass": {"stiffness_N_m": 55}, "moss": {"roughness": 0.3}}})",
                "own.json");
    EXPECT_EQ(library.find("glass")->stiffness_N_m, 55.0);
    EXPECT_EQ(library.find("moss")->roughness, 0.3);
    EXPECT_EQ(library.find("moss")->mostForce_N, HapticMaterial().mostForce_N);
    EXPECT_EQ(library.names().size(), 6u);
}

TEST(MaterialLibrary, WhatIsNotUnderstoodIsNamed)
{
    EXPECT_NE(errorOf("{").find("own.json: not JSON"), std::string::npos);
    EXPECT_NE(errorOf("{}").find("materials"), std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": []})").find("materials"), std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": {"moss": {"roughnes": 0.3}}})").find("roughnes"),
              std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": {"moss": {"roughness": "much"}}})").find("roughness"),
              std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": {"moss": {"roughness": 3}}})").find("within 0 .. 1"),
              std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": {"moss": {"roughness": 0.6, "lowVibration": 0.6}}})")
                  .find("at most 1"),
              std::string::npos);
    EXPECT_NE(errorOf(R"({"materials": {"moss": {"radius_m": 0.1}}})").find("0.02"),
              std::string::npos);
}
