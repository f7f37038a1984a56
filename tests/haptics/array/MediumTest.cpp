#include "haptics/array/Medium.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using midair::haptics::Medium;

namespace
{

struct PublishedAttenuation
{
    double temperature_C;
    double relativeHumidity;
    double frequency_Hz; // exact midband
    double dB_per_km;
};

// ISO 9613-2:1996, table 2 (computed there with ISO 9613-1), rounded to two or three figures.
const PublishedAttenuation kPublished[] = {{10.0, 0.7, 251.19, 1.0},
                                           {10.0, 0.7, 501.19, 1.9},
                                           {10.0, 0.7, 1000.0, 3.7},
                                           {10.0, 0.7, 1995.26, 9.7},
                                           {10.0, 0.7, 3981.07, 32.8},
                                           {10.0, 0.7, 7943.28, 117.0},
                                           {20.0, 0.7, 1000.0, 5.0},
                                           {20.0, 0.7, 1995.26, 9.0},
                                           {20.0, 0.7, 3981.07, 22.9},
                                           {20.0, 0.7, 7943.28, 76.6},
                                           {30.0, 0.7, 3981.07, 23.1},
                                           {30.0, 0.7, 7943.28, 59.3},
                                           {15.0, 0.2, 3981.07, 88.8},
                                           {15.0, 0.2, 7943.28, 202.0},
                                           {15.0, 0.5, 7943.28, 129.0},
                                           {15.0, 0.8, 7943.28, 82.8}};

} // namespace

TEST(Medium, AttenuationMatchesPublishedTable)
{
    for (const PublishedAttenuation& row : kPublished)
    {
        const Medium medium{row.temperature_C, row.relativeHumidity, 101325.0};
        const double dB_per_km =
            medium.attenuation(row.frequency_Hz) * 20.0 / std::log(10.0) * 1000.0;
        // Half a unit of the last printed digit, and one percent for the printed values' own
        // rounding.
        EXPECT_NEAR(dB_per_km, row.dB_per_km, 0.05 + 0.01 * row.dB_per_km)
            << row.temperature_C << " C, " << row.relativeHumidity << ", " << row.frequency_Hz;
    }
}

TEST(Medium, AttenuationAtFortyKilohertz)
{
    // 1.3 dB/m at 20 C and 50 %.
    EXPECT_NEAR(Medium().attenuation(40e3), 0.15, 0.005);
}

TEST(Medium, AttenuationIsClassicalFarAboveTheRelaxations)
{
    // At 100 MHz both relaxations are spent: what is left is f^2 1.84e-11 sqrt(T/T0) p_r/p_a,
    // within their 1 %.
    const Medium medium{20.0, 0.5, 90e3};
    const double f = 1e8;
    EXPECT_NEAR(medium.attenuation(f) / (f * f * 1.84e-11 * 101325.0 / 90e3), 1.0, 0.01);
}

TEST(Medium, SoundSpeedAndWavelength)
{
    Medium medium;
    EXPECT_NEAR(medium.soundSpeed(), 343.21, 0.01); // 331.3 sqrt(293.15/273.15)
    EXPECT_NEAR(medium.wavelength(40e3), 8.58e-3, 5e-6);
    medium.temperature_C = 14.5; // the paper's 8.5 mm
    EXPECT_NEAR(medium.wavelength(40e3), 8.50e-3, 5e-6);
}

TEST(Medium, DensityFollowsTheGasLaw)
{
    EXPECT_NEAR((Medium{15.0, 0.0, 101325.0}).density(), 1.225, 5e-4); // standard atmosphere
    EXPECT_NEAR((Medium{20.0, 0.5, 101325.0}).density(), 1.204, 5e-4);
    EXPECT_NEAR((Medium{20.0, 0.5, 2 * 50662.5}).density() / (Medium{20.0, 0.5, 50662.5}).density(),
                2.0,
                1e-12);
}

TEST(Medium, EverywhereInItsRangeAllIsFinite)
{
    for (const double temperature : {-40.0, 0.0, 60.0})
        for (const double humidity : {0.0, 0.5, 1.0})
            for (const double pressure : {50e3, 120e3})
            {
                const Medium medium{temperature, humidity, pressure};
                EXPECT_TRUE(medium.isValid());
                EXPECT_GT(medium.attenuation(40e3), 0.0);
                EXPECT_LT(medium.attenuation(40e3), 1.0);
            }
}

TEST(Medium, InvalidValuesAreNamed)
{
    std::string error;
    EXPECT_TRUE(Medium().isValid(&error));
    EXPECT_EQ(error, "");
    EXPECT_FALSE((Medium{61.0, 0.5, 101325.0}).isValid(&error));
    EXPECT_EQ(error, "temperature_C is 61; it must be within -40 .. 60");
    EXPECT_FALSE((Medium{20.0, 50.0, 101325.0}).isValid(&error));
    EXPECT_EQ(error, "relativeHumidity is 50; it must be within 0 .. 1");
    EXPECT_FALSE((Medium{20.0, 0.5, 1013.25}).isValid(&error));
    EXPECT_EQ(error, "pressure_Pa is 1013.25; it must be within 50000 .. 120000");
    EXPECT_FALSE((Medium{std::numeric_limits<double>::quiet_NaN(), 0.5, 101325.0}).isValid(&error));
    EXPECT_EQ(error, "temperature_C is nan; it must be within -40 .. 60");
    EXPECT_FALSE((Medium{20.0, 0.5, std::numeric_limits<double>::infinity()}).isValid());
}
