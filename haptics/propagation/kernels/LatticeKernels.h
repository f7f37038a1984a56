#pragma once

/// The loops of LatticeField, compiled for plain x86-64, AVX2 and AVX-512 and chosen at run time; no kernel allocates.
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

/// Adds the sources' waves to \a sums, a real and an imaginary part a sample.
void marchLattice(const LatticeSources& sources, const LatticeTile& tile, float* sums);

/// The least squared distance from \a middle of all sources.
float nearestSquared(const LatticeSources& sources, const float* middle);

} // namespace midair::haptics::kernels
