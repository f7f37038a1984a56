#pragma once

#include "haptics/propagation/kernels/KernelTools.h"

// Operations that compilers do not choose by themselves, on the widest registers of the instruction
// set of a source: estimates of 1/sqrt(x), and sums of products of 16-bit pairs (MIDAIR_HAS_PAIRS).
// Code common to all sets is a plain loop, vectorised by the compiler.
#if defined(__AVX2__)
#define MIDAIR_HAS_PAIRS
// GCC 12 warns about values that its own intrinsics leave uninitialised on purpose (GCC bug
// 105593).
#pragma GCC diagnostic push
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

namespace midair::haptics::kernels::MIDAIR_SET
{

#if defined(__AVX512F__)

struct Register
{
    using Floats = __m512;
    using Words = __m512i; // lanes of 32 bits, or pairs of 16
    static constexpr int kLanes = 16;
    static constexpr std::uint32_t kUpper = 0xaaaaaaaa; // halves of the lanes

    MIDAIR_INLINE static Floats load(const float* x) { return _mm512_load_ps(x); }
    MIDAIR_INLINE static Words load(const std::int32_t* x) { return _mm512_load_si512(x); }
    MIDAIR_INLINE static void store(float* to, Floats x) { _mm512_store_ps(to, x); }
    MIDAIR_INLINE static void store(std::int32_t* to, Words x) { _mm512_store_si512(to, x); }
    MIDAIR_INLINE static Words all(std::int32_t x) { return _mm512_set1_epi32(x); }
    MIDAIR_INLINE static Floats all(float x) { return _mm512_set1_ps(x); }
    MIDAIR_INLINE static Floats sum(Floats a, Floats b) { return _mm512_add_ps(a, b); }
    MIDAIR_INLINE static Floats difference(Floats a, Floats b) { return _mm512_sub_ps(a, b); }
    MIDAIR_INLINE static Floats product(Floats a, Floats b) { return _mm512_mul_ps(a, b); }
    MIDAIR_INLINE static Floats larger(Floats a, Floats b) { return _mm512_max_ps(a, b); }
    // x without the nearest integer.
    MIDAIR_INLINE static Floats beyondNearest(Floats x) { return _mm512_reduce_ps(x, 0); }
    // 1/sqrt(x) to 4e-4.
    MIDAIR_INLINE static Floats inverseRootEstimate(Floats x) { return _mm512_rsqrt14_ps(x); }
    // x, or 0 where \a of is negative.
    MIDAIR_INLINE static Floats unlessNegative(Floats of, Floats x)
    {
        return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(of, zero(), _CMP_GE_OQ), x);
    }
    // table[x], x rounded down, for 0 <= x < 16; a table has 16 numbers.
    MIDAIR_INLINE static Words below(Floats x) { return _mm512_cvttps_epi32(x); }
    MIDAIR_INLINE static Floats lookUp(const float* table, Words at)
    {
        return _mm512_permutexvar_ps(at, load(table));
    }
    // The nearest integers.
    MIDAIR_INLINE static Words nearest(Floats x) { return _mm512_cvtps_epi32(x); }
    // x times a number, rounded to the nearest integer.
    MIDAIR_INLINE static Words rounded(Floats x, float by)
    {
        return _mm512_cvtps_epi32(_mm512_mul_ps(x, _mm512_set1_ps(by)));
    }
    template<int kBits>
    MIDAIR_INLINE static Words up(Words x)
    {
        return _mm512_slli_epi32(x, kBits);
    }
    template<int kBits>
    MIDAIR_INLINE static Words down(Words x)
    {
        return _mm512_srli_epi32(x, kBits);
    }
    // For each lane: low times low plus high times high.
    MIDAIR_INLINE static Words pairProduct(Words a, Words b) { return _mm512_madd_epi16(a, b); }
    MIDAIR_INLINE static Words sum(Words a, Words b) { return _mm512_add_epi32(a, b); }
    // The halves of pairs times 65536, see lowOf and highOf.
    MIDAIR_INLINE static Floats low(Words x)
    {
        return _mm512_cvtepi32_ps(_mm512_slli_epi32(x, 16));
    }
    MIDAIR_INLINE static Floats high(Words x) { return _mm512_cvtepi32_ps(x); }
    MIDAIR_INLINE static Floats zero() { return _mm512_setzero_ps(); }
    // c + a b and c - a b.
    MIDAIR_INLINE static Floats plus(Floats c, Floats a, Floats b)
    {
        return _mm512_fmadd_ps(a, b, c);
    }
    MIDAIR_INLINE static Floats minus(Floats c, Floats a, Floats b)
    {
        return _mm512_fnmadd_ps(a, b, c);
    }
    MIDAIR_INLINE static float total(Floats x) { return _mm512_reduce_add_ps(x); }
    // x + y by.
    MIDAIR_INLINE static Floats plus(Floats x, Words y, float by)
    {
        return _mm512_fmadd_ps(_mm512_cvtepi32_ps(y), _mm512_set1_ps(by), x);
    }
    // For each lane: the lower half of one and the upper half of the other.
    MIDAIR_INLINE static Words halves(Words lower, Words upper)
    {
        return _mm512_mask_blend_epi16(kUpper, lower, upper);
    }
    // With an estimate y and r = 1 - x y^2: 1/sqrt(x) = y (1 - r)^(-1/2) = y + y r / 2, neglecting
    // r^2 (|r| < 1.3e-4).
    MIDAIR_INLINE static Floats inverseRoot(Floats x)
    {
        const Floats y = _mm512_rsqrt14_ps(x);
        const Floats r = _mm512_fnmadd_ps(_mm512_mul_ps(x, y), y, _mm512_set1_ps(1.0f));
        return _mm512_fmadd_ps(_mm512_mul_ps(y, r), _mm512_set1_ps(0.5f), y);
    }
    // to[i * stride + l] = from[l * width + i] for kLanes rows of as many numbers: pairs of rows
    // are mixed, then pairs of pairs, then quarters of registers.
    MIDAIR_INLINE static void transpose(const float* from, int width, float* to, int stride)
    {
        Floats a[kLanes], b[kLanes];
        for (int l = 0; l < kLanes; ++l)
            a[l] = load(from + l * width);
        for (int l = 0; l < kLanes; l += 2)
        {
            b[l] = _mm512_unpacklo_ps(a[l], a[l + 1]);
            b[l + 1] = _mm512_unpackhi_ps(a[l], a[l + 1]);
        }
        for (int l = 0; l < kLanes; l += 4)
            for (int k = 0; k < 2; ++k)
            {
                const __m512d low = _mm512_castps_pd(b[l + k]);
                const __m512d high = _mm512_castps_pd(b[l + k + 2]);
                a[l + 2 * k] = _mm512_castpd_ps(_mm512_unpacklo_pd(low, high));
                a[l + 2 * k + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(low, high));
            }
        for (int l = 0; l < kLanes; l += 8)
            for (int k = 0; k < 4; ++k)
            {
                b[l + k] = _mm512_shuffle_f32x4(a[l + k], a[l + k + 4], 0x88);
                b[l + k + 4] = _mm512_shuffle_f32x4(a[l + k], a[l + k + 4], 0xdd);
            }
        for (int k = 0; k < 8; ++k)
        {
            store(to + k * stride, _mm512_shuffle_f32x4(b[k], b[k + 8], 0x88));
            store(to + (k + 8) * stride, _mm512_shuffle_f32x4(b[k], b[k + 8], 0xdd));
        }
    }
};

