#pragma once

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels
{

// A batch's points seen from the centre of a group. With r0 the vector from the centre, R0 = |r0|,
// and d a transducer's position relative to the centre,
//     R^2 = R0^2 + e,  e = |d|^2 - 2 r0.d,  R = R0 + e / (R + R0).
// In exact rows R0 is computed in double and only its fraction of a wavelength is kept, so the
// phase is as exact as a float holds e / (R + R0), which is at most |d|: a few 1e-7 wavelengths for
// groups of a few wavelengths. A float could not hold R itself (60 wavelengths) to 1e-6.
struct Expansion
{
    alignas(64) float ax[PointBatch::kSize], ay[PointBatch::kSize], az[PointBatch::kSize]; // -2 r0
    alignas(64) float square[PointBatch::kSize], distance[PointBatch::kSize]; // R0^2, R0
    alignas(64) float turns[PointBatch::kSize];   // -R0 without whole turns; of exact rows
    alignas(64) float decayed[PointBatch::kSize]; // exp(-decay R0), in units of the row
    alignas(64) float slope[PointBatch::kSize]; // first derivative of decayed, and half the second
    alignas(64) float bend[PointBatch::kSize];
    alignas(64) float height[PointBatch::kSize];    // n.r0
    alignas(64) float magnitude[PointBatch::kSize]; // a bound of |G_li| / D, Pa
};

template<bool kExact>
MIDAIR_INLINE void
expand(const GroupGeometry& group, const PointBatch& points, float decay, Expansion& out)
{
    // Wavelengths; the matrix passes no points that are nearer to a transducer.
    constexpr float kNearest = 0.25f;
    const GroupGeometry g = group;
    const float planar = g.planar ? 1.0f : 0.0f;
#pragma omp simd
    for (int k = 0; k < PointBatch::kSize; ++k)
    {
        // Differences in double: a float holds a place in the array less exactly.
        const double x = points.x[k] - g.x, y = points.y[k] - g.y, z = points.z[k] - g.z;
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y),
                   fz = static_cast<float>(z);
        float square = fx * fx + fy * fy + fz * fz, R = 0.0f;
        if constexpr (kExact)
        {
            const double exact = x * x + y * y + z * z;
            const double distance = std::sqrt(exact);
            square = static_cast<float>(exact);
            R = static_cast<float>(distance);
            out.turns[k] = static_cast<float>(rounded(distance) - distance);
        }
        else
            R = std::sqrt(square);
        out.ax[k] = -2.0f * fx;
        out.ay[k] = -2.0f * fy;
        out.az[k] = -2.0f * fz;
        out.square[k] = square;
        out.distance[k] = R;
        out.decayed[k] = expOfMinus(decay * R);
        const float height = g.nx * fx + g.ny * fy + g.nz * fz;
        out.height[k] = height;
        const float nearest =
            std::max(std::max(R - g.radius, planar * std::fabs(height)), kNearest);
        out.magnitude[k] = out.decayed[k] * g.strongest * (1.0f + g.radius * decay) / nearest;
    }
}

// Computes the units of the batch's rows, for which all entries fit if they are in fixed point, and
// the groups' attenuations in these units.
MIDAIR_INLINE void
scale(bool isFixed, float largestD, float decay, int groups, Expansion* at, float* units)
{
    alignas(64) float level[PointBatch::kSize] = {};
    for (int g = 0; g < groups; ++g)
    {
#pragma omp simd
        for (int k = 0; k < PointBatch::kSize; ++k)
            level[k] = std::max(level[k], at[g].magnitude[k]);
    }
#pragma omp simd
    for (int k = 0; k < PointBatch::kSize; ++k)
    {
        const float bound = std::max(1.002f * largestD * level[k], 1e-30f);
        units[k] = isFixed ? bound * (1.0f / kFixedPeak) : 1.0f;
        level[k] = 1.0f / units[k];
    }
    for (int g = 0; g < groups; ++g)
#pragma omp simd
        for (int k = 0; k < PointBatch::kSize; ++k)
        {
            const float c0 = level[k] * at[g].decayed[k];
            at[g].decayed[k] = c0;
            at[g].slope[k] = -decay * c0;
            at[g].bend[k] = 0.5f * decay * decay * c0;
        }
}

} // namespace midair::haptics::kernels
