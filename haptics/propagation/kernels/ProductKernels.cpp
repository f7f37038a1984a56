// Products with G, whose rows are in float or in fixed point.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>

namespace midair::haptics::kernels::MIDAIR_SET
{

float packRow(int width, const float* re, const float* im, std::int32_t* row)
{
    width &= ~(kLanes - 1);
    float peak = 0.0f;
#pragma omp simd aligned(re, im : 64) reduction(max : peak)
    for (int i = 0; i < width; ++i)
        peak = std::max(peak, std::max(std::fabs(re[i]), std::fabs(im[i])));
    const float perUnit = peak > 0.0f ? kFixedPeak / peak : 0.0f;
#pragma omp simd aligned(re, im, row : 64)
    for (int i = 0; i < width; ++i)
        row[i] = packPair(re[i] * perUnit, im[i] * perUnit);
    return fixedScale(peak);
}

// Four rows at a time, so that z is loaded and stored once for four rows of G.
void backward(
    const float* G, int n, int width, const float* wRe, const float* wIm, float* zRe, float* zIm)
{
    width &= ~(kLanes - 1);
    std::fill(zRe, zRe + width, 0.0f);
    std::fill(zIm, zIm + width, 0.0f);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const float *a = G + 2 * width * l, *b = a + 2 * width, *c = b + 2 * width,
                    *d = c + 2 * width;
        const float ar = wRe[l], br = wRe[l + 1], cr = wRe[l + 2], dr = wRe[l + 3];
        const float ai = wIm[l], bi = wIm[l + 1], ci = wIm[l + 2], di = wIm[l + 3];
#pragma omp simd aligned(a, b, c, d, zRe, zIm : 64)
        for (int i = 0; i < width; ++i)
        {
            float x = zRe[i], y = zIm[i];
            x += a[i] * ar;
            x += a[i + width] * ai;
            y += a[i] * ai;
            y -= a[i + width] * ar;
            x += b[i] * br;
            x += b[i + width] * bi;
            y += b[i] * bi;
            y -= b[i + width] * br;
            x += c[i] * cr;
            x += c[i + width] * ci;
            y += c[i] * ci;
            y -= c[i + width] * cr;
            x += d[i] * dr;
            x += d[i + width] * di;
            y += d[i] * di;
            y -= d[i + width] * dr;
            zRe[i] = x;
            zIm[i] = y;
        }
    }
    for (; l < n; ++l)
    {
        const float* a = G + 2 * width * l;
        const float ar = wRe[l], ai = wIm[l];
#pragma omp simd aligned(a, zRe, zIm : 64)
        for (int i = 0; i < width; ++i)
        {
            zRe[i] += a[i] * ar;
            zRe[i] += a[i + width] * ai;
            zIm[i] += a[i] * ai;
            zIm[i] -= a[i + width] * ar;
        }
    }
}

void forward(
    const float* G, int n, int width, const float* qRe, const float* qIm, float* pRe, float* pIm)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 2 <= n; l += 2)
    {
        const float *a = G + 2 * width * l, *b = a + 2 * width;
        float ar = 0, ai = 0, br = 0, bi = 0;
#pragma omp simd aligned(a, b, qRe, qIm : 64) reduction(+ : ar, ai, br, bi)
        for (int i = 0; i < width; ++i)
        {
            const float x = qRe[i], y = qIm[i];
            ar += a[i] * x - a[i + width] * y;
            ai += a[i] * y + a[i + width] * x;
            br += b[i] * x - b[i + width] * y;
            bi += b[i] * y + b[i + width] * x;
        }
        pRe[l] += ar;
        pIm[l] += ai;
        pRe[l + 1] += br;
        pIm[l + 1] += bi;
    }
    if (l < n)
    {
        const float* a = G + 2 * width * l;
        float ar = 0, ai = 0;
#pragma omp simd aligned(a, qRe, qIm : 64) reduction(+ : ar, ai)
        for (int i = 0; i < width; ++i)
        {
            ar += a[i] * qRe[i] - a[i + width] * qIm[i];
            ai += a[i] * qIm[i] + a[i + width] * qRe[i];
        }
        pRe[l] += ar;
        pIm[l] += ai;
    }
}

void backward(const std::int32_t* G,
              const float* scale,
              int n,
              int width,
              const float* wRe,
              const float* wIm,
              float* zRe,
              float* zIm)
{
    width &= ~(kLanes - 1);
    std::fill(zRe, zRe + width, 0.0f);
    std::fill(zIm, zIm + width, 0.0f);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = G + width * l, *b = a + width, *c = b + width, *d = c + width;
        const float ar = wRe[l] * scale[l], br = wRe[l + 1] * scale[l + 1],
                    cr = wRe[l + 2] * scale[l + 2], dr = wRe[l + 3] * scale[l + 3];
        const float ai = wIm[l] * scale[l], bi = wIm[l + 1] * scale[l + 1],
                    ci = wIm[l + 2] * scale[l + 2], di = wIm[l + 3] * scale[l + 3];
#pragma omp simd aligned(a, b, c, d, zRe, zIm : 64)
        for (int i = 0; i < width; ++i)
        {
            float x = zRe[i], y = zIm[i];
            x += lowOf(a[i]) * ar;
            x += highOf(a[i]) * ai;
            y += lowOf(a[i]) * ai;
            y -= highOf(a[i]) * ar;
            x += lowOf(b[i]) * br;
            x += highOf(b[i]) * bi;
            y += lowOf(b[i]) * bi;
            y -= highOf(b[i]) * br;
            x += lowOf(c[i]) * cr;
            x += highOf(c[i]) * ci;
            y += lowOf(c[i]) * ci;
            y -= highOf(c[i]) * cr;
            x += lowOf(d[i]) * dr;
            x += highOf(d[i]) * di;
            y += lowOf(d[i]) * di;
            y -= highOf(d[i]) * dr;
            zRe[i] = x;
            zIm[i] = y;
        }
    }
    for (; l < n; ++l)
    {
        const std::int32_t* a = G + width * l;
        const float ar = wRe[l] * scale[l], ai = wIm[l] * scale[l];
#pragma omp simd aligned(a, zRe, zIm : 64)
        for (int i = 0; i < width; ++i)
        {
            zRe[i] += lowOf(a[i]) * ar;
            zRe[i] += highOf(a[i]) * ai;
            zIm[i] += lowOf(a[i]) * ai;
            zIm[i] -= highOf(a[i]) * ar;
        }
    }
}

} // namespace midair::haptics::kernels::MIDAIR_SET
