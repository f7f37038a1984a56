// How loud a scene is at ears, and its limit there.
#include "haptics/base/text/Quantity.h"
#include "plugin/report/Report.h"
#include "plugin/settings/UserOptions.h"
#include "tests/device/limits/UserCapTexts.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticStatistics>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace osgMidair;

namespace
{

/// The settings that a variable of the environment leaves.
HapticSettings fromVariable(const char* name, const char* value, const HapticSettings& given)
{
    std::vector<std::string> errors;
    ::setenv(name, value, 1);
    HapticSettings settings = Environment::restrict(Environment::replace(given, errors));
    ::unsetenv(name);
    settings.repair();
    return settings;
}

bool plays(BoxScene& box)
{
    HeadlessViewer viewer(box.scene);
    viewer.frames(30);
    viewer.framesUntil(
        [&]
        {
            const HapticStatistics now = box.scene->getStatistics();
            return now.processed >= now.snapshots;
        });
    return box.result() && box.result()->played().norm() > 0.0f;
}

} // namespace

TEST(Ears, StatisticsAndReportTellTheExposure)
{
    BoxScene box;
    box.scene->setEarPoints("0 0 0.6; 20 0 50 cm");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const HapticStatistics statistics = box.scene->getStatistics();
    EXPECT_EQ(statistics.exposure.places, 32);
    EXPECT_EQ(statistics.exposure.limit_dB, 0.0);
    EXPECT_GT(statistics.exposure.level_dB, 110.0);
    EXPECT_LT(statistics.exposure.level_dB, 160.0);
    const nlohmann::json json =
        nlohmann::json::parse(reportJson(statistics, box.scene->getSettings(), nullptr));
    EXPECT_EQ(json["exposure"]["places"], 32);
    EXPECT_EQ(json["exposure"]["level_dB"], statistics.exposure.level_dB);
    EXPECT_NE(std::string(json["exposure"]["what"]).find("not a safety certificate"),
              std::string::npos);
}

TEST(Ears, ALimitHoldsAndAnotherActsAtOnce)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const double free_dB = box.scene->getStatistics().exposure.level_dB;
    ASSERT_GT(free_dB, 112.0);
    box.scene->setEarLimit(112.0);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result()->report().capFactor < 1.0; }));
    const auto held = box.result();
    EXPECT_EQ(held->exposure.limit_dB, 112.0);
    EXPECT_LE(held->exposure.level_dB, 112.0);
    EXPECT_EQ(box.scene->getStatistics().messages.back(),
              "the field is held down to the ear limit of 112 dB");
    EXPECT_EQ(box.scene->getStatistics().told.back().code, "cap.ears");
    // A scene inside may lower it, never raise it.
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    inner->setEarLimit(106.0);
    box.scene->addChild(inner);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result()->exposure.limit_dB == 106.0; }));
    EXPECT_LE(box.result()->exposure.level_dB, 106.0);
    inner->setEarLimit(130.0);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result()->exposure.limit_dB == 112.0; }));
}

TEST(Ears, OfTheUsersLimitAndTheScenesTheStricterCounts)
{
    const HapticSettings none;
    HapticSettings scene;
    scene.earLimit = 115.0;
    EXPECT_EQ(fromVariable("OSG_MIDAIR_EAR_LIMIT", "110", scene).earLimit, 110.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_EAR_LIMIT", "110 dB", scene).earLimit, 110.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_EAR_LIMIT", "120", scene).earLimit, 115.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_EAR_LIMIT", "0", scene).earLimit, 115.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_EAR_LIMIT", "120", none).earLimit, 120.0);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_EAR_LIMIT", "120", none).isSilenced);
}

TEST(Ears, ALimitThatIsNotUnderstoodSilencesAndSaysWhy)
{
    const HapticSettings none;
    for (const char* wrong :
         {"abc", "130 bananas", "-5", "nan", "inf", "12", "1e9", "110,5", "110 Pa"})
    {
        const HapticSettings settings = fromVariable("OSG_MIDAIR_EAR_LIMIT", wrong, none);
        EXPECT_TRUE(settings.isSilenced) << wrong;
        ASSERT_FALSE(settings.whySilenced.empty()) << wrong;
        EXPECT_NE(settings.whySilenced[0].find("nothing is played"), std::string::npos)
            << settings.whySilenced[0];
        HapticSettings option;
        std::string error;
        option.set("earLimit", wrong, error);
        option.repair();
        EXPECT_TRUE(option.isSilenced) << wrong;
    }
    EXPECT_TRUE(fromVariable("OSG_MIDAIR_EAR_LIMITS", "110", none).isSilenced) << "misspelt";
    for (const double wrong : {std::nan(""), -1.0, 5.0, std::numeric_limits<double>::infinity()})
    {
        EXPECT_FALSE(HapticSettings::isLimit(0.0, 1.0, wrong)) << wrong;
        BoxScene box;
        box.scene->setEarLimit(wrong);
        EXPECT_FALSE(plays(box)) << wrong;
        ASSERT_FALSE(box.scene->getStatistics().messages.empty());
        EXPECT_NE(box.scene->getStatistics().messages[0].find("earLimit is "), std::string::npos)
            << box.scene->getStatistics().messages[0];
    }
    BoxScene box;
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    inner->setEarLimit(std::nan(""));
    box.scene->addChild(inner);
    EXPECT_FALSE(plays(box));
}

