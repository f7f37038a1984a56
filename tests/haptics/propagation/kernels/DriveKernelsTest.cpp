// The kernels on drives against double precision, each within what its description promises.
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "tests/haptics/propagation/kernels/KernelTesting.h"

using namespace midair::haptics;

namespace
{

constexpr int kCount = 4096;

MIDAIR_ON_EVERY_SET(InverseRoots);
MIDAIR_ON_EVERY_SET(DriveKernels);

double turnsBetween(double a, double b)
{
    return std::fabs(std::remainder(a - b, 1.0));
}

} // namespace

TEST_P(InverseRoots, AreThoseOfDoublePrecision)
{
    constexpr int kCount = 100000 / kernels::kLanes * kernels::kLanes;
    auto x = floats(kCount), inverse = floats(kCount);
    for (const double least : {1e-30, 1e-3}) // squares of distances: 0.03 to 3,000 wavelengths
    {
        const double span = least < 1e-20 ? 1e60 : 1e10;
        for (int i = 0; i < kCount; ++i)
            x[i] = static_cast<float>(least * std::pow(span, static_cast<double>(i) / kCount));
        kernels::inverseRoots(kCount, x.data(), inverse.data());
        double worst = 0.0;
        for (int i = 0; i < kCount; ++i)
            worst = std::max(worst, std::fabs(double(inverse[i]) * std::sqrt(double(x[i])) - 1.0));
        EXPECT_LT(worst, 2e-7) << least;
        EXPECT_GT(worst, 0.0);
    }
}

TEST_P(DriveKernels, ProjectToUnit)
{
    Numbers numbers(1);
    Split z(kCount), q(kCount);
    auto inverse = floats(kCount);
    for (int i = 0; i < kCount; ++i)
        z.set(i, std::polar(std::pow(10.0, numbers.between(-17.9, 17.9)), numbers.between(-4, 4)));
    z.set(0, 0.0);
    z.set(1, {0.0, 1e-19});
    z.set(2, {0.0, -2.0});
    kernels::projectToUnit(
        kCount, z.re.data(), z.im.data(), q.re.data(), q.im.data(), inverse.data());
    for (int i = 0; i < 2; ++i)
    {
        EXPECT_EQ(q.at(i), Complex(1.0, 0.0));
        EXPECT_EQ(inverse[i], 0.0F);
    }
    for (int i = 2; i < kCount; ++i)
    {
        const double size = std::abs(z.exact[i]);
        ASSERT_NEAR(std::abs(q.at(i) - z.exact[i] / size), 0.0, 3e-7) << z.exact[i];
        ASSERT_NEAR(double(inverse[i]) * size, 1.0, 3e-7) << z.exact[i];
    }
}

TEST_P(DriveKernels, QuantisePhase)
{
    Numbers numbers(2);
    Split q(kCount), out(kCount);
    for (int i = 0; i < kCount; ++i)
        q.set(i, std::polar(std::pow(10.0, numbers.between(-29, 9)), numbers.between(-4, 4)));
    q.set(0, 0.0);
    q.set(1, -1.0);
    q.set(2, {0.0, -1.0});
    for (const int levels : {0, 2, 16, 256})
    {
        kernels::quantisePhase(
            kCount, levels, q.re.data(), q.im.data(), out.re.data(), out.im.data());
        for (int i = 0; i < kCount; ++i)
        {
            double turns = std::arg(q.exact[i]) / (2 * M_PI);
            if (levels > 0)
            {
                // Half-way between two levels it may be either.
                const double found = std::arg(out.at(i)) / (2 * M_PI);
                ASSERT_LE(turnsBetween(found, turns), 0.5 / levels + 1e-6) << q.exact[i];
                turns = std::round(found * levels) / levels;
            }
            ASSERT_NEAR(std::abs(out.at(i) - std::polar(1.0, 2 * M_PI * turns)), 0.0, 8e-7)
                << q.exact[i] << ' ' << levels;
        }
    }
}

