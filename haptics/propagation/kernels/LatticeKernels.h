#pragma once

#include "haptics/base/simd/Kernel.h"

/// The loops of LatticeField, compiled for every instruction set and chosen at run time; no kernel
/// allocates.
namespace midair::haptics::kernels
{

constexpr int kLatticeLanes = 16; ///< transducers at once; padding has strength 0
constexpr int kLatticeBlock = 128;
constexpr int kLatticeSamples = 128; ///< of a tile, at most

constexpr int kDirectivitySteps =
    512; ///< D at cos(theta) = -1 + 2 i/kDirectivitySteps, one value beyond the end

/// Lengths in wavelengths; all arrays aligned to 64 bytes, \a width a multiple of kLatticeLanes.
struct LatticeSources
{
    const float *x, *y, *z;
    const float *nx, *ny, *nz;
    const float *re, *im; ///< what is emitted: P0 gain q exp(j offset) / lambda, Pa
    const float* directivity;
    int width;
};

/// Lengths in wavelengths.
struct LatticeTile
{
    float middle[3];
    float step[3][3]; ///< step[k]: from one sample to the next along axis k
    int count[3];
    float beta; ///< attenuation, Np a wavelength
};

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
/// Adds the sources' waves to \a sums, a real and an imaginary part a sample: within 1e-2 of the
/// sum of the waves' amplitudes for sources that are at least two wavelengths and four of the
/// tile's half diagonals away.
extern const base::Kernel<void(const LatticeSources& sources, const LatticeTile& tile, float* sums)>
    marchLattice;

/// The least squared distance from \a middle of all sources, to 5e-7 of the largest coordinate's
/// square.
extern const base::Kernel<float(const LatticeSources& sources, const float* middle)> nearestSquared;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
