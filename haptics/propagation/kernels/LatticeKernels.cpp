#include "haptics/propagation/kernels/LatticeKernels.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/kernels/KernelTools.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

namespace
{

constexpr auto kTwoPi = static_cast<float>(base::kTwoPi);

/// A complex number for each source of a block.
struct Column
{
    alignas(64) float re[kLatticeBlock];
    alignas(64) float im[kLatticeBlock];
};

/// State of a block of sources for marching through a tile: the wave at the first sample, its
/// factors along the axes, and the factors by which those change along the axes.
struct March
{
    Column wave, along[3], bend[3][3];
};

// exp(re + j 2 pi turns), |re| <= 1 (6e-4 there, far less where it matters).
MIDAIR_INLINE void expInto(float real, float turns, float& re, float& im)
{
    const float y = 0.25f * std::min(1.0f, std::max(-1.0f, real));
    float e = 1.0f + y * (1.0f + y * (0.5f + y * 0.16666667f));
    e *= e;
    e *= e;
    float sine = 0.0f, cosine = 0.0f;
    sinCosTurns(turns - rounded(turns), sine, cosine);
    re = e * cosine;
    im = e * sine;
}

// exp(re + j 2 pi turns) for small arguments, to the fourth order.
MIDAIR_INLINE void smallExpInto(float real, float turns, float& re, float& im)
{
    const float x = real, y = kTwoPi * turns;
    const float e = 1.0f + x * (1.0f + 0.5f * x), y2 = y * y;
    re = e * (1.0f - y2 * (0.5f - y2 * (1.0f / 24.0f)));
    im = e * y * (1.0f - y2 * (1.0f / 6.0f));
}

/// For each source of a block: unit vector s to the tile's middle, distance R and 1/R, the
/// directivity D with its slope, and the gradient g of the logarithm of the amplitude.
struct Rays
{
    alignas(64) float sx[kLatticeBlock], sy[kLatticeBlock], sz[kLatticeBlock];
    alignas(64) float gx[kLatticeBlock], gy[kLatticeBlock], gz[kLatticeBlock];
    alignas(64) float R[kLatticeBlock], inverse[kLatticeBlock], cosine[kLatticeBlock];
    alignas(64) float D[kLatticeBlock], slope[kLatticeBlock];
};

MIDAIR_INLINE void
look(const LatticeSources& sources, int first, int width, const LatticeTile& t, Rays& rays)
{
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float dx = t.middle[0] - sources.x[first + i];
        const float dy = t.middle[1] - sources.y[first + i];
        const float dz = t.middle[2] - sources.z[first + i];
        rays.R[i] = std::sqrt(dx * dx + dy * dy + dz * dz);
        rays.inverse[i] = 1.0f / rays.R[i];
        rays.sx[i] = dx * rays.inverse[i];
        rays.sy[i] = dy * rays.inverse[i];
        rays.sz[i] = dz * rays.inverse[i];
        rays.cosine[i] = sources.nx[first + i] * rays.sx[i] + sources.ny[first + i] * rays.sy[i] +
                         sources.nz[first + i] * rays.sz[i];
    }
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float at = (0.5f * kDirectivitySteps) * (1.0f + rays.cosine[i]);
        const int k = std::min(kDirectivitySteps - 1, std::max(0, static_cast<int>(at)));
        const float low = sources.directivity[k], step = sources.directivity[k + 1] - low;
        rays.D[i] = low + (at - static_cast<float>(k)) * step;
        rays.slope[i] = (0.5f * kDirectivitySteps) * step;
    }
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float rise = rays.slope[i] / std::max(rays.D[i], 1e-3f) * rays.inverse[i];
        const float fall = rise * rays.cosine[i] + rays.inverse[i] + t.beta;
        rays.gx[i] = rise * sources.nx[first + i] - rays.sx[i] * fall;
        rays.gy[i] = rise * sources.ny[first + i] - rays.sy[i] * fall;
        rays.gz[i] = rise * sources.nz[first + i] - rays.sz[i] * fall;
    }
}

// Computes the waves at the corner where the march begins.
MIDAIR_INLINE void waveAt(const float* corner,
                          const LatticeSources& sources,
                          int first,
                          int width,
                          float beta,
                          const Rays& rays,
                          Column& wave)
{
    const float cc = corner[0] * corner[0] + corner[1] * corner[1] + corner[2] * corner[2];
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float inverse = rays.inverse[i];
        const float sc = rays.sx[i] * corner[0] + rays.sy[i] * corner[1] + rays.sz[i] * corner[2];
        const float real = rays.gx[i] * corner[0] + rays.gy[i] * corner[1] +
                           rays.gz[i] * corner[2] -
                           0.5f * (cc - 2.0f * sc * sc) * inverse * inverse;
        float re = 0.0f, im = 0.0f;
        expInto(real, -rays.R[i] - sc - 0.5f * (cc - sc * sc) * inverse, re, im);
        // Series of e^{-beta R}, good for the array's few dozen wavelengths.
        const float decay = beta * rays.R[i];
        const float strength =
            rays.D[i] * inverse *
            (1.0f - decay * (1.0f - decay * (0.5f - decay * (1.0f / 6.0f - decay / 24.0f))));
        const float qr = strength * sources.re[first + i], qi = strength * sources.im[first + i];
        wave.re[i] = re * qr - im * qi;
        wave.im[i] = re * qi + im * qr;
    }
}

