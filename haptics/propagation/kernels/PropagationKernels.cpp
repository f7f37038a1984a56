#include "haptics/propagation/kernels/PropagationKernels.h"

#include "haptics/propagation/kernels/DirectivityModels.h"
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PointExpansion.h"
#include "haptics/propagation/kernels/Register.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

// The version of this set, in IntrinsicKernels.cpp.
void inverseRoots(int count, const float* x, float* inverse);

namespace
{

// Values of one group and the batch's points that pass from loop to loop, and sums of a block's
// amplitudes, lane by lane.
struct Scratch
{
    alignas(64) float excess[PointBatch::kSize][kGroup];  // e, then the phase in turns
    alignas(64) float square[PointBatch::kSize][kGroup];  // R^2, then the amplitude
    alignas(64) float inverse[PointBatch::kSize][kGroup]; // 1/R
    alignas(64) float sums[PointBatch::kSize][kGroup];
};

// Computes e and R^2 of a group's entries.
MIDAIR_INLINE void
squares(const BlockGeometry& block, const Expansion& at, int first, int points, Scratch& s)
{
    const float *x = block.x + first, *y = block.y + first, *z = block.z + first;
    const float* own = block.square + first;
    for (int k = 0; k < points; ++k)
    {
        const float ax = at.ax[k], ay = at.ay[k], az = at.az[k], square = at.square[k];
        float *excess = s.excess[k], *whole = s.square[k];
#pragma omp simd aligned(x, y, z, own, excess, whole : 64)
        for (int i = 0; i < kGroup; ++i)
        {
            const float e = own[i] + ax * x[i] + ay * y[i] + az * z[i];
            excess[i] = e;
            whole[i] = square + e;
        }
    }
}

// Computes amplitudes strength D / R exp(-beta R) level, and phases offset - R in turns, -1/2 ..
// 1/2.
template<bool kPlanar, bool kWithOffset, typename Model>
MIDAIR_INLINE void
waves(const BlockGeometry& block, const Expansion& at, int first, int points, Model D, Scratch& s)
{
    const float *x = block.x + first, *y = block.y + first, *z = block.z + first;
    const float *nx = block.nx + first, *ny = block.ny + first, *nz = block.nz + first;
    const float* strength = block.strength + first;
    for (int k = 0; k < points; ++k)
    {
        const float ax = at.ax[k], ay = at.ay[k], az = at.az[k], height = at.height[k];
        const float R0 = at.distance[k], base = at.turns[k];
        // exp(-decay (R - R0)) as a parabola, as decay * radius is small.
        const float c0 = at.decayed[k], c1 = at.slope[k], c2 = at.bend[k];
        float *excess = s.excess[k], *square = s.square[k], *sums = s.sums[k];
        const float* inverses = s.inverse[k];
#pragma omp simd aligned(x, y, z, nx, ny, nz, strength, excess, square, inverses, sums : 64)
        for (int i = 0; i < kGroup; ++i)
        {
            const float inverse = inverses[i];
            const float beyond = excess[i] / (square[i] * inverse + R0);
            float cosine = height * inverse;
            if constexpr (!kPlanar)
                cosine = -0.5f *
                         (nx[i] * (ax + 2.0f * x[i]) + ny[i] * (ay + 2.0f * y[i]) +
                          nz[i] * (az + 2.0f * z[i])) *
                         inverse;
            const float amplitude =
                (strength[i] * inverse) * ((c0 + beyond * (c1 + beyond * c2)) * D(cosine));
            square[i] = amplitude;
            sums[i] += std::fabs(amplitude);
            float f = base - beyond;
            if constexpr (kWithOffset) f += block.offset_turns[first + i];
            excess[i] = f - rounded(f);
        }
    }
}

struct FloatRow
{
    float *re, *im;
    MIDAIR_INLINE void put(int i, float x, float y) const
    {
        re[i] = x;
        im[i] = y;
    }
};

struct FixedRow
{
    std::int32_t* entries;
    MIDAIR_INLINE void put(int i, float x, float y) const { entries[i] = packPair(x, y); }
};

MIDAIR_INLINE FloatRow rowOf(const FloatRows& rows, int row, int width)
{
    float* re = rows.entries + 2L * width * row;
    return {re, re + width};
}
MIDAIR_INLINE FixedRow rowOf(const FixedRows& rows, int row, int width)
{
    return {rows.entries + 1L * width * row};
}
MIDAIR_INLINE constexpr bool isFixed(const FloatRows&)
{
    return false;
}
MIDAIR_INLINE constexpr bool isFixed(const FixedRows&)
{
    return true;
}
MIDAIR_INLINE void keepUnit(const FloatRows&, int, float) {}
MIDAIR_INLINE void keepUnit(const FixedRows& rows, int row, float unit)
{
    rows.scale[row] = unit * (1.0f / 65536.0f);
}

// Writes a group's entries from their amplitudes and phases.
template<typename Rows>
MIDAIR_INLINE void
writeEntries(const PointBatch& points, int width, int first, const Rows& rows, const Scratch& s)
{
    for (int k = 0; k < points.count; ++k)
    {
        const auto row = rowOf(rows, points.row[k], width);
        const float *amplitudes = s.square[k], *turns = s.excess[k];
#pragma omp simd aligned(amplitudes, turns : 64)
        for (int i = 0; i < kGroup; ++i)
        {
            // From half the angle: a cos 2h = a - 2 a sin^2 h, a sin 2h = 2 a sin h cos h.
            const float a = amplitudes[i], sine = sinHalf(turns[i]);
            const float along = a * (sine + sine);
            row.put(first + i, a - along * sine, along * cosHalf(turns[i]));
        }
    }
}

// Amplitudes and phases of a group's entries.
template<bool kWithOffset, typename Model>
MIDAIR_INLINE void
groupWaves(const BlockGeometry& block, const Expansion& at, int g, int points, Model D, Scratch& s)
{
    squares(block, at, g * kGroup, points, s);
    inverseRoots(points * kGroup, s.square[0], s.inverse[0]);
    if (block.groups[g].planar)
        waves<true, kWithOffset>(block, at, g * kGroup, points, D, s);
    else
        waves<false, kWithOffset>(block, at, g * kGroup, points, D, s);
}

// G_li = strength_i D / R exp(-beta R) exp(j 2 pi (offset_i - R)), R in wavelengths (see
// PropagationMatrix.h).
template<bool kWithOffset, typename Model, typename Rows>
MIDAIR_INLINE void buildRows(const BlockGeometry& block,
                             const PointBatch& points,
                             float decay,
                             Model D,
                             const Rows& rows,
                             float* sums)
{
    const int width = block.width & ~(kLanes - 1);
    const int groups = width / kGroup;
    Expansion at[kMaxWidth / kGroup];
    for (int g = 0; g < groups; ++g)
        expand<true>(block.groups[g], points, decay, at[g]);
    alignas(64) float units[PointBatch::kSize];
    scale(isFixed(rows), D.largest(), decay, groups, at, units);
    Scratch s;
    for (int k = 0; k < points.count; ++k)
        std::fill_n(s.sums[k], kGroup, 0.0f);
    // Several loops instead of one, which would be a dependency chain of some 150 cycles and exceed
    // the core's out-of-order window.
    for (int g = 0; g < groups; ++g)
    {
        groupWaves<kWithOffset>(block, at[g], g, points.count, D, s);
        writeEntries(points, width, g * kGroup, rows, s);
    }
    for (int k = 0; k < points.count; ++k)
    {
        float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
        for (int i = 0; i < kGroup; ++i)
            sum += s.sums[k][i];
        sums[k] = sum * units[k];
        keepUnit(rows, points.row[k], units[k]);
    }
}

template<typename Model, typename Rows>
MIDAIR_INLINE void buildAny(const BlockGeometry& block,
                            const PointBatch& points,
                            float decay,
                            Model D,
                            const Rows& rows,
                            float* sums)
{
    if (block.offset_turns)
        buildRows<true>(block, points, decay, D, rows, sums);
    else
        buildRows<false>(block, points, decay, D, rows, sums);
}

} // namespace

void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, CubicModel{D}, rows, sums);
}

void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, CubicModel{D}, rows, sums);
}

void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, TableModel{D}, rows, sums);
}

void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, TableModel{D}, rows, sums);
}

void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityPoint& D,
                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, PointModel{D}, rows, sums);
}

void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityPoint& D,
                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, PointModel{D}, rows, sums);
}

#ifndef MIDAIR_HAS_PAIRS
// Sets without registers to interleave (QuickRowKernels.cpp) have the exact rows.
void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const QuickRows& rows,
                float* sums)
{
    buildCubic(block, points, decay, D, static_cast<const FixedRows&>(rows), sums);
}

void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const QuickRows& rows,
                float* sums)
{
    buildTable(block, points, decay, D, static_cast<const FixedRows&>(rows), sums);
}

void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityPoint& D,
                const QuickRows& rows,
                float* sums)
{
    buildPoint(block, points, decay, D, static_cast<const FixedRows&>(rows), sums);
}
#endif

} // namespace midair::haptics::kernels::MIDAIR_SET
