// The kernels of shaped rounding against double precision, each within what its description
// promises.
#include "haptics/propagation/kernels/ShapingKernels.h"

#include "tests/haptics/propagation/kernels/KernelTesting.h"

#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

constexpr int kGroup = kernels::kShapingGroup;

MIDAIR_ON_EVERY_SET(ShapingKernels);

int strideOf(int n)
{
    return (n + kernels::kShapingLanes - 1) / kernels::kShapingLanes * kernels::kShapingLanes;
}

} // namespace

TEST_P(ShapingKernels, ColumnsOfTheJacobian)
{
    constexpr double kPeak = 32760.0;
    Numbers numbers(11);
    for (const auto& [n, width, first] : {std::tuple{1, 32, 0}, {16, 64, 32}, {53, 512, 384}})
    {
        midair::base::AlignedBuffer<std::int32_t> G;
        G.reserve(std::size_t(n) * std::size_t(width));
        std::vector<Complex> g(std::size_t(n) * std::size_t(width));
        for (std::size_t k = 0; k < g.size(); ++k)
        {
            const Complex entry = kPeak * numbers.inUnitDisc();
            g[k] = {std::round(entry.real()), std::round(entry.imag())};
            G[k] = static_cast<std::int32_t>(g[k].imag() * 65536.0 + g[k].real());
        }
        const int count = width - first, stride = strideOf(n);
        const Split c = numbers.split(n), q = numbers.split(count);
        auto J = floats(count * stride), square = floats(count);
        kernels::jacobianColumns(G.data() + first,
                                 n,
                                 width,
                                 count,
                                 c.re.data(),
                                 c.im.data(),
                                 q.re.data(),
                                 q.im.data(),
                                 stride,
                                 J.data(),
                                 square.data());
        for (int i = 0; i < count; ++i)
        {
            double sum = 0.0;
            for (int l = 0; l < stride; ++l)
            {
                // The low half is read exactly, the high one to half a unit of 65,536.
                const Complex exact = l < n ? 65536.0 * c.exact[std::size_t(l)] *
                                                  g[std::size_t(l * width + first + i)] *
                                                  q.exact[std::size_t(i)]
                                            : 0.0;
                const double bound = l < n ? 0.6 * 65536.0 + 2e-6 * std::abs(exact) : 0.0;
                ASSERT_NEAR(J[i * stride + l], -exact.imag(), bound) << n << ' ' << l << ' ' << i;
                sum += double(J[i * stride + l]) * J[i * stride + l];
            }
            ASSERT_NEAR(square[i], sum, 1e-5 * sum);
        }
    }
}

TEST_P(ShapingKernels, EachGroupTakesTheBestLevels)
{
    constexpr float kStep = 0.0245F;
    Numbers numbers(12);
    for (const auto& [n, count] : {std::pair{3, 32}, {25, 1024}, {100, 512}})
    {
        const int stride = strideOf(n), each = count / kGroup;
        auto J = floats(count * stride), square = floats(count), wanted = floats(count),
             level = floats(count), e = floats(stride);
        std::vector<double> exact(static_cast<std::size_t>(stride), 0.0);
        for (int i = 0; i < count; ++i)
        {
            double sum = 0.0;
            for (int l = 0; l < stride; ++l)
            {
                const double x = l < n ? numbers.between(-0.01, 0.01) : 0.0;
                J[i * stride + l] = static_cast<float>(x);
                sum += x * x;
            }
            square[i] = static_cast<float>(sum);
            wanted[i] = level[i] = static_cast<float>(numbers.between(-128.0, 128.0));
        }
        square[5] = 0.0F; // one without any effect stays where it is nearest
        for (int l = 0; l < stride; ++l)
        {
            e[l] = l < n ? static_cast<float>(numbers.between(-1e-3, 1e-3)) : 0.0F;
            exact[std::size_t(l)] = e[l];
        }
        kernels::shapeLevels(count,
                             stride,
                             J.data(),
                             square.data(),
                             kStep,
                             1.0F,
                             wanted.data(),
                             level.data(),
                             e.data());
        for (int j = 0; j < each; ++j)
        {
            const std::vector<double> before = exact;
            for (int k = 0; k < kGroup; ++k)
            {
                const int i = k * each + j;
                ASSERT_EQ(level[i], std::round(level[i]));
                ASSERT_LE(std::fabs(level[i] - wanted[i]), 1.5F);
                double product = 0.0;
                for (int l = 0; l < n; ++l)
                    product += before[std::size_t(l)] * J[i * stride + l];
                if (square[i] > 0.0F)
                {
                    const double best = wanted[i] - product / (double(square[i]) * kStep);
                    const double allowed = std::clamp(best, wanted[i] - 1.0, wanted[i] + 1.0);
                    ASSERT_NEAR(level[i], allowed, 0.5 + 1e-2) << n << ' ' << i;
                }
                const double turn = (double(level[i]) - wanted[i]) * kStep;
                for (int l = 0; l < n; ++l)
                    exact[std::size_t(l)] += turn * J[i * stride + l];
            }
        }
        for (int l = 0; l < stride; ++l)
            ASSERT_NEAR(e[l], exact[std::size_t(l)], 1e-5 * 0.02) << n << ' ' << l;
    }
}

