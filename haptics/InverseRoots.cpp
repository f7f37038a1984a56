// The one kernel that needs instructions a compiler does not choose by itself: estimates of 1/sqrt(x), made exact.
#include "haptics/KernelTools.h"
#include "haptics/PropagationKernels.h"

#include <cmath>

#ifdef MIDAIR_HAS_CLONES
#include <immintrin.h>
#endif

namespace midair::haptics::kernels
{

namespace
{

#ifdef MIDAIR_HAS_CLONES
__attribute__((target("default")))
#endif
void rootsOf(int count, const float* x, float* inverse)
{
    count &= ~(kLanes - 1);
#pragma omp simd aligned(x, inverse : 64)
    for (int i = 0; i < count; ++i)
        inverse[i] = 1.0f / std::sqrt(x[i]);
}

#ifdef MIDAIR_HAS_CLONES
// With an estimate y and r = 1 - x y^2: 1/sqrt(x) = y (1 - r)^(-1/2) = y + y r (1/2 + 3/8 r), and r^3 is lost (|r| < 8e-4).
__attribute__((target("arch=x86-64-v3"))) void rootsOf(int count, const float* x, float* inverse)
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
__attribute__((target("arch=x86-64-v4"))) void rootsOf(int count, const float* x, float* inverse)
{
    const __m512 one = _mm512_set1_ps(1.0f), half = _mm512_set1_ps(0.5f);
    for (int i = 0; i < count; i += 16)
    {
        const __m512 a = _mm512_load_ps(x + i), y = _mm512_maskz_rsqrt14_ps(0xffff, a);
        const __m512 r = _mm512_fnmadd_ps(_mm512_mul_ps(a, y), y, one);
        _mm512_store_ps(inverse + i, _mm512_fmadd_ps(_mm512_mul_ps(y, r), half, y));
    }
}
#endif

} // namespace

void inverseRoots(int count, const float* x, float* inverse)
{
    rootsOf(count, x, inverse);
}

} // namespace midair::haptics::kernels