TEST(Ears, PlacesAreReadOrSilence)
{
    std::vector<std::array<double, 3>> places;
    EXPECT_TRUE(midair::base::parsePlaces("", places));
    EXPECT_TRUE(places.empty());
    EXPECT_TRUE(midair::base::parsePlaces("0 0 0.6; 10 20 30 cm;", places));
    ASSERT_EQ(places.size(), 2u);
    EXPECT_EQ(places[1], (std::array<double, 3>{0.1, 0.2, 0.3}));
    for (const char* wrong : {"0 0", "1 2 3 4", "a b c", "0 0 nan", "0 0 1;; 0 0 2", "0 0 1 kg"})
    {
        EXPECT_FALSE(midair::base::parsePlaces(wrong, places)) << wrong;
        BoxScene box;
        box.scene->setEarPoints(wrong);
        EXPECT_FALSE(plays(box)) << wrong;
        EXPECT_NE(box.scene->getStatistics().messages[0].find("earPoints is \""), std::string::npos)
            << box.scene->getStatistics().messages[0];
    }
    std::string many = "0 0 1";
    for (int k = 0; k < 64; ++k)
        many += ";0 0 1";
    EXPECT_FALSE(midair::base::parsePlaces(many, places));
    EXPECT_EQ(places.size(), 2u) << "unchanged";
    BoxScene right;
    right.scene->setEarPoints("0 0 0.5");
    EXPECT_TRUE(plays(right));
}

TEST(Ears, EachTextOfTheUsersCapsIsUnderstoodOrSilences)
{
    for (const UserCapText& one : userCapTexts())
    {
        const HapticSettings settings =
            fromVariable(one.variable, one.text.c_str(), HapticSettings());
        EXPECT_EQ(settings.isSilenced, !one.isUnderstood) << one.variable << "=" << one.text;
        if (one.isUnderstood) continue;
        ASSERT_FALSE(settings.whySilenced.empty()) << one.variable << "=" << one.text;
        EXPECT_EQ(settings.whySilenced[0].rfind(std::string(one.variable) + " is \"", 0), 0U)
            << settings.whySilenced[0];
    }
    const SetVariable wrong("OSG_MIDAIR_EAR_POINTS", "0 0 0.6;;0.3 0 0.6");
    BoxScene box;
    EXPECT_FALSE(plays(box));
}

TEST(Ears, TheUsersPlacesAreListenedAtBesidesTheScenes)
{
    const SetVariable places("OSG_MIDAIR_EAR_POINTS", "0 0 0.6; 0 0.1 0.6");
    BoxScene box;
    box.scene->setEarPoints("0 0 0.7");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(box.scene->getStatistics().exposure.places, 33);
}

TEST(Ears, AVariableThatIsSetWhileItPlaysHoldsFromThenOn)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    ASSERT_EQ(box.result()->maxPressure_Pa, 0.0);
    {
        const SetVariable pressure("OSG_MIDAIR_MAX_PRESSURE", "100");
        EXPECT_TRUE(viewer.framesUntil([&] { return box.result()->maxPressure_Pa == 100.0; }));
        const SetVariable ears("OSG_MIDAIR_EAR_LIMIT", "112");
        EXPECT_TRUE(viewer.framesUntil([&] { return box.result()->exposure.limit_dB == 112.0; }));
    }
    EXPECT_TRUE(viewer.framesUntil([&] { return box.result()->maxPressure_Pa == 0.0; }));
    const SetVariable wrong("OSG_MIDAIR_EAR_POINTS", "here");
    EXPECT_TRUE(viewer.framesUntil(
        [&]
        {
            const std::vector<std::string> all = box.scene->getStatistics().messages;
            return std::any_of(all.begin(),
                               all.end(),
                               [](const std::string& one)
                               { return one.rfind("OSG_MIDAIR_EAR_POINTS is", 0) == 0; });
        }));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state != ArrayState::PLAYING; }));
}

