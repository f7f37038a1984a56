#include "haptics/propagation/kernels/ReflectionKernels.h"

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

// The version of this set, in IntrinsicKernels.cpp.
void inverseRoots(int count, const float* x, float* inverse);

namespace
{

constexpr int kAtOnce = 4 * kGroup; // lanes whose intermediate numbers stay in the nearest cache

// In wavelengths; far below any distance that matters.
constexpr float kLeastUp = 1e-6F, kLeastArea = 1e-9F;

// Numbers of kAtOnce lanes that pass from loop to loop.
struct Lengths
{
    alignas(64) float up[kAtOnce];                       // a + b
    alignas(64) float square[kAtOnce], inverse[kAtOnce]; // r^2, 1/r
    alignas(64) float area[kAtOnce], areaRoot[kAtOnce];  // a b r, and its inverse root
    alignas(64) float inPlane[2][kAtOnce]; // up^2 and the square of the step along the other side
    alignas(64) float root[2][kAtOnce];    // its inverse root
    alignas(64) float middle[2][kAtOnce];  // (a + b) X.e
};

MIDAIR_INLINE void
measure(int first, int count, const SheetLanes& lanes, const SheetPoint& point, Lengths& s)
{
    const float *height = lanes.height + first, *along = lanes.along + first,
                *across = lanes.across + first;
    const float b = std::fabs(point.height), x = point.along, y = point.across;
#pragma omp simd aligned(height, along, across : 64)
    for (int i = 0; i < count; ++i)
    {
        const float a = std::fabs(height[i]), up = std::max(a + b, kLeastUp);
        const float du = x - along[i], dv = y - across[i];
        s.up[i] = up;
        s.inPlane[0][i] = up * up + dv * dv;
        s.inPlane[1][i] = up * up + du * du;
        s.square[i] = s.inPlane[0][i] + du * du;
        s.area[i] = std::max(a * b, kLeastArea);
        s.middle[0][i] = along[i] * b + x * a;
        s.middle[1][i] = across[i] * b + y * a;
    }
    inverseRoots(kAtOnce, s.square, s.inverse);
#pragma omp simd
    for (int i = 0; i < count; ++i)
        s.area[i] *= s.square[i] * s.inverse[i];
    inverseRoots(kAtOnce, s.area, s.areaRoot);
    inverseRoots(kAtOnce, s.inPlane[0], s.root[0]);
    inverseRoots(kAtOnce, s.inPlane[1], s.root[1]);
}

// v of the two edges across a side, limited, 1 + kBend |v| and its inverse root.
constexpr float kBend = 0.9F;
struct Edges
{
    alignas(64) float v[2][kAtOnce], bent[2][kAtOnce], root[2][kAtOnce];
};
MIDAIR_INLINE void findEdges(int count, int e, float half, const Lengths& s, Edges& edges)
{
#pragma omp simd
    for (int i = 0; i < count; ++i)
    {
        // sqrt(2 inPlane / (a b r^3))
        const float scale =
            1.41421356F * s.inPlane[e][i] * s.root[e][i] * s.inverse[i] * s.areaRoot[i];
        const float reach = half * s.up[i];
        const float low =
            std::min(std::max((-reach - s.middle[e][i]) * scale, -kFarthestEdge), kFarthestEdge);
        const float high =
            std::min(std::max((reach - s.middle[e][i]) * scale, -kFarthestEdge), kFarthestEdge);
        edges.v[0][i] = low;
        edges.v[1][i] = high;
        edges.bent[0][i] = 1.0F + kBend * std::fabs(low);
        edges.bent[1][i] = 1.0F + kBend * std::fabs(high);
    }
    inverseRoots(2 * kAtOnce, edges.bent[0], edges.root[0]);
}

// The part E = 1 - F(|v|) = (P - j Q) exp(-j pi v^2/2) that is left beyond an edge. With
// t = 1/(1 + kBend |v|) P/t and Q/t are polynomials in 2 t - 1, minimax over all v: 9e-6.
MIDAIR_INLINE void leftBeyond(float v, float root, float& re, float& im)
{
    const float t = root * root, u = 2.0F * t - 1.0F;
    float P = 0.0185196745F;
    P = P * u - 0.00255406234F;
    P = P * u - 0.0785070755F;
    P = P * u + 0.0281763925F;
    P = P * u + 0.142388645F;
    P = P * u - 0.0680466039F;
    P = P * u - 0.191318297F;
    P = P * u + 0.0552099322F;
    P = P * u + 0.286814425F;
    P = P * u + 0.30932577F;
    float Q = -0.0123029142F;
    Q = Q * u + 0.0391833673F;
    Q = Q * u + 0.00650676254F;
    Q = Q * u - 0.112832966F;
    Q = Q * u + 0.0402254598F;
    Q = Q * u + 0.166518133F;
    Q = Q * u - 0.0742220713F;
    Q = Q * u - 0.230150086F;
    Q = Q * u - 0.0325028367F;
    Q = Q * u + 0.209585947F;
    const float amplitude = std::fabs(v) < kFarthestEdge ? t : 0.0F;
    P *= amplitude;
    Q *= amplitude;
    const float turns = 0.25F * v * v;
    float sine = 0.0F, cosine = 0.0F;
    sinCosTurns(turns - rounded(turns), sine, cosine);
    re = P * cosine - Q * sine;
    im = -Q * cosine - P * sine;
}

// F(high) - F(low). Where both are beyond the same edge, 1 is not added and taken off again.
MIDAIR_INLINE void
between(float low, float high, float rootLow, float rootHigh, float& re, float& im)
{
    float lowRe = 0.0F, lowIm = 0.0F, highRe = 0.0F, highIm = 0.0F;
    leftBeyond(low, rootLow, lowRe, lowIm);
    leftBeyond(high, rootHigh, highRe, highIm);
    const float whole = (high >= 0.0F ? 1.0F : 0.0F) - (low >= 0.0F ? 1.0F : 0.0F);
    const float signHigh = high >= 0.0F ? -1.0F : 1.0F, signLow = low >= 0.0F ? -1.0F : 1.0F;
    re = whole + (signHigh * highRe - signLow * lowRe);
    im = signHigh * highIm - signLow * lowIm;
}

} // namespace

