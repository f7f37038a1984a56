#include "haptics/PropagationKernels.h"

#include "haptics/KernelTools.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels
{

namespace
{

struct CubicModel
{
    DirectivityCubic D;
    MIDAIR_INLINE float operator()(float x) const
    {
        const float value = D.c0 + x * (D.c1 + x * (D.c2 + x * D.c3));
        return value > 0.0f ? value : 0.0f;
    }
};

struct PointModel
{
    MIDAIR_INLINE float operator()(float) const { return 1.0f; }
};

// log2 D is linear in theta between the table's angles: a sum of hinges, without the gathers that a look-up would take.
struct TableModel
{
    DirectivityTable table;
    MIDAIR_INLINE float operator()(float x) const
    {
        // acos(x) = sqrt(1 - x) P(x), 0 <= x <= 1, minimax, 2e-8; then in steps of ten degrees.
        const float y = std::min(std::max(x, 0.0f), 1.0f);
        float P = -0.00126276826f;
        P = P * y + 0.00667108375f;
        P = P * y - 0.0170895386f;
        P = P * y + 0.0308928811f;
        P = P * y - 0.0501746613f;
        P = P * y + 0.0889790425f;
        P = P * y - 0.214598804f;
        P = P * y + 1.57079630f;
        const float step = std::sqrt(1.0f - y) * P * 5.7295779513f;
        float t = table.start + step * table.bend[0];
        for (int k = 1; k < DirectivityTable::kSteps; ++k)
            t += table.bend[k] * std::max(0.0f, step - static_cast<float>(k));
        // 2^t = (2^(t/4))^4 with a minimax polynomial for -0.65 <= t/4 <= 0, 7e-9.
        float e = 1.041982288e-06f;
        e = e * t + 3.684179282e-05f;
        e = e * t + 0.0008662909306f;
        e = e * t + 0.01501357995f;
        e = e * t + 0.1732866681f;
        e = e * t + 0.9999999955f;
        e *= e;
        return x < 0.0f ? 0.0f : e * e;
    }
};

// G_li = strength_i D / R exp(-beta R) exp(j 2 pi (offset_i - R)), R in wavelengths (see PropagationMatrix.h).
// The phase needs R to 1e-7 of a wavelength at 60 wavelengths, more than a float holds. So, with d = hi + lo and c the
// cross terms, R^2 = A + c where A = |d_hi|^2 is exact (multiples of 1/1024 below 2^24/1024); s = fl(sqrt(A + c));
// sHi = s rounded to 1/32, so that A - sHi^2 is exact too; and the rest is small:
//     R - sHi = (s - sHi) + (A - sHi^2 + c - (s - sHi)(s + sHi)) / (R + s),  R + s = 2 s.
template<bool kWithOffset, typename Model>
MIDAIR_INLINE float
buildRow(const BlockGeometry& block, const PointSetup& point, Model D, float* re, float* im)
{
    const int width = block.width & ~(kLanes - 1);
    const float *xHi = block.xHi, *yHi = block.yHi, *zHi = block.zHi;
    const float *xLo = block.xLo, *yLo = block.yLo, *zLo = block.zLo;
    const float *nx = block.nx, *ny = block.ny, *nz = block.nz;
    const float *strength = block.strength, *offset = block.offset_turns;
    const PointSetup p = point;
    // In three loops: a single one is a chain of some 120 cycles, longer than what a core looks ahead.
    alignas(64) float turns[kMaxWidth], distance[kMaxWidth], inverses[kMaxWidth],
        cosines[kMaxWidth];
#pragma omp simd aligned(xHi, yHi, zHi, xLo, yLo, zLo, nx, ny, nz : 64)
    for (int i = 0; i < width; ++i)
    {
        const float hx = p.xHi - xHi[i], hy = p.yHi - yHi[i], hz = p.zHi - zHi[i];
        const float lx = p.xLo - xLo[i], ly = p.yLo - yLo[i], lz = p.zLo - zLo[i];
        const float dx = hx + lx, dy = hy + ly, dz = hz + lz;
        const float A = hx * hx + hy * hy + hz * hz;
        const float c = lx * (hx + dx) + ly * (hy + dy) + lz * (hz + dz);
        const float s = std::sqrt(A + c);
        const float sHi = roundToMultiple(s, kTo32nd);
        turns[i] = roundToMultiple(sHi, kToInteger) - s;
        inverses[i] = ((A - sHi * sHi) + c) - (s - sHi) * (s + sHi);
        distance[i] = s;
        cosines[i] = nx[i] * dx + ny[i] * dy + nz[i] * dz;
    }
    float sum = 0.0f;
#pragma omp simd aligned(strength : 64) reduction(+ : sum)
    for (int i = 0; i < width; ++i)
    {
        const float inverse = 1.0f / distance[i];
        turns[i] -= 0.5f * inverses[i] * inverse;
        const float x = p.middle - distance[i];
        const float attenuation =
            p.attenuation[0] +
            x * (p.attenuation[1] + x * (p.attenuation[2] + x * p.attenuation[3]));
        const float a = (strength[i] * inverse) * (attenuation * D(cosines[i] * inverse));
        cosines[i] = a;
        sum += std::fabs(a);
    }
#pragma omp simd aligned(re, im : 64)
    for (int i = 0; i < width; ++i)
    {
        float f = turns[i];
        if constexpr (kWithOffset)
        {
            f += offset[i];
            f -= roundToMultiple(f, kToInteger);
        }
        float sine, cosine;
        sinCosTurns(f, sine, cosine);
        re[i] = cosines[i] * cosine;
        im[i] = cosines[i] * sine;
    }
    return sum;
}

template<typename Model>
MIDAIR_INLINE float
buildAny(const BlockGeometry& block, const PointSetup& point, Model D, float* re, float* im)
{
    return block.offset_turns ? buildRow<true>(block, point, D, re, im)
                              : buildRow<false>(block, point, D, re, im);
}

} // namespace

const char* isaName()
{
#ifdef MIDAIR_HAS_CLONES
    if (__builtin_cpu_supports("x86-64-v4")) return "AVX-512";
    if (__builtin_cpu_supports("x86-64-v3")) return "AVX2";
    return "x86-64";
#else
    return "generic";
#endif
}

MIDAIR_CLONES
float buildCubic(const BlockGeometry& block,
                 const PointSetup& point,
                 const DirectivityCubic& D,
                 float* re,
                 float* im)
{
    return buildAny(block, point, CubicModel{D}, re, im);
}

MIDAIR_CLONES
float buildTable(const BlockGeometry& block,
                 const PointSetup& point,
                 const DirectivityTable& D,
                 float* re,
                 float* im)
{
    return buildAny(block, point, TableModel{D}, re, im);
}

MIDAIR_CLONES
float buildPoint(const BlockGeometry& block, const PointSetup& point, float* re, float* im)
{
    return buildAny(block, point, PointModel{}, re, im);
}

// Four rows at a time, so that z is loaded and stored once for four rows of G.
MIDAIR_CLONES
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
            x += a[i] * ar + a[i + width] * ai;
            y += a[i] * ai - a[i + width] * ar;
            x += b[i] * br + b[i + width] * bi;
            y += b[i] * bi - b[i + width] * br;
            x += c[i] * cr + c[i + width] * ci;
            y += c[i] * ci - c[i + width] * cr;
            x += d[i] * dr + d[i + width] * di;
            y += d[i] * di - d[i + width] * dr;
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
            zRe[i] += a[i] * ar + a[i + width] * ai;
            zIm[i] += a[i] * ai - a[i + width] * ar;
        }
    }
}

MIDAIR_CLONES
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

} // namespace midair::haptics::kernels
