// Rows of G in fixed point with the waves of images in one reflector, in passes over one point and
// group, whose numbers stay in the nearest cache: a loop with all of it would be a chain too long
// for a core to look ahead.
#include "haptics/propagation/kernels/MirroredRowKernels.h"

#include "haptics/propagation/kernels/DirectivityModels.h"
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PointExpansion.h"
#include "haptics/propagation/kernels/Register.h"
#include "haptics/propagation/kernels/SheetShares.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

namespace
{

constexpr int kTogether = 8; // points of a pass, which then loads its constants once

// Numbers of the direct wave (0) and of that of the image (1) of a point.
struct BothWaves
{
    alignas(64) float excess[2][kGroup], twice[2][kGroup], inverse[2][kGroup]; // e, R + R0, 1/R
    alignas(64) float amplitude[2][kGroup], halfTurns[2][kGroup];
};

// Computes e, R + R0 and 1/R of wave \a w, seen from \a at.
MIDAIR_INLINE void distances(
    const BlockGeometry& block, int first, const Expansion& at, int k, int w, BothWaves& waves)
{
    using R = Register;
    const R::Floats ax = R::all(at.ax[k]), ay = R::all(at.ay[k]), az = R::all(at.az[k]);
    const R::Floats square = R::all(at.square[k]), distance = R::all(at.distance[k]);
    for (int i = 0; i < kGroup; i += R::kLanes)
    {
        const R::Floats e = R::plus(
            R::plus(R::plus(R::load(block.square + first + i), ax, R::load(block.x + first + i)),
                    ay,
                    R::load(block.y + first + i)),
            az,
            R::load(block.z + first + i));
        const R::Floats whole = R::sum(square, e), inverse = R::inverseRoot(whole);
        R::store(waves.excess[w] + i, e);
        R::store(waves.twice[w] + i, R::plus(distance, whole, inverse));
        R::store(waves.inverse[w] + i, inverse);
    }
}

// Amplitude and phase of wave \a w, seen from \a at, whose phase is \a turned half turns ahead; see
// waves() in PropagationKernels.cpp.
template<bool kPlanar, bool kWithOffset, typename Model>
MIDAIR_INLINE void oneWave(const BlockGeometry& block,
                           int first,
                           const Expansion& at,
                           int k,
                           float turned,
                           const Model& D,
                           int w,
                           BothWaves& waves)
{
    const float *x = block.x + first, *y = block.y + first, *z = block.z + first;
    const float *nx = block.nx + first, *ny = block.ny + first, *nz = block.nz + first;
    const float* strength = block.strength + first;
    const float ax = at.ax[k], ay = at.ay[k], az = at.az[k], height = at.height[k];
    const float base = 2.0f * at.turns[k] + turned;
    const float c0 = at.decayed[k], c1 = at.slope[k], c2 = at.bend[k];
    const float *excess = waves.excess[w], *twice = waves.twice[w], *inverses = waves.inverse[w];
    float *amplitude = waves.amplitude[w], *halfTurns = waves.halfTurns[w];
#pragma omp simd aligned(x, y, z, nx, ny, nz, strength, excess, twice, inverses : 64)              \
    aligned(amplitude, halfTurns : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        const float inverse = inverses[i];
        const float beyond = excess[i] / twice[i];
        float cosine = height * inverse;
        if constexpr (!kPlanar)
            cosine = -0.5f *
                     (nx[i] * (ax + 2.0f * x[i]) + ny[i] * (ay + 2.0f * y[i]) +
                      nz[i] * (az + 2.0f * z[i])) *
                     inverse;
        float a = (strength[i] * inverse) * ((c0 + beyond * (c1 + beyond * c2)) * D(cosine));
        float turns = base - 2.0f * beyond;
        if constexpr (kWithOffset) turns += 2.0f * block.offset_turns[first + i];
        toOneHalfTurn(a, turns);
        amplitude[i] = a;
        halfTurns[i] = turns;
    }
}

// Writes the sum of both waves, and adds its magnitude to \a sums.
template<bool kEnds>
MIDAIR_INLINE void
writeBoth(const BothWaves& waves, const SideShares& shares, std::int32_t* row, float* sums)
{
    const float *a = waves.amplitude[0], *b = waves.amplitude[1];
    const float *turns = waves.halfTurns[0], *imageTurns = waves.halfTurns[1];
    const float *x0 = shares.re[0], *y0 = shares.im[0], *x1 = shares.re[1], *y1 = shares.im[1];
    alignas(64) float squares[kGroup];
#pragma omp simd aligned(a, b, turns, imageTurns, x0, y0, x1, y1, row, squares : 64)
    for (int i = 0; i < kGroup; ++i)
    {
        float re = a[i] * quickCosHalf(turns[i]), im = a[i] * quickSinHalf(turns[i]);
        const float imageRe = b[i] * quickCosHalf(imageTurns[i]);
        const float imageIm = b[i] * quickSinHalf(imageTurns[i]);
        if constexpr (kEnds)
        {
            const float x = x0[i] * x1[i] - y0[i] * y1[i], y = x0[i] * y1[i] + y0[i] * x1[i];
            re += x * imageRe - y * imageIm;
            im += x * imageIm + y * imageRe;
        }
        else
        {
            re += imageRe;
            im += imageIm;
        }
        row[i] = packPair(re, im);
        squares[i] = re * re + im * im; // in units of the row
    }
#pragma omp simd aligned(squares, sums : 64)
    for (int i = 0; i < kGroup; ++i)
        sums[i] += std::sqrt(squares[i]);
}

// The rows of one group.
template<bool kPlanar, bool kWithOffset, bool kEnds, typename Model>
MIDAIR_INLINE void mirroredGroup(const BlockGeometry& block,
                                 int first,
                                 const PointBatch& points,
                                 const Expansion& own,
                                 const Expansion& image,
                                 const Mirror& mirror,
                                 const Model& D,
                                 std::int32_t* const* rows,
                                 float (*sums)[kGroup])
{
    BothWaves waves[kTogether];
    Edges edges[kTogether];
    SideShares shares[kTogether];
    alignas(64) float inverseA[kGroup];
    if constexpr (kEnds) inverseHeights(mirror.ends->sheet, first, inverseA);
    for (int from = 0; from < points.count; from += kTogether)
    {
        const int count = std::min(kTogether, points.count - from);
        for (int k = 0; k < count; ++k)
        {
            distances(block, first, own, from + k, 0, waves[k]);
            distances(block, first, image, from + k, 1, waves[k]);
        }
        for (int k = 0; k < count; ++k)
            oneWave<kPlanar, kWithOffset>(block, first, own, from + k, 0.0f, D, 0, waves[k]);
        for (int k = 0; k < count; ++k)
            oneWave<kPlanar, kWithOffset>(
                block, first, image, from + k, 2.0f * mirror.turns, D, 1, waves[k]);
        if constexpr (kEnds)
        {
            for (int k = 0; k < count; ++k)
                findEdges(mirror.ends->sheet,
                          first,
                          mirror.ends->points[from + k],
                          inverseA,
                          waves[k].inverse[1],
                          edges[k]);
            for (int k = 0; k < count; ++k)
                sharesOfSides(edges[k], shares[k]);
        }
        for (int k = 0; k < count; ++k)
            writeBoth<kEnds>(waves[k], shares[k], rows[from + k] + first, sums[from + k]);
    }
}

// Expansions of the points and of their images, with attenuations in the units of the rows, those
// of the sum of both bounds.
MIDAIR_INLINE void expandBoth(const BlockGeometry& block,
                              const PointBatch& points,
                              const PointBatch& images,
                              float largestD,
                              float decay,
                              const Mirror& mirror,
                              Expansion* own,
                              Expansion* image,
                              float* units)
{
    // A share is at most the square of the longest chord of Cornu's spiral, 1.3422.
    const float most = mirror.ends ? 1.802f * mirror.reflection : mirror.reflection;
    const int groups = block.width / kGroup;
    for (int g = 0; g < groups; ++g)
    {
        expand<true>(block.groups[g], points, decay, own[g]);
        expand<true>(block.groups[g], images, decay, image[g]);
#pragma omp simd
        for (int k = 0; k < PointBatch::kSize; ++k)
        {
            own[g].magnitude[k] += most * image[g].magnitude[k];
            image[g].magnitude[k] = own[g].magnitude[k];
            image[g].decayed[k] *= mirror.reflection;
        }
    }
    scale(true, largestD, decay, groups, own, units);
    scale(true, largestD, decay, groups, image, units);
}

template<bool kWithOffset, bool kEnds, typename Model>
MIDAIR_INLINE void buildMirrored(const BlockGeometry& block,
                                 const PointBatch& points,
                                 const PointBatch& images,
                                 const Mirror& mirror,
                                 float decay,
                                 const Model& D,
                                 const FixedRows& rows,
                                 float* sums)
{
    const int width = block.width & ~(kLanes - 1), groups = width / kGroup;
    Expansion own[kMaxWidth / kGroup], image[kMaxWidth / kGroup];
    alignas(64) float units[PointBatch::kSize];
    expandBoth(block, points, images, D.largest(), decay, mirror, own, image, units);
    alignas(64) float magnitudes[PointBatch::kSize][kGroup] = {};
    std::int32_t* to[PointBatch::kSize];
    for (int k = 0; k < points.count; ++k)
        to[k] = rows.entries + 1L * width * points.row[k];
    for (int g = 0; g < groups; ++g)
        if (block.groups[g].planar)
            mirroredGroup<true, kWithOffset, kEnds>(
                block, g * kGroup, points, own[g], image[g], mirror, D, to, magnitudes);
        else
            mirroredGroup<false, kWithOffset, kEnds>(
                block, g * kGroup, points, own[g], image[g], mirror, D, to, magnitudes);
    for (int k = 0; k < points.count; ++k)
    {
        float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
        for (int i = 0; i < kGroup; ++i)
            sum += magnitudes[k][i];
        sums[k] = sum * units[k];
        rows.scale[points.row[k]] = units[k] * (1.0f / 65536.0f);
    }
}

template<typename Model>
MIDAIR_INLINE void buildAnyMirrored(const BlockGeometry& block,
                                    const PointBatch& points,
                                    const PointBatch& images,
                                    const Mirror& mirror,
                                    float decay,
                                    const Model& D,
                                    const FixedRows& rows,
                                    float* sums)
{
    if (block.offset_turns && mirror.ends)
        buildMirrored<true, true>(block, points, images, mirror, decay, D, rows, sums);
    else if (block.offset_turns)
        buildMirrored<true, false>(block, points, images, mirror, decay, D, rows, sums);
    else if (mirror.ends)
        buildMirrored<false, true>(block, points, images, mirror, decay, D, rows, sums);
    else
        buildMirrored<false, false>(block, points, images, mirror, decay, D, rows, sums);
}

} // namespace

void buildMirroredCubic(const BlockGeometry& block,
                        const PointBatch& points,
                        const PointBatch& images,
                        const Mirror& mirror,
                        float decay,
                        const DirectivityCubic& D,
                        const FixedRows& rows,
                        float* sums)
{
    buildAnyMirrored(block, points, images, mirror, decay, CubicModel{D}, rows, sums);
}

void buildMirroredTable(const BlockGeometry& block,
                        const PointBatch& points,
                        const PointBatch& images,
                        const Mirror& mirror,
                        float decay,
                        const DirectivityTable& D,
                        const FixedRows& rows,
                        float* sums)
{
    buildAnyMirrored(block, points, images, mirror, decay, TableModel{D}, rows, sums);
}

void buildMirroredPoint(const BlockGeometry& block,
                        const PointBatch& points,
                        const PointBatch& images,
                        const Mirror& mirror,
                        float decay,
                        const DirectivityPoint& D,
                        const FixedRows& rows,
                        float* sums)
{
    buildAnyMirrored(block, points, images, mirror, decay, PointModel{D}, rows, sums);
}

} // namespace midair::haptics::kernels::MIDAIR_SET
