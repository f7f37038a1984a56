// The kernels of reflectors against double precision, each within what its description promises.
#include "haptics/propagation/kernels/ReflectionKernels.h"

#include "haptics/propagation/Reflections.h"
#include "tests/haptics/propagation/kernels/KernelTesting.h"

using namespace midair::haptics;

namespace
{

constexpr int kSheetWidth = 480;

MIDAIR_ON_EVERY_SET(ReflectionKernels);

midair::base::AlignedBuffer<float> lanesBetween(Numbers& numbers, double low, double high)
{
    auto all = floats(kSheetWidth);
    for (int i = 0; i < kSheetWidth; ++i)
        all[static_cast<std::size_t>(i)] = static_cast<float>(numbers.between(low, high));
    return all;
}

} // namespace

TEST_P(ReflectionKernels, SharesTurned)
{
    Numbers numbers(4);
    auto shareRe = floats(kSheetWidth), shareIm = floats(kSheetWidth);
    double worst = 0.0;
    for (int k = 0; k < 40; ++k)
    {
        const auto height = lanesBetween(numbers, -25.0, 25.0),
                   along = lanesBetween(numbers, -30.0, 30.0),
                   across = lanesBetween(numbers, -30.0, 30.0);
        Reflector one;
        one.size_m = {static_cast<float>(numbers.between(1.0, 40.0)),
                      static_cast<float>(numbers.between(1.0, 40.0))};
        const kernels::SheetPoint point{static_cast<float>(numbers.between(-20.0, 20.0)),
                                        static_cast<float>(numbers.between(-20.0, 20.0)),
                                        static_cast<float>(numbers.between(-20.0, 20.0))};
        kernels::sharesTurned(kSheetWidth,
                              {{height.data(), along.data(), across.data()},
                               static_cast<float>(0.5 * one.size_m[0]),
                               static_cast<float>(0.5 * one.size_m[1])},
                              point,
                              shareRe.data(),
                              shareIm.data());
        for (std::size_t i = 0; i < kSheetWidth; ++i)
        {
            const Eigen::Vector3d from(along[i], across[i], height[i]);
            const Eigen::Vector3d to(point.along, point.across, point.height);
            // Edges are at most about 1 / (least height) away, in units of v.
            const double a = std::abs(from[2]), b = std::abs(to[2]), r = (from - to).norm();
            const double v = 60.0 * (a + b) * std::sqrt(2.0 / (a * b * r));
            if (v > kernels::kFarthestEdge) continue;
            const double error =
                std::abs(Complex(shareRe[i], shareIm[i]) - shareTurned(one, from, to, 1.0));
            ASSERT_LT(error, 1e-4 + 1e-6 * v) << k << ' ' << i;
            worst = std::max(worst, error);
        }
    }
    EXPECT_GT(worst, 1e-7);
}

TEST_P(ReflectionKernels, SharesAreFiniteInThePlane)
{
    auto height = floats(kSheetWidth), along = floats(kSheetWidth), across = floats(kSheetWidth);
    for (std::size_t i = 0; i < kSheetWidth; ++i)
        along[i] = 0.05F * static_cast<float>(i) - 10.0F; // beside it from 5 on, and at the point
    auto re = floats(kSheetWidth), im = floats(kSheetWidth);
    for (const float above : {0.0F, 10.0F})
    {
        kernels::sharesTurned(kSheetWidth,
                              {{height.data(), along.data(), across.data()}, 5.0F, 5.0F},
                              {above, 0.0F, 0.0F},
                              re.data(),
                              im.data());
        for (std::size_t i = 0; i < kSheetWidth; ++i)
        {
            ASSERT_TRUE(std::isfinite(re[i]) && std::isfinite(im[i])) << i;
            if (above == 0.0F || std::abs(std::abs(along[i]) - 5.0F) < 0.02F) continue;
            ASSERT_NEAR(re[i], std::abs(along[i]) < 5.0F ? 1.0 : 0.0, 4e-4) << along[i];
        }
    }
}

TEST_P(ReflectionKernels, Reflect)
{
    Numbers numbers(5);
    const Complex factor = std::polar(0.8, 0.7);
    const kernels::SheetFactor given{
        static_cast<float>(factor.real()), static_cast<float>(factor.imag()), 0.8F};
    const auto heights = lanesBetween(numbers, -1.0, 1.0);
    for (const bool isWhole : {true, false})
        for (const float height : {-2.0F, 2.0F})
        {
            const Split image = numbers.split(kSheetWidth), share = numbers.split(kSheetWidth);
            Split direct = numbers.split(kSheetWidth), reflected = numbers.split(kSheetWidth);
            const kernels::Waves row{heights.data(),
                                     image.re.data(),
                                     image.im.data(),
                                     direct.re.data(),
                                     direct.im.data(),
                                     reflected.re.data(),
                                     reflected.im.data()};
            if (isWhole)
                kernels::reflect(kSheetWidth, height, given, row);
            else
                kernels::reflect(kSheetWidth, height, given, share.re.data(), share.im.data(), row);
            for (int i = 0; i < kSheetWidth; ++i)
            {
                const auto k = static_cast<std::size_t>(i);
                const bool isBeside = (heights[k] >= 0.0F) == (height >= 0.0F);
                const Complex part = isWhole ? Complex(1.0) : share.exact[k];
                ASSERT_NEAR(
                    std::abs(direct.at(i) - direct.exact[k] * (isBeside ? 1.0 : 1.0 - 0.8 * part)),
                    0.0,
                    6e-7);
                ASSERT_NEAR(std::abs(reflected.at(i) - reflected.exact[k] -
                                     (isBeside ? factor * part * image.exact[k] : Complex(0.0))),
                            0.0,
                            6e-7);
            }
        }
}

TEST_P(ReflectionKernels, JoinWaves)
{
    Numbers numbers(6);
    Split p = numbers.split(kSheetWidth);
    const Split d = numbers.split(kSheetWidth);
    const float sum =
        kernels::joinWaves(kSheetWidth, d.re.data(), d.im.data(), p.re.data(), p.im.data());
    double exact = 0.0;
    for (int i = 0; i < kSheetWidth; ++i)
    {
        const auto k = static_cast<std::size_t>(i);
        ASSERT_NEAR(std::abs(p.at(i) - p.exact[k] - d.exact[k]), 0.0, 3e-7);
        exact += std::abs(p.exact[k] + d.exact[k]);
    }
    EXPECT_NEAR(sum, exact, 1e-5 * exact);
}