// Computes the waves' factors for one step u at the corner.
MIDAIR_INLINE void
factorsAlong(const float* u, const float* corner, int width, const Rays& rays, Column& along)
{
    const float uc = u[0] * corner[0] + u[1] * corner[1] + u[2] * corner[2];
    const float uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float inverse = rays.inverse[i];
        const float su = rays.sx[i] * u[0] + rays.sy[i] * u[1] + rays.sz[i] * u[2];
        const float sc = rays.sx[i] * corner[0] + rays.sy[i] * corner[1] + rays.sz[i] * corner[2];
        const float real = rays.gx[i] * u[0] + rays.gy[i] * u[1] + rays.gz[i] * u[2] -
                           (uc + 0.5f * uu - su * (2.0f * sc + su)) * inverse * inverse;
        const float turns = -su - (uc + 0.5f * uu - su * (sc + 0.5f * su)) * inverse;
        expInto(real, turns, along.re[i], along.im[i]);
    }
}

// Computes the factor by which the factors of steps u change with a step v.
MIDAIR_INLINE void bendOf(const float* u, const float* v, int width, const Rays& rays, Column& bend)
{
    const float uv = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
#pragma omp simd
    for (int i = 0; i < width; ++i)
    {
        const float inverse = rays.inverse[i];
        const float su = rays.sx[i] * u[0] + rays.sy[i] * u[1] + rays.sz[i] * u[2];
        const float sv = rays.sx[i] * v[0] + rays.sy[i] * v[1] + rays.sz[i] * v[2];
        const float real = -(uv - 2.0f * su * sv) * inverse * inverse;
        smallExpInto(real, -(uv - su * sv) * inverse, bend.re[i], bend.im[i]);
    }
}

// Fills March for a block of sources, with exponents expanded to second order about the tile's
// middle.
MIDAIR_INLINE void
prepare(const LatticeSources& sources, int first, int width, const LatticeTile& tile, March& march)
{
    const LatticeTile t = tile;
    const int axes = t.count[2] > 1 ? 3 : 2;
    Rays rays;
    look(sources, first, width, t, rays);
    const float a = -0.5f * static_cast<float>(t.count[0] - 1);
    const float b = -0.5f * static_cast<float>(t.count[1] - 1);
    const float c = -0.5f * static_cast<float>(t.count[2] - 1);
    const float corner[3] = {a * t.step[0][0] + b * t.step[1][0] + c * t.step[2][0],
                             a * t.step[0][1] + b * t.step[1][1] + c * t.step[2][1],
                             a * t.step[0][2] + b * t.step[1][2] + c * t.step[2][2]};
    waveAt(corner, sources, first, width, t.beta, rays, march.wave);
    for (int k = 0; k < axes; ++k)
    {
        factorsAlong(t.step[k], corner, width, rays, march.along[k]);
        for (int l = k; l < axes; ++l)
            bendOf(t.step[k], t.step[l], width, rays, march.bend[k][l]);
    }
}

MIDAIR_INLINE void multiplyBy(float& re, float& im, float otherRe, float otherIm)
{
    const float product = re * otherRe - im * otherIm;
    im = re * otherIm + im * otherRe;
    re = product;
}

/// One step along an axis: wave_i *= along_i, along_i *= bend_i, and other_i *= cross_i.
MIDAIR_INLINE void
step(int width, Column& wave, Column& along, const Column& bend, Column& other, const Column& cross)
{
    float *waveRe = wave.re, *waveIm = wave.im, *alongRe = along.re, *alongIm = along.im;
    float *otherRe = other.re, *otherIm = other.im;
    const float *bendRe = bend.re, *bendIm = bend.im, *crossRe = cross.re, *crossIm = cross.im;
#pragma omp simd aligned(                                                                          \
    waveRe, waveIm, alongRe, alongIm, otherRe, otherIm, bendRe, bendIm, crossRe, crossIm : 64)
    for (int i = 0; i < width; ++i)
    {
        multiplyBy(waveRe[i], waveIm[i], alongRe[i], alongIm[i]);
        multiplyBy(alongRe[i], alongIm[i], bendRe[i], bendIm[i]);
        multiplyBy(otherRe[i], otherIm[i], crossRe[i], crossIm[i]);
    }
}

/// a_i *= b_i.
MIDAIR_INLINE void multiplyBy(int width, Column& a, const Column& b)
{
    float *re = a.re, *im = a.im;
    const float *otherRe = b.re, *otherIm = b.im;
#pragma omp simd aligned(re, im, otherRe, otherIm : 64)
    for (int i = 0; i < width; ++i)
        multiplyBy(re[i], im[i], otherRe[i], otherIm[i]);
}

