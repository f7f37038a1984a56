#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

double level_dB(Directivity model, double angle_deg)
{
    return 20.0 * std::log10(directivity(model, std::cos(angle_deg * midair::base::kPi / 180.0)));
}

} // namespace

TEST(Directivity, EveryModelIsOneOnAxisAndNeverNegative)
{
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
    {
        EXPECT_NEAR(directivity(model, 1.0), 1.0, 1e-15);
        for (int k = -1000; k <= 1000; ++k)
        {
            const double D = directivity(model, k / 1000.0);
            EXPECT_GE(D, 0.0);
            EXPECT_LE(D, 1.06); // the harmonics rise by a little off the axis
        }
    }
}

TEST(Directivity, HarmonicsAreOrthonormalZonalOnes)
{
    // Against the standard library's Legendre polynomials, Y_n0 = sqrt((2n+1)/4pi) P_n.
    const double c[] = {1.11, 1.06, 0.24, -0.12};
    const auto sum = [&c](double x)
    {
        double total = 0.0;
        for (unsigned n = 0; n < 4; ++n)
            total +=
                c[n] * std::sqrt((2 * n + 1) / (4.0 * midair::base::kPi)) * std::legendre(n, x);
        return total;
    };
    for (int k = -100; k <= 100; ++k)
    {
        const double x = k / 100.0;
        EXPECT_NEAR(directivity(Directivity::T4010A1_HARMONICS, x),
                    std::max(0.0, sum(x) / sum(1.0)),
                    1e-14);
    }
    // What leaves behind the transducer nearly vanishes.
    EXPECT_NEAR(directivity(Directivity::T4010A1_HARMONICS, -1.0), 0.04, 0.005);
    EXPECT_EQ(directivity(Directivity::T4010A1_HARMONICS, std::cos(2.4)), 0.0);
}

TEST(Directivity, TableHoldsItsMeasuredLevels)
{
    const double measured_dB[] = {0, 0, 0, -1, -3, -6, -9, -12, -14, -15};
    for (int k = 0; k < 9; ++k)
    {
        EXPECT_NEAR(level_dB(Directivity::T4010A1_TABLE, 10.0 * k), measured_dB[k], 1e-9);
        EXPECT_NEAR(level_dB(Directivity::T4010A1_TABLE, 10.0 * k + 5.0),
                    0.5 * (measured_dB[k] + measured_dB[k + 1]),
                    1e-9);
    }
    EXPECT_NEAR(20.0 * std::log10(directivity(Directivity::T4010A1_TABLE, 0.0)), -15.0, 1e-9);
    EXPECT_EQ(directivity(Directivity::T4010A1_TABLE, -1e-9), 0.0);
    EXPECT_EQ(directivity(Directivity::T4010A1_TABLE, -1.0), 0.0);
    // Rounding may leave a cosine a little above 1.
    EXPECT_EQ(directivity(Directivity::T4010A1_TABLE, 1.0 + 1e-15), 1.0);
}

TEST(Directivity, PointIsTheSameAllRound)
{
    for (const double x : {-1.0, -0.3, 0.0, 0.7, 1.0})
        EXPECT_EQ(directivity(Directivity::POINT, x), 1.0);
}

TEST(Directivity, NamesGoBothWays)
{
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
        EXPECT_EQ(directivityFromName(directivityName(model)), model);
    EXPECT_STREQ(directivityName(Directivity::T4010A1_HARMONICS), "t4010a1-harmonics");
    try
    {
        directivityFromName("Point");
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(error.what(),
                     "unknown directivity 'Point'; known are t4010a1-harmonics, t4010a1-table, "
                     "point");
    }
}
