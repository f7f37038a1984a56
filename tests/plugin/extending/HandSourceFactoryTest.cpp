#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldSolver>
#include <osgMidair/HandSourceFactory>

#include <osgDB/ReaderWriter>
#include <osgDB/Registry>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

std::string asked; ///< options of the last source that was made
int late = 0;      ///< how many times one can't be made

osg::ref_ptr<HandSource> make(const std::string& options, std::string& error)
{
    asked = options;
    if (options == "throw") throw std::runtime_error("no tracker");
    if (options == "refuse") error = "the glove is not charged";
    if (options == "refuse") return nullptr;
    if (options == "late" && late > 0)
    {
        --late;
        error = "the glove is not charged";
        return nullptr;
    }
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    hands->setHands({openHand(0, osg::Vec3d(0.0, 0.0, 0.2), osg::Quat())});
    return hands;
}

class HandSourceFactoryTest : public testing::Test
{
protected:
    void SetUp() override
    {
        std::string error;
        static const bool registered = registerHandSource("glove", make, error);
        ASSERT_TRUE(registered) << error;
    }
};

} // namespace

TEST_F(HandSourceFactoryTest, ANameHasOneMeaning)
{
    std::string error;
    EXPECT_FALSE(registerHandSource("glove", make, error));
    EXPECT_EQ(error, "the name \"glove\" is taken");
    EXPECT_FALSE(registerHandSource("openxr", make, error));
    EXPECT_EQ(error, "the name \"openxr\" is taken");
    EXPECT_FALSE(registerHandSource("My glove", make, error));
    EXPECT_EQ(
        error,
        "\"My glove\" is not a valid name of a hand source; it must have 1 to 32 small letters, "
        "digits and dashes");
    EXPECT_FALSE(registerHandSource("other", {}, error));
    EXPECT_EQ(error, "the hand source \"other\" was registered without a factory");
}

TEST_F(HandSourceFactoryTest, ASceneFindsItByName)
{
    BoxScene box;
    box.scene->setHands("glove:left?port=3");
    HeadlessViewer viewer(box.scene);
    viewer.frames(2);
    EXPECT_EQ(asked, "left?port=3");
    EXPECT_EQ(box.scene->getStatistics().hands, 1);
}

TEST_F(HandSourceFactoryTest, WhatItRefusesOrThrowsIsAMessage)
{
    for (const auto& [options, what] :
         {std::pair{"refuse", "hand source \"glove:refuse\": the glove is not charged"},
          std::pair{"throw",
                    "hand source \"glove:throw\": what makes it has thrown \"no tracker\""}})
    {
        BoxScene box;
        box.scene->setHands(std::string("glove:") + options);
        HeadlessViewer viewer(box.scene);
        viewer.frames(2);
        const auto told = box.scene->getStatistics().told;
        ASSERT_EQ(told.size(), 1u);
        EXPECT_EQ(told[0].text, what);
        EXPECT_EQ(told[0].code, "hands.open");
    }
    std::string error;
    EXPECT_EQ(openHandSource("mitten:", error), nullptr);
    EXPECT_EQ(
        error,
        "hand source \"mitten:\" is not known; recorded:FILE, recorded:FILE?loop, mouse:, openxr:, "
        "osc: and glove: are");
}

TEST_F(HandSourceFactoryTest, OneThatCouldNotBeMadeIsTriedAgain)
{
    BoxScene box;
    late = 2;
    box.scene->setHands("glove:late");
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().hands == 1; }));
    const auto told = box.scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told[0].code, "hands.open");
    EXPECT_EQ(told[0].count, 2u) << "each try that failed";
}

TEST_F(HandSourceFactoryTest, AFileNeedsAGrant)
{
    const auto asks = [](HapticScene& scene, const std::string& hands)
    {
        HapticSettings settings;
        settings.array = "board";
        settings.hands = hands;
        settings.wishes.asked["hands"] = hands; // as if it came from a file
        scene.setSettings(settings);
    };
    BoxScene box;
    asks(*box.scene, "glove:left");
    HeadlessViewer viewer(box.scene);
    viewer.frames(2);
    EXPECT_EQ(box.scene->getStatistics().hands, 0);
    ASSERT_EQ(box.scene->getStatistics().told.size(), 1u);
    EXPECT_EQ(box.scene->getStatistics().told[0].code, "grants.refused");

    std::string folder = (std::filesystem::temp_directory_path() / "midair-XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    std::ofstream(folder + "/grants") << "left = glove:left\n";
    setenv("OSG_MIDAIR_GRANTS", (folder + "/grants").c_str(), 1);
    asks(*box.scene, "left");
    viewer.frames(2);
    unsetenv("OSG_MIDAIR_GRANTS");
    std::filesystem::remove_all(folder);
    EXPECT_EQ(box.scene->getStatistics().hands, 1);
    EXPECT_EQ(box.scene->getStatistics().told.size(), 1u);
}

TEST_F(HandSourceFactoryTest, IsListedWithTheKitsOwn)
{
    findPlugins();
    osgDB::ReaderWriter* haptic =
        osgDB::Registry::instance()->getReaderWriterForExtension("haptic");
    ASSERT_NE(haptic, nullptr);
    const std::string hands = haptic->supportedOptions().at("hands=");
    EXPECT_NE(hands.find("openxr:"), std::string::npos) << hands;
    EXPECT_NE(hands.find("registered: glove:"), std::string::npos) << hands;
    std::string error;
    registerSolver(
        "listed", [] { return osg::ref_ptr<FieldSolver>(); }, error);
    const std::string solver = haptic->supportedOptions().at("solver=");
    EXPECT_NE(solver.find("listed"), std::string::npos) << solver;
}
