#include "haptics/base/AlignedBuffer.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::haptics;

TEST(InverseRoots, AreThoseOfDoublePrecision)
{
    constexpr int kCount = 100000 / kernels::kLanes * kernels::kLanes;
    midair::base::AlignedBuffer<float> x, inverse;
    x.reserve(kCount);
    inverse.reserve(kCount);
    for (int i = 0; i < kCount; ++i) // squares of distances: 0.03 to 3,000 wavelengths
        x[i] = 1e-3f * std::pow(1e10f, static_cast<float>(i) / kCount);
    kernels::inverseRoots(kCount, x.data(), inverse.data());
    double worst = 0.0;
    for (int i = 0; i < kCount; ++i)
        worst = std::max(
            worst, std::fabs(static_cast<double>(inverse[i]) * std::sqrt(double(x[i])) - 1.0));
    EXPECT_LT(worst, 2e-7);
}

TEST(FormJacobian, IsThatOfDoublePrecision)
{
    constexpr double kPeak = 32760.0;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    for (const int width : {32, 416, 512})
        for (const int n : {1, 2, 7, 26})
        {
            const auto size = static_cast<std::size_t>(n), wide = static_cast<std::size_t>(width);
            midair::base::AlignedBuffer<std::int32_t> G, J;
            midair::base::AlignedBuffer<float> uRe, uIm, rRe, rIm;
            G.reserve(size * wide);
            J.reserve((size + 1) / 2 * wide);
            for (midair::base::AlignedBuffer<float>* v : {&uRe, &uIm})
                v->reserve(size);
            for (midair::base::AlignedBuffer<float>* v : {&rRe, &rIm})
                v->reserve(wide);
            std::vector<std::complex<double>> g(size * wide), u(size), r(wide);
            for (std::size_t k = 0; k < g.size(); ++k)
            {
                const auto entry = std::polar(kPeak * std::fabs(part(random)), 3.15 * part(random));
                const double low = std::round(entry.real()), high = std::round(entry.imag());
                g[k] = {low, high};
                G[k] = static_cast<std::int32_t>(high * 65536.0 + low);
            }
            for (std::size_t l = 0; l < size; ++l)
            {
                u[l] = std::polar(1.0, 3.15 * part(random));
                uRe[l] = static_cast<float>(u[l].real());
                uIm[l] = static_cast<float>(u[l].imag());
            }
            for (std::size_t i = 0; i < wide; ++i)
            {
                r[i] = std::polar(i == 0 ? 1.0 : std::fabs(part(random)), 3.15 * part(random));
                rRe[i] = static_cast<float>(r[i].real());
                rIm[i] = static_cast<float>(r[i].imag());
            }
            kernels::formJacobian(
                G.data(), n, width, uRe.data(), uIm.data(), rRe.data(), rIm.data(), J.data());
            for (std::size_t l = 0; l < size; ++l)
                for (std::size_t i = 0; i < wide; ++i)
                {
                    const std::int32_t pair = J[l / 2 * wide + i];
                    const double found =
                        l % 2 == 0 ? static_cast<std::int16_t>(pair) : pair / 65536.0;
                    const double exact = -std::imag(std::conj(u[l]) * g[l * wide + i] * r[i]);
                    ASSERT_NEAR(found, exact, 3e-4 * kPeak) << n << ' ' << l << ' ' << i;
                }
        }
}
