// A scene whose temperature follows a thermometer while it plays, and one with dead transducers.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticField>
#include <osgMidair/HapticStatistics>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

std::string writtenFile(const std::string& text)
{
    const std::string path =
        testing::TempDir() + "midair-thermometer-" + std::to_string(::getpid());
    std::ofstream(path) << text;
    return path;
}

int countOf(const HapticScene& scene, const std::string& code)
{
    int count = 0;
    for (const auto& told : scene.getStatistics().told)
        count += told.code == code;
    return count;
}

} // namespace

TEST(Thermometer, FieldsFollowItAndTheDeviceStaysOpen)
{
    const std::string file = writtenFile("20.5\n");
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(box.scene->getStatistics().temperature_C, 20.0);
    const auto array = SceneAccess::engine(*box.scene).array();
    box.scene->setTemperatureSource(file);
    double before_C = 20.0;
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            const double now_C = box.scene->getStatistics().temperature_C;
            EXPECT_LE(std::fabs(now_C - before_C), 0.1 + 1e-9);
            before_C = now_C;
            EXPECT_NE(box.scene->getStatistics().state, ArrayState::CLOSED);
            return std::fabs(now_C - 20.5) < 0.05 && box.result() &&
                   std::fabs(SceneAccess::engine(*box.scene).medium().temperature_C - 20.5) < 0.05;
        }));
    EXPECT_EQ(SceneAccess::engine(*box.scene).array(), array) << "it was loaded once";
    EXPECT_EQ(countOf(*box.scene, "air.temperature"), 0);
    // Without it the temperature is the one that is set.
    box.scene->setTemperatureSource("");
    viewer.frames(2);
    EXPECT_EQ(box.scene->getStatistics().temperature_C, 20.0);
    std::filesystem::remove(file);
}

TEST(Thermometer, WhatIsWrongIsToldAndPlaysOn)
{
    BoxScene box;
    box.scene->setTemperatureSource("/nowhere/thermometer");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.points() > 0 && countOf(*box.scene, "air.temperature") == 1; }));
    EXPECT_GT(box.result()->played().norm(), 0.0F);
    EXPECT_EQ(box.scene->getStatistics().temperature_C, 20.0);
}

TEST(DeadInScene, AreDrivenWithNothingAndAListThatIsWrongPlaysNothing)
{
    BoxScene box;
    box.scene->setDead("17, 100-110");
    box.scene->setWeak("0:0.5");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const Eigen::VectorXcf played = box.result()->played();
    ASSERT_EQ(played.size(), 249);
    for (int i = 0; i < 249; ++i)
        EXPECT_EQ(std::abs(played[i]) == 0.0F, i == 17 || (i >= 100 && i <= 110)) << i;
    EXPECT_EQ(SceneAccess::engine(*box.scene).array()->gain[0], 0.5);
    // Another list, while it plays.
    box.scene->setDead("18");
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            const auto result = box.result();
            return result && result->played().size() == 249 &&
                   std::abs(result->played()[17]) > 0.0F && std::abs(result->played()[18]) == 0.0F;
        }));
    box.scene->setDead("249");
    ASSERT_TRUE(viewer.framesUntil([&] { return countOf(*box.scene, "array.invalid") == 1; }));
    box.scene->setDead("18 19");
    viewer.frames(2);
    EXPECT_EQ(countOf(*box.scene, "settings.silenced"), 1);
}
