#include "device/DriveEncoder.h"

#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#if defined(MIDAIR_HAS_CLONES)
#define MIDAIR_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define MIDAIR_CLONES
#endif

namespace midair::device
{

namespace
{

constexpr float kPi = 3.14159265358979F;

// atan t, 0 <= t <= 1, error below 2e-8: Abramowitz and Stegun, 4.4.49.
inline float atanOfRatio(float t)
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
inline float asinOfUnit(float x)
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

// Phase level: round(128/pi atan2(im, re)) modulo 256.
//
// Duty level (base/DutyLaw.h): the border between the amplitudes of L and L+1 is their mean,
// (sin(pi L/510) + sin(pi (L+1)/510))/2 = sin(pi (L+1/2)/510) cos(pi/1020). So the level nearest in amplitude is round(510/pi asin(r / cos(pi/1020))).
MIDAIR_CLONES
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
        // Not large^2 + small^2: that overflows for finite q. Infinity clips like any other amplitude over 1.
        const float r = std::min(large * std::sqrt(1.0F + t * t) * kOverBorder, 1.0F);
        phase[i] =
            static_cast<std::uint8_t>(static_cast<int>(angle * kLevelsPerRadian + 0.5F) & 255);
        duty[i] =
            static_cast<std::uint8_t>(static_cast<int>(asinOfUnit(r) * kDutiesPerRadian + 0.5F));
    }
}

// Infinities and NaNs have all bits of the exponent set. Looks at the bits since a compiler may assume finite values.
MIDAIR_CLONES
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

std::array<std::complex<float>, 256> makePhasors()
{
    std::array<std::complex<float>, 256> phasors;
    for (int level = 0; level < 256; ++level)
        phasors[level] = std::complex<float>(std::polar(1.0, 2 * M_PI * level / 256.0));
    return phasors;
}

} // namespace

bool encode(const std::complex<float>* q, int m, DriveSignal& signal)
{
    signal.phase.resize(m);
    signal.duty.resize(m);
    const auto* values =
        reinterpret_cast<const float*>(q); // complex<float> is two floats: [complex.numbers]
    if (!allFinite(values, 2 * m))
    {
        std::fill(signal.phase.begin(), signal.phase.end(), std::uint8_t(0));
        std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
        return false;
    }
    encodeLevels(values, m, signal.phase.data(), signal.duty.data());
    return true;
}

void decode(const DriveSignal& signal, std::vector<std::complex<float>>& q)
{
    static const auto kPhasors = makePhasors();
    const std::vector<float>& amplitudes = amplitudeLevels();
    q.resize(signal.phase.size());
    for (std::size_t i = 0; i < q.size(); ++i)
        q[i] = amplitudes[signal.duty[i]] * kPhasors[signal.phase[i]];
}

const std::vector<float>& amplitudeLevels()
{
    static const std::vector<float> kLevels = []
    {
        std::vector<float> levels(256);
        for (int level = 0; level < 256; ++level)
            levels[level] = static_cast<float>(base::dutyAmplitude(level));
        return levels;
    }();
    return kLevels;
}

} // namespace midair::device
