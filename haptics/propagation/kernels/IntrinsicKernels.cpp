// The kernels that need instructions a compiler does not choose by itself: estimates of 1/sqrt(x), and products of pairs of
// 16 bits that are added up at once. For each: plain C++, then with AVX2, then with AVX-512.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <cmath>

#ifdef MIDAIR_HAS_CLONES
#define MIDAIR_PLAIN __attribute__((target("default")))
#define MIDAIR_AVX2 __attribute__((target("arch=x86-64-v3")))
#define MIDAIR_AVX512 __attribute__((target("arch=x86-64-v4")))
// GCC 12 takes what its own intrinsics leave open on purpose for an oversight (its bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#define MIDAIR_PLAIN
#endif

namespace midair::haptics::kernels
{

namespace
{

MIDAIR_PLAIN void rootsOf(int count, const float* x, float* inverse)
{
#pragma omp simd aligned(x, inverse : 64)
    for (int i = 0; i < count; ++i)
        inverse[i] = 1.0f / std::sqrt(x[i]);
}

MIDAIR_PLAIN void jacobianOf(const std::int32_t* G,
                             int n,
                             int width,
                             const float* uRe,
                             const float* uIm,
                             const float* rRe,
                             const float* rIm,
                             std::int32_t* J)
{
    constexpr float kUnit = 1.0f / 65536.0f;
    for (int l = 0; l < n; l += 2)
    {
        // The last row of an odd n has no partner: its own once more, with u = 0.
        const bool pair = l + 1 < n;
        const std::int32_t *a = G + width * l, *b = pair ? a + width : a;
        std::int32_t* row = J + width * (l / 2);
        const float ur = uRe[l] * kUnit, ui = uIm[l] * kUnit;
        const float vr = pair ? uRe[l + 1] * kUnit : 0.0f, vi = pair ? uIm[l + 1] * kUnit : 0.0f;
#pragma omp simd aligned(a, b, row, rRe, rIm : 64)
        for (int i = 0; i < width; ++i)
        {
            const float x = rRe[i], y = rIm[i];
            const float first = lowOf(a[i]) * (ui * x - ur * y) - highOf(a[i]) * (ur * x + ui * y);
            const float second = lowOf(b[i]) * (vi * x - vr * y) - highOf(b[i]) * (vr * x + vi * y);
            row[i] = packPair(first, second);
        }
    }
}

#ifdef MIDAIR_HAS_CLONES
// With an estimate y and r = 1 - x y^2: 1/sqrt(x) = y (1 - r)^(-1/2) = y + y r (1/2 + 3/8 r), and r^3 is lost (|r| < 8e-4).
MIDAIR_AVX2 void rootsOf(int count, const float* x, float* inverse)
{
    const __m256 one = _mm256_set1_ps(1.0f);
    const __m256 half = _mm256_set1_ps(0.5f), threeEighths = _mm256_set1_ps(0.375f);
    for (int i = 0; i < count; i += 8)
    {
        const __m256 a = _mm256_load_ps(x + i), y = _mm256_rsqrt_ps(a);
        const __m256 r = _mm256_fnmadd_ps(_mm256_mul_ps(a, y), y, one);
        const __m256 rest = _mm256_fmadd_ps(r, threeEighths, half);
        _mm256_store_ps(inverse + i, _mm256_fmadd_ps(_mm256_mul_ps(y, r), rest, y));
    }
}

// The estimate is better here: |r| < 1.3e-4, and r^2 is lost.
MIDAIR_AVX512 void rootsOf(int count, const float* x, float* inverse)
{
    const __m512 one = _mm512_set1_ps(1.0f), half = _mm512_set1_ps(0.5f);
    for (int i = 0; i < count; i += 16)
    {
        const __m512 a = _mm512_load_ps(x + i), y = _mm512_rsqrt14_ps(a);
        const __m512 r = _mm512_fnmadd_ps(_mm512_mul_ps(a, y), y, one);
        _mm512_store_ps(inverse + i, _mm512_fmadd_ps(_mm512_mul_ps(y, r), half, y));
    }
}

// With c = conj(u_l) r_i: J_li = -(Re G Im c + Im G Re c). Lanes hold pairs of 16 bits, r and u in units of 1/kUnity, c in
// units of 2^-14. What is cut off, and the carry that the upper half of G has from the lower, is below 3e-4 of the row's bound:
// of a matrix that both directions of a step read alike, which need not be exact.
constexpr float kUnity = 32766.0f; // room for what is a little over 1

std::int32_t pairOf(float low, float high)
{
    const auto bits = [](float x) { return static_cast<std::uint32_t>(std::lrint(x * kUnity)); };
    return static_cast<std::int32_t>((bits(high) << 16) | (bits(low) & 0xffffU));
}

// Of two rows u and v: what makes -Im c and -Re c of a pair (Re r, Im r), and the rows.
struct RowPair
{
    std::int32_t uIm, uRe, vIm, vRe;
    const std::int32_t *a, *b;
};

RowPair rowPair(const std::int32_t* G, int n, int width, const float* uRe, const float* uIm, int l)
{
    // The last row of an odd n has no partner: its own once more, with v = 0.
    const bool pair = l + 1 < n;
    const float vr = pair ? uRe[l + 1] : 0.0f, vi = pair ? uIm[l + 1] : 0.0f;
    const std::int32_t* a = G + width * l;
    return {pairOf(uIm[l], -uRe[l]),
            pairOf(-uRe[l], -uIm[l]),
            pairOf(vi, -vr),
            pairOf(-vr, -vi),
            a,
            pair ? a + width : a};
}

MIDAIR_AVX2 inline __m256i load(const std::int32_t* x)
{
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(x));
}

MIDAIR_AVX2 inline __m256i turned(__m256i g, __m256i r, __m256i im, __m256i re)
{
    const __m256i low = _mm256_srli_epi32(_mm256_madd_epi16(r, im), 16);
    return _mm256_madd_epi16(g, _mm256_blend_epi16(low, _mm256_madd_epi16(r, re), 0xaa));
}

MIDAIR_AVX2 void jacobianOf(const std::int32_t* G,
                            int n,
                            int width,
                            const float* uRe,
                            const float* uIm,
                            const float* rRe,
                            const float* rIm,
                            std::int32_t* J)
{
    alignas(64) std::int32_t r[kMaxWidth];
    const __m256 unity = _mm256_set1_ps(kUnity);
    for (int i = 0; i < width; i += 8)
    {
        const __m256i x = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_load_ps(rRe + i), unity));
        const __m256i y = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_load_ps(rIm + i), unity));
        _mm256_store_si256(reinterpret_cast<__m256i*>(r + i),
                           _mm256_blend_epi16(x, _mm256_slli_epi32(y, 16), 0xaa));
    }
    for (int l = 0; l < n; l += 2)
    {
        const RowPair rows = rowPair(G, n, width, uRe, uIm, l);
        const __m256i uI = _mm256_set1_epi32(rows.uIm), uR = _mm256_set1_epi32(rows.uRe);
        const __m256i vI = _mm256_set1_epi32(rows.vIm), vR = _mm256_set1_epi32(rows.vRe);
        std::int32_t* to = J + width * (l / 2);
        for (int i = 0; i < width; i += 8)
        {
            const __m256i q = load(r + i);
            const __m256i first = turned(load(rows.a + i), q, uI, uR);
            const __m256i second = turned(load(rows.b + i), q, vI, vR);
            _mm256_store_si256(reinterpret_cast<__m256i*>(to + i),
                               _mm256_blend_epi16(_mm256_srli_epi32(first, 14),
                                                  _mm256_slli_epi32(second, 2),
                                                  0xaa));
        }
    }
}

