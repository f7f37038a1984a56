#include "haptics/propagation/kernels/PropagationKernels.h"

#include "haptics/propagation/kernels/DirectivityModels.h"
#include "haptics/propagation/kernels/KernelTools.h"

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

// Expansion of a point's distances to a group's transducers about the group's centre. With r0 the
// vector from the centre, R0 = |r0|:
//     R^2 = R0^2 + e,  e = |d|^2 - 2 r0.d,  R = R0 + e / (R + R0),
// where d is the transducer's position relative to the centre. R0 is computed in double and only
// its fraction of a wavelength is kept, so the phase is as exact as a float holds e / (R + R0),
// which is at most |d|: a few 1e-7 wavelengths for groups of a few wavelengths. A float could not
// hold R itself (60 wavelengths) to 1e-6.
struct Expansion
{
    alignas(64) float ax[PointBatch::kSize], ay[PointBatch::kSize], az[PointBatch::kSize]; // -2 r0
    alignas(64) float square[PointBatch::kSize], distance[PointBatch::kSize]; // R0^2, R0
    alignas(64) float turns[PointBatch::kSize];   // -R0 without whole turns
    alignas(64) float decayed[PointBatch::kSize]; // exp(-decay R0), in units of the row
    alignas(64) float slope[PointBatch::kSize]; // first derivative of decayed, and half the second
    alignas(64) float bend[PointBatch::kSize];
    alignas(64) float height[PointBatch::kSize];    // n.r0
    alignas(64) float magnitude[PointBatch::kSize]; // a bound of |G_li| / D, Pa
};

// Wavelengths; the matrix passes no points that are nearer to a transducer.
constexpr float kNearest = 0.25f;

MIDAIR_INLINE void
expand(const GroupGeometry& group, const PointBatch& points, float decay, Expansion& out)
{
    const GroupGeometry g = group;
    const float planar = g.planar ? 1.0f : 0.0f;
#pragma omp simd
    for (int k = 0; k < PointBatch::kSize; ++k)
    {
        const double x = points.x[k] - g.x, y = points.y[k] - g.y, z = points.z[k] - g.z;
        const double square = x * x + y * y + z * z;
        const double distance = std::sqrt(square);
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y),
                   fz = static_cast<float>(z);
        out.ax[k] = -2.0f * fx;
        out.ay[k] = -2.0f * fy;
        out.az[k] = -2.0f * fz;
        out.square[k] = static_cast<float>(square);
        out.turns[k] = static_cast<float>(rounded(distance) - distance);
        const auto R = static_cast<float>(distance);
        out.distance[k] = R;
        out.decayed[k] = expOfMinus(decay * R);
        const float height = g.nx * fx + g.ny * fy + g.nz * fz;
        out.height[k] = height;
        const float nearest =
            std::max(std::max(R - g.radius, planar * std::fabs(height)), kNearest);
        out.magnitude[k] = out.decayed[k] * g.strongest * (1.0f + g.radius * decay) / nearest;
    }
}

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

// Returns the unit of a row's entries for which \a bound fits.
MIDAIR_INLINE float unitOf(const FloatRows&, float)
{
    return 1.0f;
}
MIDAIR_INLINE float unitOf(const FixedRows&, float bound)
{
    return std::max(bound, 1e-30f) * (1.0f / kFixedPeak);
}

// Computes the units of the batch's rows and the groups' attenuations in these units.
template<typename Rows>
MIDAIR_INLINE void
scale(const Rows& rows, float largestD, float decay, int groups, Expansion* at, float* units)
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
        units[k] = unitOf(rows, 1.002f * largestD * level[k]);
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
        expand(block.groups[g], points, decay, at[g]);
    alignas(64) float units[PointBatch::kSize];
    scale(rows, D.largest(), decay, groups, at, units);
    Scratch s;
    for (int k = 0; k < points.count; ++k)
        std::fill_n(s.sums[k], kGroup, 0.0f);
    // Several loops instead of one, which would be a dependency chain of some 150 cycles and exceed
    // the core's out-of-order window.
    for (int g = 0; g < groups; ++g)
    {
        const int first = g * kGroup;
        squares(block, at[g], first, points.count, s);
        inverseRoots(points.count * kGroup, s.square[0], s.inverse[0]);
        if (block.groups[g].planar)
            waves<true, kWithOffset>(block, at[g], first, points.count, D, s);
        else
            waves<false, kWithOffset>(block, at[g], first, points.count, D, s);
        writeEntries(points, width, first, rows, s);
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

} // namespace midair::haptics::kernels::MIDAIR_SET
