#pragma once

#include "haptics/base/simd/Kernel.h"

/// Kernels of LatticeField, compiled for each instruction set and selected at run time. Kernels
/// don't allocate.
namespace midair::haptics::kernels
{

constexpr int kLatticeLanes = 16; ///< transducers per step; padding has strength 0
constexpr int kLatticeBlock = 128;
constexpr int kLatticeSamples = 128; ///< maximum samples of a tile

/// table of D at cos(theta) = -1 + 2 i/kDirectivitySteps, with one value beyond the end
constexpr int kDirectivitySteps = 512;

/// Sources of the waves. Lengths in wavelengths; all arrays are aligned to 64 bytes, \a width is a
/// multiple of kLatticeLanes.
struct LatticeSources
{
    const float *x, *y, *z;
    const float *nx, *ny, *nz;
    const float *re, *im; ///< emitted wave: P0 gain q exp(j offset) / lambda, Pa
    const float* directivity;
    int width;
};

/// Tile of samples; lengths in wavelengths.
struct LatticeTile
{
    float middle[3];
    float step[3][3]; ///< step[k]: vector from one sample to the next along axis k
    int count[3];
    float beta; ///< attenuation, Np per wavelength
};

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
/// Adds the sources' waves to \a sums (real and imaginary part of each sample). The error is within
/// 1e-2 of the sum of the waves' amplitudes for sources at least two wavelengths and four half
/// diagonals of the tile away.
extern const base::Kernel<void(const LatticeSources& sources, const LatticeTile& tile, float* sums)>
    marchLattice;

/// Returns the squared distance from \a middle to the nearest source, to 5e-7 of the largest
/// coordinate's square.
extern const base::Kernel<float(const LatticeSources& sources, const float* middle)> nearestSquared;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
