// Rows of G in fixed point with distances in single precision (QuickRows), for fields by the
// thousand: without PropagationKernels.cpp's exact expansion of a distance and its division.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PointExpansion.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/Register.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

#ifdef MIDAIR_HAS_PAIRS

namespace
{

// Rows that are computed side by side.
constexpr int kTogether = 4;

constexpr int kPoints = PointBatch::kSize;

// Numbers of kRows rows for the transducers of one register. An operation is done for all rows
// before the next, because an entry is a chain of some 50 operations that wait for each other,
// longer than what a core looks ahead.
template<int kRows>
struct Rows
{
    Register::Floats of[kRows];

    // One number for each row, and one register for all.
    MIDAIR_INLINE static Rows eachOf(const float* numbers)
    {
        Rows all;
        for (int k = 0; k < kRows; ++k)
            all.of[k] = Register::all(numbers[k]);
        return all;
    }
    MIDAIR_INLINE static Rows same(Register::Floats x)
    {
        Rows all;
        for (int k = 0; k < kRows; ++k)
            all.of[k] = x;
        return all;
    }
};

template<int kRows>
MIDAIR_INLINE Rows<kRows> operator+(Rows<kRows> a, const Rows<kRows>& b)
{
    for (int k = 0; k < kRows; ++k)
        a.of[k] = Register::sum(a.of[k], b.of[k]);
    return a;
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> operator-(Rows<kRows> a, const Rows<kRows>& b)
{
    for (int k = 0; k < kRows; ++k)
        a.of[k] = Register::difference(a.of[k], b.of[k]);
    return a;
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> operator*(Rows<kRows> a, const Rows<kRows>& b)
{
    for (int k = 0; k < kRows; ++k)
        a.of[k] = Register::product(a.of[k], b.of[k]);
    return a;
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> operator+(const Rows<kRows>& a, float b)
{
    return a + Rows<kRows>::same(Register::all(b));
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> operator-(const Rows<kRows>& a, float b)
{
    return a - Rows<kRows>::same(Register::all(b));
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> operator*(const Rows<kRows>& a, float b)
{
    return a * Rows<kRows>::same(Register::all(b));
}
template<int kRows>
MIDAIR_INLINE Rows<kRows> larger(Rows<kRows> a, float b)
{
    for (int k = 0; k < kRows; ++k)
        a.of[k] = Register::larger(a.of[k], Register::all(b));
    return a;
}
// 1/sqrt(a) to 4e-4.
template<int kRows>
MIDAIR_INLINE Rows<kRows> estimate(Rows<kRows> a)
{
    for (int k = 0; k < kRows; ++k)
        a.of[k] = Register::inverseRootEstimate(a.of[k]);
    return a;
}

// D of the cosines x, which are at most 1 but for rounding.
struct QuickCubic
{
    DirectivityCubic D;
    float largest() const { return D.largest; }
    template<int kRows>
    MIDAIR_INLINE Rows<kRows> operator()(const Rows<kRows>& x) const
    {
        return larger(((x * D.c3 + D.c2) * x + D.c1) * x + D.c0, 0.0f);
    }
};

struct QuickPoint
{
    DirectivityPoint D;
    float largest() const { return 1.0f; }
    template<int kRows>
    MIDAIR_INLINE Rows<kRows> operator()(const Rows<kRows>&) const
    {
        return Rows<kRows>::same(Register::all(1.0f));
    }
};

// log2 D in each step of ten degrees is level + slope * steps.
struct QuickTable
{
    alignas(64) float level[16], slope[16];
    float most;

    explicit QuickTable(const DirectivityTable& table) : most(table.largest)
    {
        float atZero = table.start, rise = 0.0f;
        for (int k = 0; k < 16; ++k)
        {
            const float bend = k < DirectivityTable::kSteps ? table.bend[k] : 0.0f;
            atZero -= bend * static_cast<float>(k);
            rise += bend;
            level[k] = atZero;
            slope[k] = rise;
        }
    }
    float largest() const { return most; }
    template<int kRows>
    MIDAIR_INLINE Rows<kRows> operator()(const Rows<kRows>& x) const
    {
        // acos(x) = sqrt(1 - x) P(x), 0 <= x <= 1, to 7e-5: Abramowitz, Stegun 4.4.45.
        constexpr float kSteps = 5.7295779513f;
        const Rows<kRows> y = larger(x, 0.0f), left = larger(y * -1.0f + 1.0f, 1e-12f);
        const Rows<kRows> P =
            ((y * (kSteps * -0.0187293f) + kSteps * 0.0742610f) * y + kSteps * -0.2121144f) * y +
            kSteps * 1.5707288f;
        const Rows<kRows> step = left * estimate(left) * P;
        Rows<kRows> start, rise;
        for (int k = 0; k < kRows; ++k)
        {
            const Register::Words at = Register::below(step.of[k]);
            start.of[k] = Register::lookUp(level, at);
            rise.of[k] = Register::lookUp(slope, at);
        }
        const Rows<kRows> t = start + rise * step;
        // 2^t = (2^(t/4))^4 by a minimax polynomial for -0.65 <= t/4 <= 0, 7e-9.
        Rows<kRows> e = ((((t * 1.041982288e-06f + 3.684179282e-05f) * t + 0.0008662909306f) * t +
                          0.01501357995f) *
                             t +
                         0.1732866681f) *
                            t +
                        0.9999999955f;
        e = e * e;
        e = e * e;
        for (int k = 0; k < kRows; ++k)
            e.of[k] = Register::unlessNegative(x.of[k], e.of[k]);
        return e;
    }
};

// Writes entries a exp(-j 2 pi f), |f| <= 1/2. With s = sin(pi f) and c = cos(pi f) they are
// a - 2 a s^2 and -2 a s c; polynomials in f^2 give s to 6e-7 and c to 7e-6.
template<int kRows>
MIDAIR_INLINE void
write(const Rows<kRows>& a, const Rows<kRows>& f, std::int32_t* const* rows, int i)
{
    using R = Rows<kRows>;
    const R t = f * f;
    const R s = (((t * -0.554618963f + 2.54189257f) * t - 5.16714212f) * t + 3.14158201f) * f;
    constexpr float kUpper = -65536.0f; // for the upper half of a lane
    const R c =
        ((t * (kUpper * -1.22208357f) + kUpper * 4.04127025f) * t + kUpper * -4.933937f) * t +
        kUpper * 0.999993285f;
    const R along = a * (s + s);
    const R re = a - along * s, im = along * c;
    for (int l = 0; l < kRows; ++l)
        Register::store(rows[l] + i,
                        Register::halves(Register::nearest(re.of[l]), Register::nearest(im.of[l])));
}

// Entries of the transducers of one register, from the  i-th on, for kRows points from  k on;
// their amplitudes, in units of the rows, are added to  sums.
template<int kRows, bool kPlanar, bool kWithOffset, typename Model>
MIDAIR_INLINE void fill(const BlockGeometry& block,
                        const Expansion& at,
                        int k,
                        int i,
                        const Model& D,
                        std::int32_t* const* rows,
                        float (*sums)[Register::kLanes])
{
    using R = Rows<kRows>;
    const R x = R::same(Register::load(block.x + i)), y = R::same(Register::load(block.y + i)),
            z = R::same(Register::load(block.z + i));
    const R square = (R::eachOf(at.square + k) + R::same(Register::load(block.square + i))) +
                     R::eachOf(at.ax + k) * x + R::eachOf(at.ay + k) * y + R::eachOf(at.az + k) * z;
    // With an estimate e of 1/R and g = R^2 e: R = g + (R^2 - g^2) e/2 but for the square of e's
    // relative error, which is below 4e-4.
    const R e = estimate(square), g = square * e;
    const R distance = (square - g * g) * (e * 0.5f) + g;
    R height = R::eachOf(at.height + k);
    if constexpr (!kPlanar)
    {
        // n.(r0 - d); n.d is common to all rows.
        const R nx = R::same(Register::load(block.nx + i)),
                ny = R::same(Register::load(block.ny + i)),
                nz = R::same(Register::load(block.nz + i));
        height =
            (R::eachOf(at.ax + k) * nx + R::eachOf(at.ay + k) * ny + R::eachOf(at.az + k) * nz) *
                -0.5f -
            (nx * x + ny * y + nz * z);
    }
    const R decayed = R::eachOf(at.slope + k) * distance + R::eachOf(at.decayed + k);
    const R a = R::same(Register::load(block.strength + i)) * e * (decayed * D(height * e));
    for (int l = 0; l < kRows; ++l)
        Register::store(sums[k + l], Register::sum(Register::load(sums[k + l]), a.of[l]));
    R f = distance;
    if constexpr (kWithOffset) f = f - R::same(Register::load(block.offset_turns + i));
    for (int l = 0; l < kRows; ++l)
        f.of[l] = Register::beyondNearest(f.of[l]);
    write<kRows>(a, f, rows + k, i);
}

template<bool kPlanar, bool kWithOffset, typename Model>
MIDAIR_INLINE void fillGroup(const BlockGeometry& block,
                             const Expansion& at,
                             int count,
                             int first,
                             const Model& D,
                             std::int32_t* const* rows,
                             float (*sums)[Register::kLanes])
{
    for (int i = first; i < first + kGroup; i += Register::kLanes)
    {
        int k = 0;
        for (; k + kTogether <= count; k += kTogether)
            fill<kTogether, kPlanar, kWithOffset>(block, at, k, i, D, rows, sums);
        if (count - k == 3)
            fill<3, kPlanar, kWithOffset>(block, at, k, i, D, rows, sums);
        else if (count - k == 2)
            fill<2, kPlanar, kWithOffset>(block, at, k, i, D, rows, sums);
        else if (count - k == 1)
            fill<1, kPlanar, kWithOffset>(block, at, k, i, D, rows, sums);
    }
}

template<bool kWithOffset, typename Model>
MIDAIR_INLINE void buildQuickRows(const BlockGeometry& block,
                                  const PointBatch& points,
                                  float decay,
                                  const Model& D,
                                  const FixedRows& rows,
                                  float* sums)
{
    const int width = block.width & ~(kLanes - 1), groups = width / kGroup;
    Expansion at[kMaxWidth / kGroup];
    for (int g = 0; g < groups; ++g)
        expand<false>(block.groups[g], points, decay, at[g]);
    alignas(64) float units[kPoints];
    scale(true, D.largest(), decay, groups, at, units);
    // exp(-decay R) as decayed + slope R.
    for (int g = 0; g < groups; ++g)
#pragma omp simd
        for (int k = 0; k < kPoints; ++k)
            at[g].decayed[k] -= at[g].slope[k] * at[g].distance[k];
    alignas(64) float parts[kPoints][Register::kLanes] = {};
    std::int32_t* to[kPoints];
    for (int k = 0; k < points.count; ++k)
        to[k] = rows.entries + 1L * width * points.row[k];
    for (int g = 0; g < groups; ++g)
        if (block.groups[g].planar)
            fillGroup<true, kWithOffset>(block, at[g], points.count, g * kGroup, D, to, parts);
        else
            fillGroup<false, kWithOffset>(block, at[g], points.count, g * kGroup, D, to, parts);
    for (int k = 0; k < points.count; ++k)
    {
        sums[k] = Register::total(Register::load(parts[k])) * units[k];
        rows.scale[points.row[k]] = units[k] * (1.0f / 65536.0f);
    }
}

template<typename Model>
MIDAIR_INLINE void buildQuick(const BlockGeometry& block,
                              const PointBatch& points,
                              float decay,
                              const Model& D,
                              const FixedRows& rows,
                              float* sums)
{
    if (block.offset_turns)
        buildQuickRows<true>(block, points, decay, D, rows, sums);
    else
        buildQuickRows<false>(block, points, decay, D, rows, sums);
}

} // namespace

void buildCubic(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityCubic& D,
                const QuickRows& rows,
                float* sums)
{
    buildQuick(block, points, decay, QuickCubic{D}, rows, sums);
}

void buildTable(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityTable& D,
                const QuickRows& rows,
                float* sums)
{
    buildQuick(block, points, decay, QuickTable{D}, rows, sums);
}

void buildPoint(const BlockGeometry& block,
                const PointBatch& points,
                float decay,
                const DirectivityPoint& D,
                const QuickRows& rows,
                float* sums)
{
    buildQuick(block, points, decay, QuickPoint{D}, rows, sums);
}

#endif

} // namespace midair::haptics::kernels::MIDAIR_SET