constexpr std::uint32_t kUpper = 0xaaaaaaaa; // halves of the lanes

MIDAIR_AVX512 inline __m512i turned(__m512i g, __m512i r, __m512i im, __m512i re)
{
    const __m512i low = _mm512_srli_epi32(_mm512_madd_epi16(r, im), 16);
    return _mm512_madd_epi16(g, _mm512_mask_blend_epi16(kUpper, low, _mm512_madd_epi16(r, re)));
}

MIDAIR_AVX512 void jacobianOf(const std::int32_t* G,
                              int n,
                              int width,
                              const float* uRe,
                              const float* uIm,
                              const float* rRe,
                              const float* rIm,
                              std::int32_t* J)
{
    alignas(64) std::int32_t r[kMaxWidth];
    const __m512 unity = _mm512_set1_ps(kUnity);
    for (int i = 0; i < width; i += 16)
    {
        const __m512i x = _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_load_ps(rRe + i), unity));
        const __m512i y = _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_load_ps(rIm + i), unity));
        _mm512_store_si512(r + i, _mm512_mask_blend_epi16(kUpper, x, _mm512_slli_epi32(y, 16)));
    }
    for (int l = 0; l < n; l += 2)
    {
        const RowPair rows = rowPair(G, n, width, uRe, uIm, l);
        const __m512i uI = _mm512_set1_epi32(rows.uIm), uR = _mm512_set1_epi32(rows.uRe);
        const __m512i vI = _mm512_set1_epi32(rows.vIm), vR = _mm512_set1_epi32(rows.vRe);
        std::int32_t* to = J + width * (l / 2);
        for (int i = 0; i < width; i += 16)
        {
            const __m512i q = _mm512_load_si512(r + i);
            const __m512i first = turned(_mm512_load_si512(rows.a + i), q, uI, uR);
            const __m512i second = turned(_mm512_load_si512(rows.b + i), q, vI, vR);
            _mm512_store_si512(to + i,
                               _mm512_mask_blend_epi16(kUpper,
                                                       _mm512_srli_epi32(first, 14),
                                                       _mm512_slli_epi32(second, 2)));
        }
    }
}
#endif

} // namespace

void inverseRoots(int count, const float* x, float* inverse)
{
    rootsOf(count & ~(kLanes - 1), x, inverse);
}

void formJacobian(const std::int32_t* G,
                  int n,
                  int width,
                  const float* uRe,
                  const float* uIm,
                  const float* rRe,
                  const float* rIm,
                  std::int32_t* J)
{
    jacobianOf(G, n, width & ~(kLanes - 1), uRe, uIm, rRe, rIm, J);
}

} // namespace midair::haptics::kernels
