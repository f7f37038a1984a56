// What a thermometer's readings make of the temperature that fields are solved for.
#include "engine-bridge/air/AirTemperature.h"

#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

TemperatureSource::News reading(double temperature_C)
{
    TemperatureSource::News news;
    news.temperature_C = temperature_C;
    return news;
}

TemperatureSource::News bad(const std::string& problem)
{
    TemperatureSource::News news;
    news.bad = 1;
    news.problem = problem;
    return news;
}

/// A temperature, and what it has told since the last told().
struct ToldAir
{
    base::MessageLog log;
    AirTemperature air{log};
    std::uint64_t before = 0;

    std::string told()
    {
        std::string all;
        const std::uint64_t last = before;
        for (const base::Message& message : log.messages())
        {
            EXPECT_EQ(message.code, base::MessageCode::AIR_TEMPERATURE);
            if (message.said > last) all += message.text + "\n";
            before = std::max(before, message.said);
        }
        return all;
    }
};

constexpr double kSet_C = 20.0;

} // namespace

TEST(AirTemperature, WithoutASourceItIsTheOneThatIsSet)
{
    ToldAir of;
    AirTemperature& air = of.air;
    EXPECT_EQ(air.at(0.0, 20.0), 20.0);
    EXPECT_EQ(air.at(0.1, 31.5), 31.5);
}

// 3 K are 30 steps of 0.1 K, five a second, and no step in between is larger.
TEST(AirTemperature, FollowsInSmallSteps)
{
    ToldAir of;
    AirTemperature& air = of.air;
    double before_C = air.follow({}, 0.0, kSet_C);
    EXPECT_EQ(before_C, kSet_C);
    double arrived_s = 0.0;
    int steps = 0;
    for (int frame = 1; frame < 2000; ++frame)
    {
        const double now_s = frame / 100.0;
        const double now_C = air.follow(reading(23.0), now_s, kSet_C);
        EXPECT_LE(std::fabs(now_C - before_C), AirTemperature::kStep_K + 1e-9);
        steps += now_C != before_C;
        if (now_C != before_C) arrived_s = now_s;
        before_C = now_C;
    }
    EXPECT_NEAR(before_C, 23.0, AirTemperature::kLeast_K);
    EXPECT_EQ(steps, 30);
    EXPECT_NEAR(arrived_s, 29 * AirTemperature::kPause_s, 0.4);
}

// Noise of a thermometer is not followed, or fields would be made anew all the time.
TEST(AirTemperature, NoiseIsNotFollowed)
{
    ToldAir of;
    AirTemperature& air = of.air;
    double now_C = 0.0;
    for (int k = 0; k < 100; ++k)
        now_C = air.follow(reading(20.0 + (k % 2 == 0 ? 0.04 : -0.04)), 0.25 * k, kSet_C);
    EXPECT_EQ(now_C, kSet_C);
}

TEST(AirTemperature, OneWrongReadingDoesNothing)
{
    ToldAir of;
    AirTemperature& air = of.air;
    double time_s = 0.0;
    for (int k = 0; k < 20; ++k)
        air.follow(reading(20.0), time_s += 0.25, kSet_C);
    EXPECT_EQ(air.follow(reading(55.0), time_s += 0.25, kSet_C), kSet_C);
    EXPECT_EQ(air.follow(reading(20.0), time_s += 0.25, kSet_C), kSet_C);
}

TEST(AirTemperature, BadReadingsAreToldOnceAndTheLastGoodOneStays)
{
    ToldAir of;
    AirTemperature& air = of.air;
    air.follow(bad("\"nan\" is no reading"), 0.0, kSet_C);
    EXPECT_EQ(of.told(),
              "temperature source \"\": \"nan\" is no reading; until then the setting temperature "
              "is used\n");
    for (int k = 1; k < 40; ++k)
        air.follow(reading(21.0), 0.25 * k, kSet_C);
    EXPECT_NEAR(air.follow(bad("\"999\" is no reading"), 10.0, kSet_C), 21.0, 0.05);
    EXPECT_EQ(of.told(), "") << "not twice within a minute";
    air.follow(reading(21.0), 71.0, kSet_C);
    EXPECT_EQ(of.told(), "");
    EXPECT_NEAR(air.follow(bad("\"999\" is no reading"), 72.0, kSet_C), 21.0, 0.05);
    EXPECT_EQ(of.told(),
              "temperature source \"\": \"999\" is no reading; the last good reading, 21.0 C, is "
              "kept\n");
}

// Neither silence nor a jump back to what is set: rooms change slowly.
TEST(AirTemperature, AStaleSourceIsToldOnceAndItsLastReadingStays)
{
    ToldAir of;
    AirTemperature& air = of.air;
    for (int k = 0; k < 40; ++k)
        air.follow(reading(22.0), 0.25 * k, kSet_C);
    EXPECT_NEAR(air.follow({}, 60.0, kSet_C), 22.0, 0.05);
    EXPECT_EQ(of.told(), "");
    for (int k = 0; k < 10; ++k)
        EXPECT_NEAR(air.follow({}, 71.0 + k, kSet_C), 22.0, 0.05);
    EXPECT_EQ(
        of.told(),
        "temperature source \"\": no good reading for 60 s; the last good reading, 22.0 C, is "
        "kept\n");
    air.follow(reading(22.0), 90.0, kSet_C);
    air.follow({}, 200.0, kSet_C);
    EXPECT_NE(of.told(), "") << "a new loss is told anew";
}

TEST(AirTemperature, LinesThatAreReadings)
{
    std::string problem;
    EXPECT_EQ(temperatureOf("21.5", problem), 21.5);
    EXPECT_EQ(temperatureOf(" -3 C\r", problem), -3.0);
    EXPECT_EQ(problem, "");
    for (const char* line : {"nan", "inf", "61", "-40.1", "21,5", "warm", "21.5 V", "1e99", ""})
    {
        problem.clear();
        EXPECT_EQ(temperatureOf(line, problem), std::nullopt) << line;
        EXPECT_EQ(problem,
                  std::string("\"") + line +
                      "\" is not a reading, should be a number from -40 to 60 C");
    }
    temperatureOf("\x1b[31m" + std::string(100, 'x'), problem);
    EXPECT_EQ(problem.find('\x1b'), std::string::npos);
    EXPECT_LT(problem.size(), 120U);
}

// "The matrix follows without a jump": a step of 0.1 K changes hardly anything of a drive that is
// solved on from the last one. A field from nothing is another one.
TEST(AirTemperature, AStepGoesOnFromTheLastField)
{
    using namespace midair::haptics;
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = spherePoints(40, 0.03);
    const auto solver = makeSolver(solverNames().front());
    Medium air;
    Eigen::VectorXcf q;
    for (int k = 0; k < 3; ++k)
        solver->solve(points, array, air, q);
    for (int k = 0; k < 10; ++k)
    {
        air.temperature_C += AirTemperature::kStep_K;
        const SolveReport report = solver->solve(points, array, air, q);
        EXPECT_LT(report.rms, 1e-3);
        EXPECT_LT(report.driveChange, 1e-2) << k;
        EXPECT_LT(report.levelJump, 1.01);
    }
}