TEST_P(ShapingKernels, CoarseLevelsAreTriedOneByOne)
{
    constexpr int kCount = 40, kN = 9, kReach = 2;
    const int stride = strideOf(kN);
    Numbers numbers(13);
    for (const int levels : {2, 5, 32})
    {
        Split g = numbers.split(kCount * stride), q(kCount), p(stride);
        auto amplitude = floats(kCount), wanted = floats(kCount), level = floats(kCount);
        auto aim = floats(stride);
        for (int k = 0; k < kCount * stride; ++k)
            g.set(k, k % stride < kN ? 0.05 * g.exact[std::size_t(k)] : 0.0);
        for (int l = 0; l < stride; ++l)
            p.set(l, l < kN ? numbers.onUnitCircle() : 1.0);
        for (int i = 0; i < kCount; ++i)
        {
            amplitude[i] = i % 7 == 0 ? 0.0F : static_cast<float>(numbers.between(0.3, 1.0));
            wanted[i] = static_cast<float>(numbers.between(-0.5, 0.5) * levels);
            q.set(i, std::polar(double(amplitude[i]), 2.0 * M_PI * double(wanted[i]) / levels));
        }
        for (int l = 0; l < stride; ++l)
            aim[l] = l < kN ? static_cast<float>(numbers.between(0.1, 1.0)) : 1.0F;
        std::vector<Complex> now = p.exact;
        kernels::shapeCoarseLevels(kCount,
                                   stride,
                                   g.re.data(),
                                   g.im.data(),
                                   static_cast<float>(levels),
                                   kReach,
                                   amplitude.data(),
                                   wanted.data(),
                                   level.data(),
                                   q.re.data(),
                                   q.im.data(),
                                   aim.data(),
                                   p.re.data(),
                                   p.im.data());
        for (int i = 0; i < kCount; ++i)
        {
            const auto missed = [&, i = i](double tried)
            {
                const Complex d = std::polar(double(amplitude[i]), 2.0 * M_PI * tried / levels) -
                                  q.exact[std::size_t(i)];
                double sum = 0.0;
                for (int l = 0; l < stride; ++l)
                    sum += std::pow(
                        std::abs(now[std::size_t(l)] + g.exact[std::size_t(i * stride + l)] * d) -
                            double(aim[l]),
                        2);
                return sum;
            };
            double least = 1e30;
            for (int k = -kReach; k <= kReach; ++k)
                least = std::min(least, missed(std::round(double(wanted[i])) + k));
            ASSERT_NEAR(missed(level[i]), least, 1e-5) << levels << ' ' << i;
            const Complex played =
                std::polar(double(amplitude[i]), 2.0 * M_PI * double(level[i]) / levels);
            ASSERT_NEAR(std::abs(q.at(i) - played), 0.0, 2e-6);
            for (int l = 0; l < stride; ++l)
                now[std::size_t(l)] +=
                    g.exact[std::size_t(i * stride + l)] * (played - q.exact[std::size_t(i)]);
        }
        for (int l = 0; l < stride; ++l)
            ASSERT_NEAR(std::abs(p.at(l) - now[std::size_t(l)]), 0.0, 1e-5);
    }
}

TEST_P(ShapingKernels, PhasesInLevelsAndBack)
{
    constexpr int kWidth = 512;
    Numbers numbers(14);
    Split q(kWidth), back(kWidth);
    auto phase = floats(kWidth);
    for (const int levels : {2, 10, 256, 65536})
    {
        for (int i = 0; i < kWidth; ++i)
            q.set(i, numbers.between(0.01, 1.0) * numbers.onUnitCircle());
        kernels::phaseInLevels(
            kWidth, static_cast<float>(levels), q.re.data(), q.im.data(), phase.data());
        for (int i = 0; i < kWidth; ++i)
        {
            const double exact = std::arg(q.exact[std::size_t(i)]) / (2.0 * M_PI) * levels;
            ASSERT_NEAR(phase[i], exact, 2e-7 * levels);
            phase[i] = std::round(phase[i]) * (i % 3 == 0 ? -1.0F : 1.0F);
        }
        kernels::unitAtLevel(
            kWidth, static_cast<float>(levels), phase.data(), back.re.data(), back.im.data());
        for (int i = 0; i < kWidth; ++i)
            ASSERT_NEAR(
                std::abs(back.at(i) - std::polar(1.0, 2.0 * M_PI * phase[i] / levels)), 0.0, 8e-7);
    }
}
