#include "haptics/propagation/kernels/ReflectionKernels.h"

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/SheetShares.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

// The version of this set, in IntrinsicKernels.cpp.
void inverseRoots(int count, const float* x, float* inverse);

namespace
{

constexpr int kAtOnce = 4 * kGroup; // lanes whose intermediate numbers stay in the nearest cache

// 1/r of the paths of a group's transducers by way of the plane.
MIDAIR_INLINE void
inversePaths(const SheetLanes& lanes, int first, const SheetPoint& point, float* inverse)
{
    const float *height = lanes.height + first, *along = lanes.along + first,
                *across = lanes.across + first;
    const float b = std::fabs(point.height), x = point.along, y = point.across;
    alignas(64) float square[kGroup];
#pragma omp simd aligned(height, along, across, square : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        const float up = std::max(std::fabs(height[i]) + b, kLeastUp);
        const float du = x - along[i], dv = y - across[i];
        square[i] = up * up + dv * dv + du * du;
    }
    inverseRoots(kGroup, square, inverse);
}

} // namespace

void sharesTurned(
    int width, const SheetView& sheet, const SheetPoint& point, float* shareRe, float* shareIm)
{
    alignas(64) float inverse[kGroup], inverseA[kGroup];
    Edges edges;
    SideShares sides;
    for (int first = 0; first < width; first += kGroup)
    {
        inversePaths(sheet.lanes, first, point, inverse);
        inverseHeights(sheet, first, inverseA);
        findEdges(sheet, first, point, inverseA, inverse, edges);
        sharesOfSides(edges, sides);
        float *re = shareRe + first, *im = shareIm + first;
#pragma omp simd aligned(re, im : 64)
        for (int i = 0; i < kGroup; ++i)
        {
            re[i] = sides.re[0][i] * sides.re[1][i] - sides.im[0][i] * sides.im[1][i];
            im[i] = sides.re[0][i] * sides.im[1][i] + sides.im[0][i] * sides.re[1][i];
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