/// State of a march along a row.
struct Place
{
    Column wave, along;
};

// Adds kCount samples of a row to sums, starting from wave and along, and writes the state after
// them to end.
template<int kCount>
MIDAIR_INLINE void marchSamples(
    int width, const Column& wave, const Column& along, const Column& bend, Place& end, float* sums)
{
    const float *waveRe = wave.re, *waveIm = wave.im, *alongRe = along.re, *alongIm = along.im;
    const float *bendRe = bend.re, *bendIm = bend.im;
    float *endRe = end.wave.re, *endIm = end.wave.im;
    float *endAlongRe = end.along.re, *endAlongIm = end.along.im;
    // Separate variables, so that the compiler keeps the sums in registers.
    float re0 = 0.0f, im0 = 0.0f, re1 = 0.0f, im1 = 0.0f;
    float re2 = 0.0f, im2 = 0.0f, re3 = 0.0f, im3 = 0.0f;
#pragma omp simd aligned(waveRe, waveIm, alongRe, alongIm, bendRe, bendIm, endRe, endIm : 64)      \
    aligned(endAlongRe, endAlongIm : 64) reduction(+ : re0, im0, re1, im1, re2, im2, re3, im3)
    for (int i = 0; i < width; ++i)
    {
        float vr = waveRe[i], vi = waveIm[i], sr = alongRe[i], si = alongIm[i];
        const float br = bendRe[i], bi = bendIm[i];
        const auto next = [&](float& re, float& im)
        {
            re += vr;
            im += vi;
            multiplyBy(vr, vi, sr, si);
            multiplyBy(sr, si, br, bi);
        };
        next(re0, im0);
        if constexpr (kCount > 1) next(re1, im1);
        if constexpr (kCount > 2) next(re2, im2);
        if constexpr (kCount > 3) next(re3, im3);
        if constexpr (kCount > 3) // shorter pieces end the row
        {
            endRe[i] = vr;
            endIm[i] = vi;
            endAlongRe[i] = sr;
            endAlongIm[i] = si;
        }
    }
    const float all[8] = {re0, im0, re1, im1, re2, im2, re3, im3};
    for (int k = 0; k < 2 * kCount; ++k)
        sums[k] += all[k];
}

MIDAIR_INLINE void marchRow(int count,
                            int width,
                            const Column& first,
                            const Column& firstAlong,
                            const Column& bend,
                            float* sums)
{
    Place place;
    const Column *wave = &first, *along = &firstAlong;
    for (; count >= 4; count -= 4, sums += 8)
    {
        marchSamples<4>(width, *wave, *along, bend, place, sums);
        wave = &place.wave;
        along = &place.along;
    }
    if (count == 3) marchSamples<3>(width, *wave, *along, bend, place, sums);
    if (count == 2) marchSamples<2>(width, *wave, *along, bend, place, sums);
    if (count == 1) marchSamples<1>(width, *wave, *along, bend, place, sums);
}

MIDAIR_INLINE void marchTile(int width, const int* count, March& march, float* sums)
{
    Column row, rowX, rowY;
    const auto copy = [width](const Column& from, Column& to)
    {
        std::copy_n(from.re, width, to.re);
        std::copy_n(from.im, width, to.im);
    };
    for (int c = 0; c < count[2]; ++c)
    {
        copy(march.wave, row);
        copy(march.along[0], rowX);
        copy(march.along[1], rowY);
        for (int b = 0; b < count[1]; ++b, sums += 2 * count[0])
        {
            marchRow(count[0], width, row, rowX, march.bend[0][0], sums);
            step(width, row, rowY, march.bend[1][1], rowX, march.bend[0][1]);
        }
        if (count[2] == 1) break;
        step(width, march.wave, march.along[2], march.bend[2][2], march.along[0], march.bend[0][2]);
        multiplyBy(width, march.along[1], march.bend[1][2]);
    }
}

} // namespace

void marchLattice(const LatticeSources& sources, const LatticeTile& tile, float* sums)
{
    March march;
    for (int first = 0; first < sources.width; first += kLatticeBlock)
    {
        const int width = std::min(kLatticeBlock, sources.width - first);
        prepare(sources, first, width, tile, march);
        marchTile(width, tile.count, march, sums);
    }
}

float nearestSquared(const LatticeSources& sources, const float* middle)
{
    const float x = middle[0], y = middle[1], z = middle[2];
    float least = 1e30f;
#pragma omp simd reduction(min : least)
    for (int i = 0; i < sources.width; ++i)
    {
        const float dx = x - sources.x[i], dy = y - sources.y[i], dz = z - sources.z[i];
        least = std::min(least, dx * dx + dy * dy + dz * dz);
    }
    return least;
}

} // namespace midair::haptics::kernels::MIDAIR_SET
