#include "haptics/sensation/SensationClassics.h"

#include "haptics/base/InputError.h"
#include "haptics/sensation/SensationFigures.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

SensationPlayer playerOf(const std::string& text)
{
    return SensationPlayer(std::make_shared<const Sensation>(classicSensation(text)));
}

SensationFigures figuresOf(const std::string& text)
{
    SensationPlayer player = playerOf(text);
    return measureSensation(player, 5000.0);
}

std::string classicErrorOf(const std::string& text)
{
    try
    {
        classicSensation(text);
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "";
}

} // namespace

TEST(SensationClassics, ArePlayedByName)
{
    for (const std::string& name : sensationClassics())
    {
        SCOPED_TRACE(name);
        const SensationFigures figures = figuresOf(name);
        EXPECT_GT(figures.mostIntensity, 0.9);
        EXPECT_FALSE(figures.isBroken);
        EXPECT_FALSE(figures.isLimited);
        EXPECT_LT(figures.high_mm.norm(), 150.0);
        EXPECT_EQ(describeClassic(name).rfind(name + ": ", 0), 0U);
    }
    EXPECT_EQ(sensationClassics().size(), 13U);
}

TEST(SensationClassics, HaveTheFiguresOfTheirSources)
{
    const SensationFigures circle = figuresOf("circle");
    EXPECT_NEAR(circle.high_mm.x(), 20.0, 0.01);
    EXPECT_NEAR(circle.speed_m_s, 8.8, 0.01); // 2 pi x 20 mm x 70 Hz
    EXPECT_FALSE(circle.duration_ms.has_value());
    const SensationFigures line = figuresOf("line");
    EXPECT_NEAR(line.low_mm.x(), -40.0, 0.01);
    EXPECT_NEAR(line.high_mm.y(), 0.0, 1e-9);
    EXPECT_EQ(line.draw_Hz, 125.0);
    const SensationFigures pulse = figuresOf("pulse");
    EXPECT_NEAR(pulse.duration_ms.value_or(0.0), 1000.0, 0.06);
    EXPECT_NEAR(pulse.high_mm.x(), 50.0, 0.6);
    EXPECT_NEAR(figuresOf("palm-scan").duration_ms.value_or(0.0), 2000.0, 0.06);
    EXPECT_NEAR(figuresOf("click").duration_ms.value_or(0.0), 100.0, 0.06);
    EXPECT_NEAR(figuresOf("dial").high_mm.x(), 30.0, 0.1);
    EXPECT_NEAR(figuresOf("heartbeat").high_mm.x(), 25.0, 0.5);
    // Point AM begins at nothing, 0.5 (1 - cos).
    SensationPlayer point = playerOf("point-am");
    EXPECT_NEAR(point.sampleAt(0.0).intensity, 0.0, 1e-12);
    EXPECT_NEAR(point.sampleAt(1e3 / 143.0 / 2.0).intensity, 1.0, 1e-9);
}

TEST(SensationClassics, TapAndLoop)
{
    SensationPlayer tapping = playerOf("tapping");
    for (int tap = 0; tap < 5; ++tap)
    {
        EXPECT_EQ(tapping.sampleAt(300.0 * tap + 100.0).intensity, 1.0);
        EXPECT_EQ(tapping.sampleAt(300.0 * tap + 250.0).intensity, 0.0);
    }
    EXPECT_FALSE(figuresOf("click?repeat=yes").duration_ms.has_value());
}

TEST(SensationClassics, TakeParametersWithUnits)
{
    EXPECT_NEAR(figuresOf("circle?radius=3cm").high_mm.x(), 30.0, 0.01);
    EXPECT_NEAR(figuresOf("circle?radius=30").high_mm.x(), 30.0, 0.01);
    EXPECT_EQ(figuresOf("circle?radius=30mm&frequency=0.1kHz").draw_Hz, 100.0);
    EXPECT_NEAR(figuresOf("pulse?duration=0.5s").duration_ms.value_or(0.0), 500.0, 0.06);
    EXPECT_NEAR(figuresOf("circle?intensity=50%").mostIntensity, 0.5, 1e-12);
    const SensationFigures lightning = figuresOf("lightning?tips=0 80 0 mm");
    EXPECT_NEAR(lightning.low_mm.y(), 0.0, 0.01);
    EXPECT_NEAR(lightning.high_mm.y(), 80.0, 0.01);
    EXPECT_NEAR(lightning.high_mm.x(), 0.0, 1e-9);
    // A program changes them while they play.
    SensationPlayer circle = playerOf("circle?frequency=0");
    EXPECT_TRUE(circle.values().set("radius", 12.0));
    EXPECT_NEAR(circle.sampleAt(0.0).position_mm.x(), 12.0, 1e-12);
}

TEST(SensationClassics, RefuseWhatTheyDoNotKnowWithTheNearestName)
{
    EXPECT_NE(classicErrorOf("hartbeat").find("did you mean heartbeat?"), std::string::npos);
    EXPECT_NE(classicErrorOf("circle?radios=1").find("did you mean radius?"), std::string::npos);
    EXPECT_EQ(classicErrorOf("circle?radius=20kg"),
              "radius of circle is \"20kg\"; it must be within 0 .. 200 mm");
    EXPECT_EQ(classicErrorOf("circle?radius=20Hz"),
              "radius of circle is \"20Hz\"; it must be within 0 .. 200 mm");
    EXPECT_EQ(classicErrorOf("circle?radius=1m"),
              "radius of circle is \"1m\"; it must be within 0 .. 200 mm");
    EXPECT_EQ(classicErrorOf("click?repeat=maybe"),
              "repeat of click is \"maybe\"; it must be yes or no");
    EXPECT_EQ(classicErrorOf("circle?radius"), "circle: \"radius\" should be name=value");
    EXPECT_EQ(classicErrorOf("circle?radius=1&radius=2"), "circle: radius is there twice");
    EXPECT_NE(classicErrorOf("lightning?tips=1 2").find("tips of lightning"), std::string::npos);
}
