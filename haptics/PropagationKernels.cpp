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
    MIDAIR_INLINE float largest() const { return D.largest; }
    MIDAIR_INLINE float operator()(float x) const
    {
        const float value = D.c0 + x * (D.c1 + x * (D.c2 + x * D.c3));
        return std::max(value, 0.0f);
    }
};

struct PointModel
{
    MIDAIR_INLINE float largest() const { return 1.0f; }
    MIDAIR_INLINE float operator()(float) const { return 1.0f; }
};

// log2 D is linear in theta between the table's angles: a sum of hinges, without the gathers that a look-up would take.
struct TableModel
{
    DirectivityTable table;
    MIDAIR_INLINE float largest() const { return table.largest; }
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

// Of one row and block: e and R, then phase and amplitude.
struct Scratch
{
    alignas(64) float excess[kMaxWidth];
    alignas(64) float distance[kMaxWidth];
};

// What a point's distances to a group's transducers are expanded about. With r0 the vector from the centre, R0 = |r0|:
//     R^2 = R0^2 + e,  e = |d|^2 - 2 r0.d,  R = R0 + e / (R + R0),
// d the transducer's place about the centre. R0 is taken in double and only its part beyond whole wavelengths kept, so the
// phase is exact to what a float holds of e / (R + R0), which is at most |d|: a few 1e-7 wavelengths for groups of a few
// wavelengths. A float could not hold R itself: 60 wavelengths to 1e-6.
struct Expansion
{
    alignas(64) float ax[PointBatch::kSize], ay[PointBatch::kSize], az[PointBatch::kSize]; // -2 r0
    alignas(64) float square[PointBatch::kSize], distance[PointBatch::kSize]; // R0^2, R0
    alignas(64) float turns[PointBatch::kSize];   // -R0 less whole turns
    alignas(64) float decayed[PointBatch::kSize]; // exp(-decay R0), in units of the row
    alignas(64) float slope[PointBatch::kSize];   // its first and half its second derivative
    alignas(64) float bend[PointBatch::kSize];
    alignas(64) float height[PointBatch::kSize];    // n.r0
    alignas(64) float magnitude[PointBatch::kSize]; // a bound of |G_li| / D, Pa
};

// exp(-x), 0 <= x <= 1: a polynomial in x/4, to the fourth power; 3e-7.
MIDAIR_INLINE float expOfMinus(float x)
{
    const float y = -0.25f * x;
    const float e =
        1.0f +
        y * (1.0f + y * (0.5f + y * (1.0f / 6.0f + y * (1.0f / 24.0f + y * (1.0f / 120.0f)))));
    return (e * e) * (e * e);
}

constexpr float kNearest =
    0.25f; // wavelengths; the matrix asks for no point that is nearer to a transducer

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

// e and R of a group's entries.
MIDAIR_INLINE void
distances(const BlockGeometry& block, const Expansion& at, int k, int first, int lanes, Scratch& s)
{
    const float *x = block.x + first, *y = block.y + first, *z = block.z + first;
    const float* squares = block.square + first;
    float *excess = s.excess + first, *distance = s.distance + first;
    const float ax = at.ax[k], ay = at.ay[k], az = at.az[k], square = at.square[k];
#pragma omp simd aligned(x, y, z, squares, excess, distance : 64)
    for (int i = 0; i < lanes; ++i)
    {
        const float e = squares[i] + ax * x[i] + ay * y[i] + az * z[i];
        excess[i] = e;
        distance[i] = std::sqrt(square + e);
    }
}

// Amplitudes strength D / R exp(-beta R) level in place of R, and phases -R (turns) in place of e.
template<bool kPlanar, typename Model>
MIDAIR_INLINE void waves(const BlockGeometry& block,
                         const Expansion& at,
                         int k,
                         int first,
                         int lanes,
                         Model D,
                         Scratch& s)
{
    const float *x = block.x + first, *y = block.y + first, *z = block.z + first;
    const float *nx = block.nx + first, *ny = block.ny + first, *nz = block.nz + first;
    const float* strength = block.strength + first;
    float *excess = s.excess + first, *distance = s.distance + first;
    const float ax = at.ax[k], ay = at.ay[k], az = at.az[k], base = at.turns[k];
    const float R0 = at.distance[k], height = at.height[k];
    // exp(-decay (R - R0)) as a parabola: decay * radius is small.
    const float c0 = at.decayed[k], c1 = at.slope[k], c2 = at.bend[k];
#pragma omp simd aligned(x, y, z, nx, ny, nz, strength, excess, distance : 64)
    for (int i = 0; i < lanes; ++i)
    {
        const float R = distance[i];
        const float twice = R + R0;
        const float inverseOfBoth = 1.0f / (R * twice);
        const float inverse = inverseOfBoth * twice;
        const float beyond = excess[i] * (R * inverseOfBoth);
        float cosine = height * inverse;
        if constexpr (!kPlanar)
            cosine = -0.5f *
                     (nx[i] * (ax + 2.0f * x[i]) + ny[i] * (ay + 2.0f * y[i]) +
                      nz[i] * (az + 2.0f * z[i])) *
                     inverse;
        distance[i] = (strength[i] * inverse) * ((c0 + beyond * (c1 + beyond * c2)) * D(cosine));
        excess[i] = base - beyond;
    }
}

MIDAIR_INLINE int lanesOf(int width, int group)
{
    return std::min(kGroup, width - group * kGroup) & ~(kLanes - 1);
}

// What the entries of a row are multiples of, so that \a bound fits.
MIDAIR_INLINE float unitOf(const FloatRows&, float)
{
    return 1.0f;
}
MIDAIR_INLINE float unitOf(const FixedRows&, float bound)
{
    return std::max(bound, 1e-30f) * (1.0f / kFixedPeak);
}

// Units of the batch's rows, and the groups' attenuations in them.
template<typename Rows>
MIDAIR_INLINE void
scale(const Rows& rows, float largestD, float decay, int groups, Expansion* at, float* units)
{
    alignas(64) float level[PointBatch::kSize] = {};
    for (int g = 0; g < groups; ++g)
#pragma omp simd
        for (int k = 0; k < PointBatch::kSize; ++k)
            level[k] = std::max(level[k], at[g].magnitude[k]);
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
    MIDAIR_INLINE FloatRow(const FloatRows& rows, int row, int width, float) :
        re(rows.entries + 2L * width * row),
        im(re + width)
    {
    }
    MIDAIR_INLINE void put(int i, float x, float y) const
    {
        re[i] = x;
        im[i] = y;
    }
};

struct FixedRow
{
    std::int32_t* entries;
    MIDAIR_INLINE FixedRow(const FixedRows& rows, int row, int width, float unit) :
        entries(rows.entries + 1L * width * row)
    {
        rows.scale[row] = unit * (1.0f / 65536.0f);
    }
    MIDAIR_INLINE void put(int i, float x, float y) const { entries[i] = packPair(x, y); }
};

MIDAIR_INLINE FloatRow rowOf(const FloatRows& rows, int row, int width, float unit)
{
    return {rows, row, width, unit};
}
MIDAIR_INLINE FixedRow rowOf(const FixedRows& rows, int row, int width, float unit)
{
    return {rows, row, width, unit};
}

// G_li = strength_i D / R exp(-beta R) exp(j 2 pi (offset_i - R)), R in wavelengths (see PropagationMatrix.h).
template<bool kWithOffset, typename Model, typename Rows>
MIDAIR_INLINE void buildRows(const BlockGeometry& block,
                             const PointBatch& points,
                             float decay,
                             Model D,
                             const Rows& rows,
                             float* sums)
{
    const int width = block.width & ~(kLanes - 1);
    const int groups = (width + kGroup - 1) / kGroup;
    Expansion at[kMaxWidth / kGroup];
    for (int g = 0; g < groups; ++g)
        expand(block.groups[g], points, decay, at[g]);
    alignas(64) float units[PointBatch::kSize];
    scale(rows, D.largest(), decay, groups, at, units);
    // In three loops: a single one is a chain of some 150 cycles, longer than what a core looks ahead.
    Scratch s;
    for (int k = 0; k < points.count; ++k)
    {
        for (int g = 0; g < groups; ++g)
            distances(block, at[g], k, g * kGroup, lanesOf(width, g), s);
        for (int g = 0; g < groups; ++g)
            if (block.groups[g].planar)
                waves<true>(block, at[g], k, g * kGroup, lanesOf(width, g), D, s);
            else
                waves<false>(block, at[g], k, g * kGroup, lanesOf(width, g), D, s);
        const auto row = rowOf(rows, points.row[k], width, units[k]);
        const float* offset = block.offset_turns;
        float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
        for (int i = 0; i < width; ++i)
        {
            float f = s.excess[i];
            if constexpr (kWithOffset) f += offset[i];
            f -= rounded(f);
            float sine, cosine;
            sinCosTurns(f, sine, cosine);
            const float a = s.distance[i];
            sum += std::fabs(a);
            row.put(i, a * cosine, a * sine);
        }
        sums[k] = sum * units[k];
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
void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, CubicModel{D}, rows, sums);
}

MIDAIR_CLONES
void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, CubicModel{D}, rows, sums);
}

MIDAIR_CLONES
void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, TableModel{D}, rows, sums);
}

MIDAIR_CLONES
void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, TableModel{D}, rows, sums);
}

MIDAIR_CLONES
void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,

                const FloatRows& rows,
                float* sums)
{
    buildAny(block, points, decay, PointModel{}, rows, sums);
}

MIDAIR_CLONES
void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,

                const FixedRows& rows,
                float* sums)
{
    buildAny(block, points, decay, PointModel{}, rows, sums);
}

} // namespace midair::haptics::kernels