#elif defined(__AVX2__)

struct Register
{
    using Floats = __m256;
    using Words = __m256i;
    static constexpr int kLanes = 8;

    MIDAIR_INLINE static Floats load(const float* x) { return _mm256_load_ps(x); }
    MIDAIR_INLINE static Words load(const std::int32_t* x)
    {
        return _mm256_load_si256(reinterpret_cast<const Words*>(x));
    }
    MIDAIR_INLINE static void store(float* to, Floats x) { _mm256_store_ps(to, x); }
    MIDAIR_INLINE static void store(std::int32_t* to, Words x)
    {
        _mm256_store_si256(reinterpret_cast<Words*>(to), x);
    }
    MIDAIR_INLINE static Words all(std::int32_t x) { return _mm256_set1_epi32(x); }
    MIDAIR_INLINE static Floats all(float x) { return _mm256_set1_ps(x); }
    MIDAIR_INLINE static Floats sum(Floats a, Floats b) { return _mm256_add_ps(a, b); }
    MIDAIR_INLINE static Floats difference(Floats a, Floats b) { return _mm256_sub_ps(a, b); }
    MIDAIR_INLINE static Floats product(Floats a, Floats b) { return _mm256_mul_ps(a, b); }
    MIDAIR_INLINE static Floats larger(Floats a, Floats b) { return _mm256_max_ps(a, b); }
    MIDAIR_INLINE static Floats beyondNearest(Floats x)
    {
        return _mm256_sub_ps(x, _mm256_round_ps(x, _MM_FROUND_TO_NEAREST_INT));
    }
    MIDAIR_INLINE static Floats inverseRootEstimate(Floats x) { return _mm256_rsqrt_ps(x); }
    MIDAIR_INLINE static Floats unlessNegative(Floats of, Floats x)
    {
        return _mm256_and_ps(_mm256_cmp_ps(of, zero(), _CMP_GE_OQ), x);
    }
    MIDAIR_INLINE static Words below(Floats x) { return _mm256_cvttps_epi32(x); }
    MIDAIR_INLINE static Floats lookUp(const float* table, Words at)
    {
        // The fourth bit chooses the half of the table.
        return _mm256_blendv_ps(_mm256_permutevar8x32_ps(load(table), at),
                                _mm256_permutevar8x32_ps(load(table + 8), at),
                                _mm256_castsi256_ps(_mm256_slli_epi32(at, 28)));
    }
    MIDAIR_INLINE static Words nearest(Floats x) { return _mm256_cvtps_epi32(x); }
    MIDAIR_INLINE static Words rounded(Floats x, float by)
    {
        return _mm256_cvtps_epi32(_mm256_mul_ps(x, _mm256_set1_ps(by)));
    }
    template<int kBits>
    MIDAIR_INLINE static Words up(Words x)
    {
        return _mm256_slli_epi32(x, kBits);
    }
    template<int kBits>
    MIDAIR_INLINE static Words down(Words x)
    {
        return _mm256_srli_epi32(x, kBits);
    }
    MIDAIR_INLINE static Words pairProduct(Words a, Words b) { return _mm256_madd_epi16(a, b); }
    MIDAIR_INLINE static Words sum(Words a, Words b) { return _mm256_add_epi32(a, b); }
    // The halves of pairs times 65536, see lowOf and highOf.
    MIDAIR_INLINE static Floats low(Words x)
    {
        return _mm256_cvtepi32_ps(_mm256_slli_epi32(x, 16));
    }
    MIDAIR_INLINE static Floats high(Words x) { return _mm256_cvtepi32_ps(x); }
    MIDAIR_INLINE static Floats zero() { return _mm256_setzero_ps(); }
    // c + a b and c - a b.
    MIDAIR_INLINE static Floats plus(Floats c, Floats a, Floats b)
    {
        return _mm256_fmadd_ps(a, b, c);
    }
    MIDAIR_INLINE static Floats minus(Floats c, Floats a, Floats b)
    {
        return _mm256_fnmadd_ps(a, b, c);
    }
    MIDAIR_INLINE static float total(Floats x)
    {
        const __m128 four = _mm_add_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps(x, 1));
        const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
        return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
    }
    // x + y by.
    MIDAIR_INLINE static Floats plus(Floats x, Words y, float by)
    {
        return _mm256_fmadd_ps(_mm256_cvtepi32_ps(y), _mm256_set1_ps(by), x);
    }
    MIDAIR_INLINE static Words halves(Words lower, Words upper)
    {
        return _mm256_blend_epi16(lower, upper, 0xaa);
    }
    // The estimate is less exact here (|r| < 8e-4), so it takes one more term: y + y r (1/2 + 3/8
    // r), neglecting r^3.
    MIDAIR_INLINE static Floats inverseRoot(Floats x)
    {
        const Floats y = _mm256_rsqrt_ps(x);
        const Floats r = _mm256_fnmadd_ps(_mm256_mul_ps(x, y), y, _mm256_set1_ps(1.0f));
        const Floats rest = _mm256_fmadd_ps(r, _mm256_set1_ps(0.375f), _mm256_set1_ps(0.5f));
        return _mm256_fmadd_ps(_mm256_mul_ps(y, r), rest, y);
    }
    MIDAIR_INLINE static void transpose(const float* from, int width, float* to, int stride)
    {
        Floats a[kLanes], b[kLanes];
        for (int l = 0; l < kLanes; ++l)
            a[l] = load(from + l * width);
        for (int l = 0; l < kLanes; l += 2)
        {
            b[l] = _mm256_unpacklo_ps(a[l], a[l + 1]);
            b[l + 1] = _mm256_unpackhi_ps(a[l], a[l + 1]);
        }
        for (int l = 0; l < kLanes; l += 4)
            for (int k = 0; k < 2; ++k)
            {
                const __m256d low = _mm256_castps_pd(b[l + k]);
                const __m256d high = _mm256_castps_pd(b[l + k + 2]);
                a[l + 2 * k] = _mm256_castpd_ps(_mm256_unpacklo_pd(low, high));
                a[l + 2 * k + 1] = _mm256_castpd_ps(_mm256_unpackhi_pd(low, high));
            }
        for (int k = 0; k < 4; ++k)
        {
            store(to + k * stride, _mm256_permute2f128_ps(a[k], a[k + 4], 0x20));
            store(to + (k + 4) * stride, _mm256_permute2f128_ps(a[k], a[k + 4], 0x31));
        }
    }
};

#else

// One lane; the compiler vectorises the loop around it.
struct Register
{
    using Floats = float;
    static constexpr int kLanes = 1;

    MIDAIR_INLINE static Floats load(const float* x) { return *x; }
    MIDAIR_INLINE static void store(float* to, Floats x) { *to = x; }
    MIDAIR_INLINE static Floats all(float x) { return x; }
    MIDAIR_INLINE static Floats sum(Floats a, Floats b) { return a + b; }
    MIDAIR_INLINE static Floats plus(Floats c, Floats a, Floats b) { return c + a * b; }
    MIDAIR_INLINE static Floats inverseRoot(Floats x) { return 1.0f / std::sqrt(x); }
    // A tile is set before it is transposed, which the analyser doesn't see through std::fill().
    // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign)
    MIDAIR_INLINE static void transpose(const float* from, int, float* to, int) { *to = *from; }
};

#endif

} // namespace midair::haptics::kernels::MIDAIR_SET
