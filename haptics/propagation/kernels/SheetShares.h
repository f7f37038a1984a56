#pragma once

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/ReflectionKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels
{

// Shares of a wave that a rectangle turns (haptics::shareTurned), for the transducers of a group:
//     w = prod_e [F(v_e+) - F(v_e-)].
// With nu = v / sqrt(2), what is left beyond an edge is
//     1 - F(|v|) = A(|nu|) exp(-j pi (nu^2 + B(|nu|)))
// with amplitude and phase of the auxiliary functions of Fresnel integrals (Abramowitz, Stegun
// 7.3), which are slow and need few terms.

// In wavelengths; far below any distance that matters.
constexpr float kLeastUp = 1e-6F, kLeastArea = 1e-9F;

// From here on, in units of nu, three terms of A and B suffice.
constexpr float kFarEdge = 1.23743687F; // 1.75 / sqrt(2)
constexpr float kInverseRootOfTwo = 0.707106781F;

// Edges of the two sides of a rectangle as the transducers of a group see them. The nearer edge of
// a side counts as its upper one, which changes nothing because F(h) - F(l) = F(-l) - F(-h): the
// share of a side is F(near) - F(-far).
struct Edges
{
    alignas(64) float near[2][kGroup], far[2][kGroup]; // nu, far >= |near|
    float nearest[2], farthest[2];                     // the least |near| and the largest far
};

// Share of each side; the whole one is their product.
struct SideShares
{
    alignas(64) float re[2][kGroup], im[2][kGroup];
};

// 1/a of the transducers of a group, those from the  first-th lane on.
constexpr float kLeastHeight = 1e-12F;
MIDAIR_INLINE void inverseHeights(const SheetView& sheet, int first, float* inverse)
{
    const float* height = sheet.lanes.height + first;
#pragma omp simd aligned(height, inverse : 64)
    for (int i = 0; i < kGroup; ++i)
        inverse[i] = 1.0F / std::max(std::fabs(height[i]), kLeastHeight);
}

// inverse: 1 / r of the paths.
MIDAIR_INLINE void findEdges(const SheetView& sheet,
                             int first,
                             const SheetPoint& point,
                             const float* inverseA,
                             const float* inverse,
                             Edges& edges)
{
    const float *height = sheet.lanes.height + first, *along = sheet.lanes.along + first,
                *across = sheet.lanes.across + first;
    const float halfAlong = sheet.halfAlong, halfAcross = sheet.halfAcross;
    const float b = std::fabs(point.height), x = point.along, y = point.across;
    const float inverseB = 1.0F / std::max(b, kLeastHeight);
    float *near0 = edges.near[0], *far0 = edges.far[0];
    float *near1 = edges.near[1], *far1 = edges.far[1];
    float nearest0 = 1e30F, nearest1 = 1e30F, farthest0 = 0.0F, farthest1 = 0.0F;
#pragma omp simd aligned(height, along, across, inverseA, inverse, near0, far0, near1, far1 : 64)  \
    reduction(min                                                                                  \
              : nearest0, nearest1) reduction(max                                                  \
                                              : farthest0, farthest1)
    for (int i = 0; i < kGroup; ++i)
    {
        const float a = std::fabs(height[i]), up = std::max(a + b, kLeastUp);
        const float du = x - along[i], dv = y - across[i];
        // nu / ((a + b) (h_e - X.e)) = sqrt(inPlane / (a b r^3)), with inPlane the square of (a +
        // b) and of the step along the other side.
        const float part = inverse[i] * inverse[i] * inverse[i] *
                           std::min(inverseA[i] * inverseB, 1.0F / kLeastArea);
        const float scale0 = std::sqrt(part * (up * up + dv * dv));
        const float scale1 = std::sqrt(part * (up * up + du * du));
        const float middle0 = std::fabs(along[i] * b + x * a);
        const float middle1 = std::fabs(across[i] * b + y * a);
        const float n0 = (halfAlong * up - middle0) * scale0;
        const float n1 = (halfAcross * up - middle1) * scale1;
        const float f0 = (halfAlong * up + middle0) * scale0;
        const float f1 = (halfAcross * up + middle1) * scale1;
        near0[i] = n0;
        near1[i] = n1;
        far0[i] = f0;
        far1[i] = f1;
        nearest0 = std::min(nearest0, std::fabs(n0));
        nearest1 = std::min(nearest1, std::fabs(n1));
        farthest0 = std::max(farthest0, f0);
        farthest1 = std::max(farthest1, f1);
    }
    edges.nearest[0] = nearest0;
    edges.nearest[1] = nearest1;
    edges.farthest[0] = farthest0;
    edges.farthest[1] = farthest1;
}

// Takes the nearest whole number from \a halfTurns, up to 1e6; if it is odd, as the lowest bit of
// the shifted number says, \a amplitude changes its sign.
MIDAIR_INLINE void toOneHalfTurn(float& amplitude, float& halfTurns)
{
    const float shifted = halfTurns + kToInteger;
    halfTurns -= shifted - kToInteger;
    amplitude = withSign(amplitude, shifted);
}

// sign(nu) (1 - F(|v|)). Beyond kFarthestEdge it counts as 0. With w = 1 / nu or t = 1 / (1 +
// kBend |nu|) A/w and B are polynomials in w^2, A/t and B in 2 t - 1, minimax together: 1.7e-5 from
// kFarEdge on, or 8e-6 over all nu.
MIDAIR_INLINE float slowAmplitude(float w, float u)
{
    return w * (0.159291759F + u * (-0.00164126942F + u * -0.00570188137F));
}
MIDAIR_INLINE float slowPhase(float u)
{
    return 0.250124961F + u * (-0.0527894758F + u * 0.00981084071F);
}
constexpr float kBend = 0.777817459F;
MIDAIR_INLINE float anyAmplitude(float t, float u)
{
    float A = -0.0157522205F;
    A = A * u + 0.0106654707F;
    A = A * u + 0.0502381697F;
    A = A * u - 0.0218403507F;
    A = A * u - 0.089440152F;
    A = A * u - 0.0129650952F;
    A = A * u + 0.123613931F;
    A = A * u + 0.212474108F;
    A = A * u + 0.243000284F;
    return A * t;
}
MIDAIR_INLINE float anyPhase(float u)
{
    float B = 0.017617071F;
    B = B * u - 0.0229277071F;
    B = B * u - 0.0422055274F;
    B = B * u + 0.0553807057F;
    B = B * u + 0.0636795238F;
    B = B * u - 0.0598432608F;
    B = B * u - 0.134981811F;
    B = B * u - 0.0985114127F;
    B = B * u + 0.221790731F;
    return B;
}
constexpr float kMostSquare = 0.5F * kFarthestEdge * kFarthestEdge;
MIDAIR_INLINE void leftBeyond(float nu, float& amplitude, float& turns)
{
    const float t = 1.0F / (1.0F + kBend * std::fabs(nu)), u = 2.0F * t - 1.0F;
    const float square = nu * nu;
    amplitude = std::copysign(square < kMostSquare ? anyAmplitude(t, u) : 0.0F, nu);
    turns = std::min(square, kMostSquare) + anyPhase(u);
}

// What is left beyond both edges of a side, in at most one half turn.
struct LeftBeyond
{
    alignas(64) float amplitude[2][kGroup], halfTurns[2][kGroup];
};

MIDAIR_INLINE void leftBeyondFarEdges(const Edges& edges, int e, LeftBeyond& left)
{
    const float *near = edges.near[e], *far = edges.far[e];
    float *a0 = left.amplitude[0], *a1 = left.amplitude[1];
    float *t0 = left.halfTurns[0], *t1 = left.halfTurns[1];
#pragma omp simd aligned(near, far, a0, a1, t0, t1 : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        const float n = near[i], f = far[i], inverse = 1.0F / (n * f);
        const float w0 = inverse * f, w1 = inverse * n, u0 = w0 * w0, u1 = w1 * w1;
        float A0 = slowAmplitude(w0, u0), T0 = n * n + slowPhase(u0);
        float A1 = slowAmplitude(w1, u1), T1 = f * f + slowPhase(u1);
        toOneHalfTurn(A0, T0);
        toOneHalfTurn(A1, T1);
        a0[i] = A0;
        t0[i] = T0;
        a1[i] = A1;
        t1[i] = T1;
    }
}