TEST_P(DriveKernels, CompareDrivesAndInnerProduct)
{
    Numbers numbers(3);
    const Split before = numbers.split(kCount);
    // Drives that have little in common, and drives that have nearly everything.
    for (const double step : {3.0, 1e-2})
    {
        Split q(kCount);
        double phases = 0.0, change = 0.0, power = 0.0, sizes = 0.0;
        Complex product = 0.0;
        for (int i = 0; i < kCount; ++i)
        {
            q.set(i, before.exact[i] * std::polar(1.0, numbers.between(-step, step)));
            phases += std::fabs(std::arg(q.exact[i] * std::conj(before.exact[i])));
            change += std::norm(q.exact[i] - before.exact[i]);
            power += std::norm(q.exact[i]);
            product += before.exact[i] * std::conj(q.exact[i]);
            sizes += std::abs(before.exact[i] * q.exact[i]);
        }
        const auto found = kernels::compareDrives(
            kCount, q.re.data(), q.im.data(), before.re.data(), before.im.data());
        EXPECT_NEAR(found.phaseSteps, phases, 1e-5 * phases + 2e-7 * kCount);
        EXPECT_NEAR(found.change, change, 1e-5 * change + 1e-7 * std::sqrt(change * power));
        EXPECT_NEAR(found.power, power, 1e-5 * power);
        const auto inner = kernels::innerProduct(
            kCount, q.re.data(), q.im.data(), before.re.data(), before.im.data());
        EXPECT_NEAR(std::abs(Complex(inner.re, inner.im) - product), 0.0, 1e-5 * sizes);
    }
}

TEST_P(DriveKernels, TurnByDistance)
{
    Numbers numbers(5);
    constexpr int kOdd = kCount - 3;
    Split g = numbers.split(kCount);
    auto x = floats(kCount), y = floats(kCount), z = floats(kCount);
    for (int i = 0; i < kOdd; ++i)
    {
        x[i] = static_cast<float>(numbers.between(-0.5, 0.5));
        y[i] = static_cast<float>(numbers.between(-0.5, 0.5));
        z[i] = static_cast<float>(numbers.between(-0.5, 0.5));
    }
    const kernels::HeardFrom from{x.data(), y.data(), z.data(), {0.1F, 0.5F, -0.2F}, 0.3F};
    kernels::turnByDistance(kOdd, from, 0.22F, -0.01F, g.re.data(), g.im.data());
    for (int i = 0; i < kOdd; ++i)
    {
        const double R =
            std::max(0.3, std::hypot(double(x[i]) - 0.1, double(y[i]) - 0.5, double(z[i]) + 0.2));
        const Complex exact = g.exact[i] * std::exp(Complex(0.01 * R, -0.22 * R));
        ASSERT_NEAR(std::abs(g.at(i) - exact), 0.0, 2e-6 * std::abs(exact));
    }
    for (int i = kOdd; i < kCount; ++i)
        ASSERT_EQ(g.at(i), Complex(std::complex<float>(g.exact[i]))); // not its own
}

TEST_P(DriveKernels, ScaleBy)
{
    Numbers numbers(4);
    const Complex by(-0.3, 0.8);
    Split all = numbers.split(kCount), each = numbers.split(kCount);
    auto factor = floats(kCount);
    for (int i = 0; i < kCount; ++i)
        factor[i] = static_cast<float>(numbers.between(-2.0, 2.0));
    kernels::scaleBy(kCount, -0.3F, 0.8F, all.re.data(), all.im.data());
    kernels::scaleBy(kCount, factor.data(), each.re.data(), each.im.data());
    for (int i = 0; i < kCount; ++i)
    {
        ASSERT_NEAR(std::abs(all.at(i) - all.exact[i] * by), 0.0, 2e-7 * std::abs(all.exact[i]));
        const Complex exact = each.exact[i] * double(factor[i]);
        ASSERT_NEAR(std::abs(each.at(i) - exact), 0.0, 2e-7 * std::abs(exact));
    }
}
