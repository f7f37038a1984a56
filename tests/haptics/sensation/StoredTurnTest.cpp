// Fields that a device stores for a turn, against all that there are.
#include "haptics/sensation/StoredTurn.h"

#include "haptics/sensation/SensationReader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

const TurnStore kUltraino = {57.3, 32, 40e3};
const TurnStore kSonicSurface = {88.6, 2, 0.0, TurnStore::kLeastOnOff};
const TurnStore kUnit = {450.0, 1024, 40e3};

/// The smallest error of any number of fields, ticks and turns.
double leastError(const TurnStore& store, double frequency_Hz, int least)
{
    double error = std::numeric_limits<double>::infinity();
    for (int fields = least; fields <= store.fields; ++fields)
        for (int ticks = 1; ticks <= 255; ++ticks)
            for (int turns = 1; turns * least <= fields; ++turns)
                error = std::min(
                    error,
                    std::abs(turns * store.clock_Hz / (fields * ticks) / frequency_Hz - 1.0));
    return error;
}

SensationPlayer playing(const std::string& name)
{
    return SensationPlayer(std::make_shared<const Sensation>(loadSensation(name)));
}

bool isSteady(const std::string& name, double time_ms)
{
    SensationPlayer player = playing(name);
    player.sampleAt(time_ms);
    return player.steady().has_value();
}

} // namespace

TEST(StoredTurn, IsOfTheNearestFrequencyThatTheClockHas)
{
    for (double frequency_Hz = 8.0; frequency_Hz <= 500.0; frequency_Hz += 6.7)
    {
        const auto turn = storedTurn(kUltraino, frequency_Hz, 0.0);
        ASSERT_TRUE(turn) << frequency_Hz;
        EXPECT_LE(turn->fields, 32);
        EXPECT_GE(turn->fields, 8 * turn->turns);
        EXPECT_EQ(turn->periods, 0);
        const double periods = 40e3 / turn->rate_Hz;
        EXPECT_NEAR(periods, std::round(periods), 1e-9);
        EXPECT_LE(periods, 255.0);
        EXPECT_NEAR(std::abs(turn->draw_Hz() / frequency_Hz - 1.0),
                    leastError(kUltraino, frequency_Hz, 8),
                    1e-5)
            << frequency_Hz;
    }
}

TEST(StoredTurn, OfABoardWithPatternsIsATurnOrAModulation)
{
    const auto circle = storedTurn(kUltraino, 70.0, 0.0);
    ASSERT_TRUE(circle);
    EXPECT_EQ(circle->fields, 11); // of 52 periods of the ultrasound
    EXPECT_NEAR(circle->draw_Hz(), 40e3 / 572, 1e-9);
    const auto modulation = storedTurn(kUltraino, 0.0, 200.0);
    ASSERT_TRUE(modulation);
    EXPECT_EQ(modulation->fields, 4);
    EXPECT_NEAR(modulation->modulation_Hz(), 200.0, 1e-9);
    const auto both = storedTurn(kUltraino, 70.0, 140.0);
    ASSERT_TRUE(both);
    EXPECT_EQ(both->periods, 2 * both->turns);
    const auto apart = storedTurn(kUltraino, 70.0, 143.0);
    ASSERT_TRUE(apart);
    EXPECT_EQ(apart->turns, 0) << "its outline, as 70 : 143 needs hundreds of fields";
    EXPECT_NEAR(apart->modulation_Hz(), 143.0, 0.15);
    EXPECT_EQ(apart->carried().draw_Hz, 0.0);
    EXPECT_EQ(apart->carried().modulation_Hz, std::numeric_limits<double>::infinity());
}

TEST(StoredTurn, OfTwoFieldsIsAModulation)
{
    EXPECT_FALSE(storedTurn(kSonicSurface, 70.0, 0.0));
    for (const double draw_Hz : {0.0, 70.0})
    {
        const auto turn = storedTurn(kSonicSurface, draw_Hz, 143.0);
        ASSERT_TRUE(turn);
        EXPECT_EQ(turn->fields, 2);
        EXPECT_EQ(turn->turns, 0);
        EXPECT_NEAR(turn->modulation_Hz(), 143.0, 1e-9);
    }
    EXPECT_FALSE(storedTurn(kSonicSurface, 5.0, 143.0)) << "its line draws the brush";
}

TEST(StoredTurn, OfManyFieldsIsExact)
{
    const auto circle = storedTurn(kUnit, 70.0, 0.0);
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->draw_Hz(), 70.0, 1e-5 * 70.0);
    const auto both = storedTurn(kUnit, 70.0, 143.0);
    ASSERT_TRUE(both);
    EXPECT_LE(both->fields, kMostStored);
    EXPECT_NEAR(both->draw_Hz(), 70.0, 1e-3 * 70.0);
    EXPECT_NEAR(both->modulation_Hz(), 143.0, 1e-3 * 143.0);
}

TEST(StoredTurn, IsNoneForWhatTheLineCarries)
{
    EXPECT_FALSE(storedTurn(kUnit, 56.0, 100.0));
    EXPECT_TRUE(storedTurn(kUnit, 57.0, 100.0));
    EXPECT_FALSE(storedTurn({}, 200.0, 200.0)) << "any rate";
    EXPECT_FALSE(storedTurn({57.0, 0, 0.0}, 200.0, 200.0)) << "nothing is stored";
}

TEST(StoredTurn, IsOfWhatStaysAsItIs)
{
    EXPECT_TRUE(isSteady("circle?radius=20mm", 1.0));
    EXPECT_TRUE(isSteady("line", 1.0));
    EXPECT_TRUE(isSteady("lissajous", 1.0));
    EXPECT_TRUE(isSteady("point-am", 1.0));
    for (const char* name : {"pulse", "tapping", "heartbeat", "rain", "click", "dial", "palm-scan"})
        EXPECT_FALSE(isSteady(name, 5.0)) << name;
    EXPECT_FALSE(isSteady("pulse", 1e5)) << "it has stopped";

    SensationPlayer player = playing("point-am?radius=4mm");
    player.sampleAt(10.0);
    player.values().set("radius", 9.0);
    EXPECT_EQ(player.steady()->brush.x_mm, 9.0);
    EXPECT_EQ(player.steady()->intensity, 1.0) << "without its modulation";
}
