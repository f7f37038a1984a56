#include "device/drive/EncoderKernels.h"

#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace midair::device::MIDAIR_SET
{

namespace
{

constexpr auto kPi = static_cast<float>(base::kPi);

// atan t, 0 <= t <= 1, error below 2e-8: Abramowitz and Stegun, 4.4.49.
inline __attribute__((always_inline)) float atanOfRatio(float t)
{
    const float s = t * t;
    float sum = 0.0028662257F;
    sum = sum * s - 0.0161657367F;
    sum = sum * s + 0.0429096138F;
    sum = sum * s - 0.0752896400F;
    sum = sum * s + 0.1065626393F;
    sum = sum * s - 0.1420889944F;
    sum = sum * s + 0.1999355085F;
    sum = sum * s - 0.3333314528F;
    return t + t * s * sum;
}

// asin x, 0 <= x <= 1, error below 2e-8: Abramowitz and Stegun, 4.4.46.
inline __attribute__((always_inline)) float asinOfUnit(float x)
{
    float sum = -0.0012624911F;
    sum = sum * x + 0.0066700901F;
    sum = sum * x - 0.0170881256F;
    sum = sum * x + 0.0308918810F;
    sum = sum * x - 0.0501743046F;
    sum = sum * x + 0.0889789874F;
    sum = sum * x - 0.2145988016F;
    sum = sum * x + 1.5707963050F;
    return kPi / 2 - std::sqrt(1.0F - x) * sum;
}

} // namespace

// Phase level: round(128/pi atan2(im, re)) modulo 256.
//
// Duty level (base/DutyLaw.h): the border between the amplitudes of L and L+1 is their mean,
// (sin(pi L/510) + sin(pi (L+1)/510))/2 = sin(pi (L+1/2)/510) cos(pi/1020). So the level nearest in
// amplitude is round(510/pi asin(r / cos(pi/1020))).
void encodeLevels(const float* __restrict q,
                  int m,
                  std::uint8_t* __restrict phase,
                  std::uint8_t* __restrict duty)
{
    constexpr float kLevelsPerRadian = 128.0F / kPi;
    constexpr float kDutiesPerRadian = base::kDutyPeriod / kPi;
    constexpr float kOverBorder = 1.0000047436F; // 1 / cos(pi/1020)
    for (int i = 0; i < m; ++i)
    {
        const float re = q[2 * i];
        const float im = q[2 * i + 1];
        const float absRe = std::fabs(re);
        const float absIm = std::fabs(im);
        const float large = std::max(absRe, absIm);
        const float small = std::min(absRe, absIm);
        const float t = small / std::max(large, 1e-37F); // 0 for q = 0
        float angle = atanOfRatio(t);
        angle = absIm > absRe ? kPi / 2 - angle : angle;
        angle = re < 0.0F ? kPi - angle : angle;
        angle = im < 0.0F ? 2 * kPi - angle : angle;
        // Not large^2 + small^2: that overflows for finite q. Infinity clips like any other
        // amplitude over 1.
        const float r = std::min(large * std::sqrt(1.0F + t * t) * kOverBorder, 1.0F);
        phase[i] =
            static_cast<std::uint8_t>(static_cast<int>(angle * kLevelsPerRadian + 0.5F) & 255);
        duty[i] =
            static_cast<std::uint8_t>(static_cast<int>(asinOfUnit(r) * kDutiesPerRadian + 0.5F));
    }
}

// Infinities and NaNs have all exponent bits set. Tests the bits because a compiler may assume
// finite values.
bool allFinite(const float* values, int count)
{
    constexpr std::uint32_t kExponent = 0x7f800000U;
    std::uint32_t bad = 0;
    for (int i = 0; i < count; ++i)
    {
        std::uint32_t bits = 0;
        std::memcpy(&bits, values + i, sizeof bits);
        bad |= static_cast<std::uint32_t>((bits & kExponent) == kExponent);
    }
    return bad == 0;
}

void addDuties(const std::uint8_t* duty, int m, int* peak, std::uint32_t* sum)
{
    std::uint8_t most = 0;
    std::uint32_t all = 0;
    for (int i = 0; i < m; ++i)
    {
        most = std::max(most, duty[i]);
        all += duty[i];
    }
    *peak = std::max(*peak, static_cast<int>(most));
    *sum += all;
}

} // namespace midair::device::MIDAIR_SET
