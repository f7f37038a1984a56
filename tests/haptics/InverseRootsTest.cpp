#include "haptics/AlignedBuffer.h"
#include "haptics/PropagationKernels.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

TEST(InverseRoots, AreThoseOfDoublePrecision)
{
    constexpr int kCount = 100000 / kernels::kLanes * kernels::kLanes;
    AlignedBuffer<float> x, inverse;
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
