#include "haptics/KernelTools.h"
#include "haptics/PropagationKernels.h"

#include <algorithm>

namespace midair::haptics::kernels
{

MIDAIR_CLONES
void formJacobian(const float* G,
                  int n,
                  int width,
                  const float* uRe,
                  const float* uIm,
                  const float* scale,
                  const float* qRe,
                  const float* qIm,
                  const float* root,
                  float* J)
{
    width &= ~(kLanes - 1);
    alignas(64) float re[kMaxWidth], im[kMaxWidth];
#pragma omp simd aligned(qRe, qIm, root : 64)
    for (int i = 0; i < width; ++i)
    {
        re[i] = qRe[i] * root[i];
        im[i] = qIm[i] * root[i];
    }
    for (int l = 0; l < n; ++l)
    {
        const float *gRe = G + 2 * width * l, *gIm = gRe + width;
        float* row = J + width * l;
        const float ur = uRe[l] * scale[l], ui = uIm[l] * scale[l];
#pragma omp simd aligned(gRe, gIm, row : 64)
        for (int i = 0; i < width; ++i)
            row[i] = gRe[i] * (ui * re[i] - ur * im[i]) - gIm[i] * (ur * re[i] + ui * im[i]);
    }
}

MIDAIR_CLONES
void transposedJacobian(const float* J, int n, int width, const float* x, float* t)
{
    width &= ~(kLanes - 1);
    std::fill(t, t + width, 0.0f);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const float *a = J + width * l, *b = a + width, *c = b + width, *d = c + width;
        const float xa = x[l], xb = x[l + 1], xc = x[l + 2], xd = x[l + 3];
#pragma omp simd aligned(a, b, c, d, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += (a[i] * xa + b[i] * xb) + (c[i] * xc + d[i] * xd);
    }
    for (; l < n; ++l)
    {
        const float* a = J + width * l;
        const float xa = x[l];
#pragma omp simd aligned(a, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += a[i] * xa;
    }
}

MIDAIR_CLONES
void applyJacobian(const float* J, int n, int width, const float* t, float* r)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const float *a = J + width * l, *b = a + width, *c = b + width, *d = c + width;
        float ra = 0, rb = 0, rc = 0, rd = 0;
#pragma omp simd aligned(a, b, c, d, t : 64) reduction(+ : ra, rb, rc, rd)
        for (int i = 0; i < width; ++i)
        {
            ra += a[i] * t[i];
            rb += b[i] * t[i];
            rc += c[i] * t[i];
            rd += d[i] * t[i];
        }
        r[l] += ra;
        r[l + 1] += rb;
        r[l + 2] += rc;
        r[l + 3] += rd;
    }
    for (; l < n; ++l)
    {
        const float* a = J + width * l;
        float ra = 0;
#pragma omp simd aligned(a, t : 64) reduction(+ : ra)
        for (int i = 0; i < width; ++i)
            ra += a[i] * t[i];
        r[l] += ra;
    }
}

MIDAIR_CLONES
void turn(int width, const float* root, const float* t, float limit, float* qRe, float* qIm)
{
    constexpr float kTurns = 0.15915494309f;
    width &= ~(kLanes - 1);
#pragma omp simd aligned(root, t, qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float angle = std::min(std::max(root[i] * t[i], -limit), limit);
        float sine, cosine;
        sinCosTurns(angle * kTurns, sine, cosine);
        const float x = qRe[i], y = qIm[i];
        qRe[i] = x * cosine - y * sine;
        qIm[i] = x * sine + y * cosine;
    }
}

} // namespace midair::haptics::kernels
