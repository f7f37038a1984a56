#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>

namespace midair::haptics::kernels::MIDAIR_SET
{

void transposedJacobian(const std::int32_t* J, int n, int width, const float* x, float* t)
{
    width &= ~(kLanes - 1);
    std::fill(t, t + width, 0.0f);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = J + width * (l / 2), *b = a + width;
        const float xa = x[l], xb = x[l + 1], xc = x[l + 2], xd = x[l + 3];
#pragma omp simd aligned(a, b, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += (lowOf(a[i]) * xa + highOf(a[i]) * xb) + (lowOf(b[i]) * xc + highOf(b[i]) * xd);
    }
    if (l < n)
    {
        const std::int32_t* a = J + width * (l / 2);
        const float xa = x[l], xb = x[l + 1];
#pragma omp simd aligned(a, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += lowOf(a[i]) * xa + highOf(a[i]) * xb;
    }
}

void applyJacobian(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = J + width * (l / 2), *b = a + width;
        float ra = 0, rb = 0, rc = 0, rd = 0;
#pragma omp simd aligned(a, b, t : 64) reduction(+ : ra, rb, rc, rd)
        for (int i = 0; i < width; ++i)
        {
            ra += lowOf(a[i]) * t[i];
            rb += highOf(a[i]) * t[i];
            rc += lowOf(b[i]) * t[i];
            rd += highOf(b[i]) * t[i];
        }
        r[l] += scale[l] * ra;
        r[l + 1] += scale[l + 1] * rb;
        r[l + 2] += scale[l + 2] * rc;
        r[l + 3] += scale[l + 3] * rd;
    }
    if (l < n)
    {
        const std::int32_t* a = J + width * (l / 2);
        float ra = 0, rb = 0;
#pragma omp simd aligned(a, t : 64) reduction(+ : ra, rb)
        for (int i = 0; i < width; ++i)
        {
            ra += lowOf(a[i]) * t[i];
            rb += highOf(a[i]) * t[i];
        }
        r[l] += scale[l] * ra;
        r[l + 1] += scale[l + 1] * rb;
    }
}

void turn(int width, const float* root, const float* t, float limit, float* qRe, float* qIm)
{
    constexpr float kTurns = 0.15915494309f;
    width &= ~(kLanes - 1);
#pragma omp simd aligned(root, t, qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float angle = std::min(std::max(root[i] * t[i], -limit), limit);
        float sine = 0.0f, cosine = 0.0f;
        sinCosTurns(angle * kTurns, sine, cosine);
        const float x = qRe[i], y = qIm[i];
        qRe[i] = x * cosine - y * sine;
        qIm[i] = x * sine + y * cosine;
    }
}

} // namespace midair::haptics::kernels::MIDAIR_SET
