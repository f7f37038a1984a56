#include "haptics/sequence/Modulator.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

TEST(Modulator, FieldsInTurnAtTheirRate)
{
    ModulatorOptions options;
    options.fieldRate_Hz = 1000.0;
    const Modulator modulator(options);
    for (int k = 0; k < 3000; ++k)
    {
        EXPECT_EQ(modulator.at(k / 1000.0, 8).field, k % 8) << k;
        EXPECT_EQ(modulator.at((k + 0.9) / 1000.0, 8).field, k % 8) << k;
    }
    EXPECT_EQ(modulator.at(-0.0005, 8).field, 7);
    EXPECT_EQ(modulator.at(12.3, 1).field, 0);
    EXPECT_EQ(modulator.at(12.3, 8).amplitude, 1.0);
}

TEST(Modulator, ThePressureOnTheSkinIsACosine)
{
    ModulatorOptions options;
    options.amplitudeRate_Hz = 200.0;
    options.amplitudeDepth = 0.6;
    const Modulator modulator(options);
    double mean = 0.0;
    for (int k = 0; k < 1000; ++k)
    {
        const double t = k / 200000.0;
        const double amplitude = modulator.at(t, 1).amplitude;
        EXPECT_NEAR(amplitude * amplitude, 0.7 + 0.3 * std::cos(2 * M_PI * 200.0 * t), 1e-12);
        mean += amplitude * amplitude / 1000.0;
    }
    EXPECT_NEAR(mean, 0.7, 1e-12);
    EXPECT_EQ(modulator.at(0.0, 1).amplitude, 1.0);
}

TEST(Modulator, SaysWhatIsWrong)
{
    ModulatorOptions options;
    std::string error;
    options.amplitudeRate_Hz = 501.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "amplitudeRate_Hz is 501; it must be within 0 .. 500");
    options = {};
    options.amplitudeDepth = -0.1;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "amplitudeDepth is -0.1; it must be within 0 .. 1");
    options = {};
    options.fieldRate_Hz = 0.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "fieldRate_Hz is 0; it must be within 0.01 .. 40000");
    EXPECT_THROW(Modulator{options}, base::InputError);
}

TEST(Modulator, SubsetsHoldEveryPointOnceAndKeepApart)
{
    const ControlPoints points = spherePoints(90, 0.03);
    const std::vector<ControlPoints> subsets = subsetsInTurn(points, 4);
    ASSERT_EQ(subsets.size(), 4u);
    std::set<std::pair<double, double>> seen;
    double nearest = 1.0;
    for (const ControlPoints& subset : subsets)
    {
        EXPECT_TRUE(subset.size() == 22 || subset.size() == 23);
        for (int k = 0; k < subset.size(); ++k)
        {
            seen.insert({subset.positions(0, k), subset.positions(1, k)});
            for (int l = 0; l < k; ++l)
                nearest =
                    std::min(nearest, (subset.positions.col(k) - subset.positions.col(l)).norm());
        }
    }
    EXPECT_EQ(seen.size(), 90u);
    // All 90 are about 10 mm apart; a quarter of them could stand twice as far.
    EXPECT_GT(nearest, 0.0099);
    EXPECT_EQ(subsetsInTurn(spherePoints(2, 0.03), 5).size(), 2u);
    EXPECT_EQ(subsetsInTurn(ControlPoints(), 5).front().size(), 0);
    EXPECT_THROW(subsetsInTurn(points, 0), base::InputError);
}

} // namespace
} // namespace midair::haptics
