// The kernels of the drive encoder against double precision, within what their descriptions
// promise.
#include "device/drive/EncoderKernels.h"

#include "tests/haptics/base/simd/OnEverySet.h"

#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <vector>

using namespace midair::device;

namespace
{

MIDAIR_ON_EVERY_SET(EncoderKernels);

double cyclic(double x, double period)
{
    return std::fabs(std::remainder(x, period));
}

double amplitudeOfDuty(int duty)
{
    return std::sin(M_PI * duty / 510.0);
}

} // namespace

TEST_P(EncoderKernels, EncodeLevels)
{
    constexpr int kCount = 20011; // no multiple of a register
    std::mt19937 random(5);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    std::vector<std::complex<float>> q(kCount);
    for (auto& value : q)
        value = std::complex<float>(std::polar(1.2 * part(random), 7.0 * part(random)));
    q[0] = 0.0F;
    q[1] = {-3e38F, 3e38F};
    q[2] = {1e-36F, -1e-36F};
    std::vector<std::uint8_t> phase(kCount), duty(kCount);
    encodeLevels(reinterpret_cast<const float*>(q.data()), kCount, phase.data(), duty.data());
    for (int i = 0; i < kCount; ++i)
    {
        const std::complex<double> exact(q[i]);
        const double amplitude = std::min(1.0, std::hypot(exact.real(), exact.imag()));
        ASSERT_LE(cyclic(phase[i] - std::arg(exact) * 128.0 / M_PI, 256.0), 0.5 + 1e-4)
            << exact << ' ' << int(phase[i]);
        // No other level's amplitude is nearer, but for a hundredth of the step.
        const double step =
            std::max(amplitudeOfDuty(std::min(255, duty[i] + 1)) - amplitudeOfDuty(duty[i]),
                     amplitudeOfDuty(duty[i]) - amplitudeOfDuty(std::max(0, duty[i] - 1)));
        const double error = std::fabs(amplitudeOfDuty(duty[i]) - amplitude);
        for (const int other : {std::max(0, duty[i] - 1), std::min(255, duty[i] + 1)})
            ASSERT_LE(error, std::fabs(amplitudeOfDuty(other) - amplitude) + 1e-2 * step)
                << exact << ' ' << int(duty[i]);
    }
    EXPECT_EQ(duty[0], 0);
    EXPECT_EQ(duty[1], 255);
    EXPECT_EQ(phase[1], 96);
}

TEST_P(EncoderKernels, AllFinite)
{
    std::vector<float> values(1003, 3e38F);
    values[5] = 1e-45F;
    EXPECT_TRUE(allFinite(values.data(), 1003));
    for (const int at : {0, 500, 1002})
        for (const float bad : {std::numeric_limits<float>::infinity(),
                                -std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::quiet_NaN()})
        {
            const float before = values[at];
            values[at] = bad;
            EXPECT_FALSE(allFinite(values.data(), 1003)) << at << ' ' << bad;
            values[at] = before;
        }
}

TEST_P(EncoderKernels, AddDuties)
{
    std::vector<std::uint8_t> duty(1003, 255);
    duty[1002] = 1;
    int peak = 0;
    std::uint32_t sum = 0;
    addDuties(duty.data(), 1003, &peak, &sum);
    EXPECT_EQ(peak, 255);
    EXPECT_EQ(sum, 1002U * 255U + 1U);
    addDuties(duty.data() + 1002, 1, &peak, &sum);
    EXPECT_EQ(peak, 255) << "of both calls";
    EXPECT_EQ(sum, 1002U * 255U + 2U);
    peak = 0;
    addDuties(duty.data() + 1002, 1, &peak, &sum);
    EXPECT_EQ(peak, 1) << "wherever it is";
    addDuties(duty.data(), 0, &peak, &sum);
    EXPECT_EQ(peak, 1);
}
