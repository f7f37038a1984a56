#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

// Compiled with -O3, contraction to fused multiply-adds and without errno, see CMakeLists.txt.
// Never compile it with -ffast-math: rounding relies on the order of operations.
#define MIDAIR_INLINE inline __attribute__((always_inline))

namespace midair::haptics::kernels
{

constexpr int kMaxWidth = 512; ///< largest width of a block

// Adding and subtracting 1.5 * 2^23 rounds to an integer without an instruction that plain x86-64
// lacks.
constexpr float kToInteger = 12582912.0f;
constexpr double kToIntegerDouble = 6755399441055744.0; // 1.5 * 2^52

MIDAIR_INLINE float rounded(float x)
{
    return (x + kToInteger) - kToInteger;
}
MIDAIR_INLINE double rounded(double x)
{
    return (x + kToIntegerDouble) - kToIntegerDouble;
}

// Two numbers of at most kFixedPeak in one lane of 32 bits: high * 65536 + low, each rounded to an
// integer. The float nearest to a lane is high * 65536 to half a unit, and the lane shifted up by
// 16 is low * 65536 exactly.
constexpr float kFixedPeak = 32760.0f;

// Returns the factor for stored numbers whose kFixedPeak represents \a peak.
MIDAIR_INLINE float fixedScale(float peak)
{
    return peak / (kFixedPeak * 65536.0f);
}

MIDAIR_INLINE std::int32_t bitsOf(float x)
{
    std::int32_t bits = 0;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}

MIDAIR_INLINE std::int32_t packPair(float low, float high)
{
    constexpr std::int32_t kOfInteger =
        0x4B400000; // the bits of kToInteger, whose lowest bits hold the rounded number
    const std::uint32_t top = static_cast<std::uint32_t>(bitsOf(high + kToInteger)) << 16;
    return static_cast<std::int32_t>(
        top + static_cast<std::uint32_t>(bitsOf(low + kToInteger) - kOfInteger));
}

MIDAIR_INLINE float highOf(std::int32_t pair)
{
    return static_cast<float>(pair);
}

MIDAIR_INLINE float lowOf(std::int32_t pair)
{
    return static_cast<float>(static_cast<std::int32_t>(static_cast<std::uint32_t>(pair) << 16));
}

// sin(pi f) and cos(pi f) for |f| <= 0.516: minimax polynomials in f^2 (errors 2e-8 and 7e-8).
MIDAIR_INLINE float sinHalf(float f)
{
    const float t = f * f;
    return f * (3.14159263503f +
                t * (-5.16770929141f +
                     t * (2.55005910546f + t * (-0.598158107429f + t * 0.0773628877593f))));
}
MIDAIR_INLINE float cosHalf(float f)
{
    const float t = f * f;
    return 0.99999993561f +
           t * (-4.93479009056f +
                t * (4.05834761398f + t * (-1.33141553217f + t * 0.218668933026f)));
}

// The same to 6e-7 and 7e-6, with a term less.
MIDAIR_INLINE float quickSinHalf(float f)
{
    const float t = f * f;
    return f * (3.14158201f + t * (-5.16714212f + t * (2.54189257f + t * -0.554618963f)));
}
MIDAIR_INLINE float quickCosHalf(float f)
{
    const float t = f * f;
    return 0.999993285f + t * (-4.933937f + t * (4.04127025f + t * -1.22208357f));
}

// a, or -a if \a shifted is an odd number of kToInteger.
MIDAIR_INLINE float withSign(float a, float shifted)
{
    const std::uint32_t bits =
        static_cast<std::uint32_t>(bitsOf(a)) ^ (static_cast<std::uint32_t>(bitsOf(shifted)) << 31);
    float turned = 0.0f;
    std::memcpy(&turned, &bits, sizeof turned);
    return turned;
}

// sin(2 pi f) and cos(2 pi f): sin 2a = 2 sin a cos a and cos 2a = 1 - 2 sin^2 a.
MIDAIR_INLINE void sinCosTurns(float f, float& sine, float& cosine)
{
    const float s = sinHalf(f), c = cosHalf(f);
    sine = 2.0f * s * c;
    cosine = 1.0f - 2.0f * s * s;
}

// exp(-x), 0 <= x <= 1: a polynomial in x/4, to the fourth power; 3e-7.
MIDAIR_INLINE float expOfMinus(float x)
{
    const float y = -0.25f * x;
    const float e =
        1.0f +
        y * (1.0f + y * (0.5f + y * (1.0f / 6.0f + y * (1.0f / 24.0f + y * (1.0f / 120.0f)))));
    return (e * e) * (e * e);
}

// The phase of x + j y in turns, by atan on [0, 1] (minimax, 2e-8 turns) and octants; 0 for 0.
MIDAIR_INLINE float phaseTurns(float x, float y)
{
    const float ax = std::fabs(x), ay = std::fabs(y);
    const float larger = std::max(std::max(ax, ay), 1e-30f), smaller = std::min(ax, ay);
    const float t = smaller / larger, u = t * t;
    float P = -0.0007607900871f;
    P = P * u + 0.003908243694f;
    P = P * u + -0.009533944073f;
    P = P * u + 0.01582427365f;
    P = P * u + -0.02232847756f;
    P = P * u + 0.03178542557f;
    P = P * u + -0.05304967427f;
    P = P * u + 0.159154929f;
    float turns = t * P;
    turns = ay > ax ? 0.25f - turns : turns;
    turns = x < 0.0f ? 0.5f - turns : turns;
    turns = y < 0.0f ? -turns : turns;
    return turns;
}

} // namespace midair::haptics::kernels