TEST(Ears, TheCameraIsAHeadWhereTheSceneSaysSo)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0.0, 0.0, 0.6), osg::Vec3d(0.0, 0.0, 0.0), osg::Vec3d(0.0, 1.0, 0.0));
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(box.scene->getStatistics().exposure.places, 30);
    box.scene->setEarCamera(true);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return box.scene->getStatistics().exposure.places == 32; }));
    // Moved into the beam, it hears more.
    const double before_dB = box.scene->getStatistics().exposure.level_dB;
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0.08, 0.0, 0.16), osg::Vec3d(0.08, 0.0, 0.0), osg::Vec3d(0.0, 1.0, 0.0));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().exposure.level_dB > before_dB + 3.0; }));
}

TEST(Ears, SetByNumberEachHasALevelOfItsOwn)
{
    BoxScene box;
    box.scene->setMetresPerUnit(0.01);
    box.transform->setMatrix(osg::Matrixd::scale(100.0, 100.0, 100.0) *
                             osg::Matrixd::translate(0.0, 0.0, 15.0));
    box.scene->setEarPoints("0 0.5 0.5");
    box.scene->setEars({{0.0, 0.0, 17.0}, {40.0, 0.0, 30.0}}); // in the box's beam, and beside it
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(box.scene->getStatistics().ears.empty());
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const HapticStatistics now = box.scene->getStatistics();
    EXPECT_EQ(now.exposure.places, 33);
    ASSERT_EQ(now.ears.size(), 3u);
    EXPECT_NEAR(now.ears[0].z_m, 0.17, 1e-9);
    EXPECT_NEAR(now.ears[1].x_m, 0.4, 1e-9);
    EXPECT_NEAR(now.ears[2].y_m, 0.5, 1e-9);
    EXPECT_GT(now.ears[0].level_dB, now.ears[1].level_dB + 3.0);
    EXPECT_LE(now.ears[0].level_dB, now.exposure.level_dB);
    for (const auto& ear : now.ears)
        EXPECT_GT(ear.level_dB, 60.0);
    EXPECT_EQ(box.scene->getEars().size(), 2u);
}

TEST(Ears, WhereNoLimitBindsNothingIsSolvedWhenTheyMove)
{
    for (const double limit_dB : {0.0, 170.0})
    {
        BoxScene box;
        box.scene->setEarLimit(limit_dB);
        box.scene->setEars({{0.3, 0.0, 0.5}});
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        ASSERT_TRUE(box.scene->waitForField(60.0));
        const auto solves = box.scene->getStatistics().solves;
        for (int i = 0; i < 60; ++i)
        {
            box.scene->setEars({{0.3 + 0.02 * i, 0.0, 0.5}});
            viewer.frame();
            ASSERT_TRUE(box.scene->waitForField(60.0));
        }
        EXPECT_EQ(box.scene->getStatistics().solves, solves) << limit_dB;
        EXPECT_NEAR(box.scene->getStatistics().ears.at(0).x_m, 0.3 + 0.02 * 59, 1e-9);
    }
}

TEST(Ears, TheLimitHoldsWhereAnEarHasMoved)
{
    BoxScene box;
    box.scene->setEars({{0.5, 0.0, 0.4}});
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    ASSERT_TRUE(box.scene->waitForField(60.0));
    const double free_dB = box.scene->getStatistics().exposure.level_dB;
    const double limit_dB = free_dB + 7.0; // with what phases that nobody knows may add
    box.scene->setEarLimit(limit_dB);
    box.scene->setEars({{0.0, 0.0, 0.17}}); // in the beam
    viewer.frame();
    ASSERT_TRUE(box.scene->waitForField(60.0));
    EXPECT_LT(box.result()->report().capFactor, 1.0);
    EXPECT_LE(box.scene->getStatistics().ears.at(0).level_dB, limit_dB);
    const auto held = box.result()->report().level_Pa;
    // Away from it the field is as loud as it was.
    box.scene->setEars({{0.5, 0.0, 0.4}});
    viewer.frame();
    ASSERT_TRUE(box.scene->waitForField(60.0));
    EXPECT_GT(box.result()->report().level_Pa, held);
}

TEST(Ears, OneThatIsNowhereSilences)
{
    BoxScene box;
    box.scene->setEars({{0.0, 0.0, 0.5}, {0.0, std::nan(""), 0.5}});
    EXPECT_FALSE(plays(box));
    EXPECT_TRUE(says(*box.scene, "an ear is at a place that is not finite; nothing is played"));
    std::string why;
    EXPECT_FALSE(box.scene->waitForField(1e6, &why));
    EXPECT_NE(why.find("an ear is at a place"), std::string::npos) << why;
    box.scene->setEars({{0.0, 0.0, 0.5}});
    EXPECT_TRUE(plays(box));
    box.scene->setEars(std::vector<osg::Vec3d>(67, osg::Vec3d(0.0, 0.0, 0.5)));
    EXPECT_FALSE(plays(box));
}