MIDAIR_INLINE void leftBeyondAnyEdges(const float* nu, float* amplitude, float* halfTurns)
{
#pragma omp simd aligned(nu, amplitude, halfTurns : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        float A = 0.0F, T = 0.0F;
        leftBeyond(nu[i], A, T);
        toOneHalfTurn(A, T);
        amplitude[i] = A;
        halfTurns[i] = T;
    }
}

// F(v_e+) - F(v_e-) of one side, as H(near) - (1 - F(|near|)) sign(near) - (1 - F(far)): exact far
// outside, too.
MIDAIR_INLINE void shareOfSide(const Edges& edges, int e, SideShares& shares)
{
    LeftBeyond left;
    if (edges.nearest[e] >= kFarEdge && edges.farthest[e] <= kFarthestEdge * kInverseRootOfTwo)
        leftBeyondFarEdges(edges, e, left);
    else
    {
        leftBeyondAnyEdges(edges.near[e], left.amplitude[0], left.halfTurns[0]);
        leftBeyondAnyEdges(edges.far[e], left.amplitude[1], left.halfTurns[1]);
    }
    const float *near = edges.near[e], *a0 = left.amplitude[0], *a1 = left.amplitude[1],
                *t0 = left.halfTurns[0], *t1 = left.halfTurns[1];
    float *re = shares.re[e], *im = shares.im[e];
#pragma omp simd aligned(near, a0, a1, t0, t1, re, im : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        const float whole = 0.5F + std::copysign(0.5F, near[i]);
        re[i] = whole - (a0[i] * quickCosHalf(t0[i]) + a1[i] * quickCosHalf(t1[i]));
        im[i] = a0[i] * quickSinHalf(t0[i]) + a1[i] * quickSinHalf(t1[i]);
    }
}

MIDAIR_INLINE void sharesOfSides(const Edges& edges, SideShares& shares)
{
    for (int e = 0; e < 2; ++e)
        shareOfSide(edges, e, shares);
}

} // namespace midair::haptics::kernels
