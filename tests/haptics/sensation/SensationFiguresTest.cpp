#include "haptics/sensation/SensationFigures.h"

#include "tests/haptics/sensation/Patterns.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;
using namespace patterns;

TEST(SensationFigures, MeasureExtentSpeedAndTurns)
{
    // A point at 0.1 m/s, silent from 200 ms on.
    Json json = pattern({standard(0.0, coords(0, 0, 1)),
                         standard(200.0, coords(20, 0, 1)),
                         standard(300.0, coords(90, 0, 1)),
                         stop(400.0)});
    json["keyframes"][0]["intensity"] = intensity(number(0.5), "step");
    json["keyframes"][1]["intensity"] = intensity(number(0.0));
    SensationPlayer player(read(json));
    const SensationFigures figures = measureSensation(player);
    EXPECT_EQ(figures.low_mm, Eigen::Vector3d(0, 0, 1));
    EXPECT_NEAR(figures.high_mm.x(), 20.0, 0.011);
    EXPECT_NEAR(figures.speed_m_s, 0.1, 1e-6);
    EXPECT_NEAR(figures.duration_ms.value_or(0.0), 400.0, 1e-6);
    EXPECT_EQ(figures.mostIntensity, 0.5);
    EXPECT_TRUE(std::isinf(figures.pointsPerTurn(1000.0)));
}

TEST(SensationFigures, CountPointsOfATurn)
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["brush"] = circle(number(10.0), number(50.0), number(20.0));
    json["keyframes"][0]["intensity"] = intensity(number(2.0));
    SensationPlayer player(read(json));
    const SensationFigures figures = measureSensation(player, 200.0);
    EXPECT_EQ(figures.pointsPerTurn(1000.0), 20.0);
    EXPECT_EQ(figures.modulation_Hz, 20.0);
    EXPECT_FALSE(figures.duration_ms.has_value());
    EXPECT_TRUE(figures.isLimited);
}

TEST(SensationFigures, OfASilentPatternHaveNoExtent)
{
    SensationPlayer player(read(pattern({standard(0.0, coords(5, 0, 0))})));
    EXPECT_TRUE(std::isnan(measureSensation(player, 50.0).low_mm.x()));
}