void sharesTurned(int width,
                  float halfAlong,
                  float halfAcross,
                  const SheetLanes& lanes,
                  const SheetPoint& point,
                  float* shareRe,
                  float* shareIm)
{
    Lengths s;
    Edges at;
    for (float* all : {s.square, s.area, s.inPlane[0], s.inPlane[1], at.bent[0], at.bent[1]})
        std::fill_n(all, kAtOnce, 1.0F);
    for (int first = 0; first < width; first += kAtOnce)
    {
        const int count = std::min(kAtOnce, width - first);
        measure(first, count, lanes, point, s);
        float *re = shareRe + first, *im = shareIm + first;
        findEdges(count, 0, halfAlong, s, at);
#pragma omp simd aligned(re, im : 64)
        for (int i = 0; i < count; ++i)
            between(at.v[0][i], at.v[1][i], at.root[0][i], at.root[1][i], re[i], im[i]);
        findEdges(count, 1, halfAcross, s, at);
#pragma omp simd aligned(re, im : 64)
        for (int i = 0; i < count; ++i)
        {
            float x = 0.0F, y = 0.0F;
            between(at.v[0][i], at.v[1][i], at.root[0][i], at.root[1][i], x, y);
            const float along = re[i];
            re[i] = along * x - im[i] * y;
            im[i] = along * y + im[i] * x;
        }
    }
}

void reflect(int width, float height, const SheetFactor& factor, const Waves& row)
{
    const float side = height >= 0.0F ? 1.0F : -1.0F, reflection = factor.reflection;
    const float factorRe = factor.re, factorIm = factor.im;
    const float *heights = row.heights, *imageRe = row.imageRe, *imageIm = row.imageIm;
    float *directRe = row.directRe, *directIm = row.directIm;
    float *reflectedRe = row.reflectedRe, *reflectedIm = row.reflectedIm;
#pragma omp simd aligned(heights, imageRe, imageIm, directRe, directIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float beside = heights[i] * side > 0.0F ? 1.0F : 0.0F;
        const float re = beside * imageRe[i], im = beside * imageIm[i];
        const float passes = 1.0F - (heights[i] * side < 0.0F ? reflection : 0.0F);
        directRe[i] *= passes;
        directIm[i] *= passes;
        reflectedRe[i] += factorRe * re - factorIm * im;
        reflectedIm[i] += factorRe * im + factorIm * re;
    }
}

void reflect(int width,
             float height,
             const SheetFactor& factor,
             const float* shareRe,
             const float* shareIm,
             const Waves& row)
{
    const float side = height >= 0.0F ? 1.0F : -1.0F;
    const float factorRe = factor.re, factorIm = factor.im, reflection = factor.reflection;
    const float *heights = row.heights, *imageRe = row.imageRe, *imageIm = row.imageIm;
    float *directRe = row.directRe, *directIm = row.directIm;
    float *reflectedRe = row.reflectedRe, *reflectedIm = row.reflectedIm;
#pragma omp simd aligned(heights, shareRe, shareIm, imageRe, imageIm, directRe, directIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float beside = heights[i] * side > 0.0F ? 1.0F : 0.0F;
        const float taken = heights[i] * side < 0.0F ? reflection : 0.0F;
        const float x = shareRe[i], y = shareIm[i];
        const float passRe = 1.0F - taken * x, passIm = -taken * y;
        const float directX = directRe[i], directY = directIm[i];
        directRe[i] = passRe * directX - passIm * directY;
        directIm[i] = passRe * directY + passIm * directX;
        const float re = beside * imageRe[i], im = beside * imageIm[i];
        const float turnedRe = factorRe * x - factorIm * y, turnedIm = factorRe * y + factorIm * x;
        reflectedRe[i] += turnedRe * re - turnedIm * im;
        reflectedIm[i] += turnedRe * im + turnedIm * re;
    }
}

float joinWaves(int width, const float* reflectedRe, const float* reflectedIm, float* re, float* im)
{
    alignas(64) float square[kAtOnce], inverse[kAtOnce];
    std::fill_n(square, kAtOnce, 1.0F);
    float sum = 0.0F;
    for (int first = 0; first < width; first += kAtOnce)
    {
        const int count = std::min(kAtOnce, width - first);
        float *x = re + first, *y = im + first;
        const float *dx = reflectedRe + first, *dy = reflectedIm + first;
#pragma omp simd aligned(x, y, dx, dy : 64)
        for (int i = 0; i < count; ++i)
        {
            const float a = x[i] + dx[i], b = y[i] + dy[i];
            x[i] = a;
            y[i] = b;
            square[i] = std::max(a * a + b * b, 1e-30F);
        }
        inverseRoots(kAtOnce, square, inverse);
#pragma omp simd reduction(+ : sum)
        for (int i = 0; i < count; ++i)
            sum += square[i] * inverse[i];
    }
    return sum;
}

} // namespace midair::haptics::kernels::MIDAIR_SET
