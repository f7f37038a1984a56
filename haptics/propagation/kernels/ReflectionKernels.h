#pragma once

#include "haptics/base/simd/Kernel.h"

/// Kernels that turn rows of a free field into rows of a field with reflectors, compiled for each
/// instruction set and selected at run time. Lengths are in wavelengths, all arrays aligned to 64
/// bytes, all widths multiples of kLanes. Kernels don't allocate.
namespace midair::haptics::kernels
{

/// Transducers of a block as a reflector sees them: above its plane, and along its sides from its
/// centre. Those that stand on it have the height 0.
struct SheetLanes
{
    const float *height, *along, *across;
};
/// A control point, likewise.
struct SheetPoint
{
    float height, along, across;
};

/// A rectangle with sides of 2 halfAlong and 2 halfAcross, and the transducers of a block beside
/// it.
struct SheetView
{
    SheetLanes lanes;
    float halfAlong, halfAcross;
};

/// Factor R exp(j phase) of the reflected wave, and R.
struct SheetFactor
{
    float re, im, reflection;
};

/// Waves of a point, one for each lane of a block.
struct Waves
{
    const float* heights; ///< of the lanes
    const float *imageRe, *imageIm;
    float *directRe, *directIm;
    float *reflectedRe, *reflectedIm;
};

/// Largest |v| of an edge that sharesTurned() counts.
constexpr float kFarthestEdge = 1000.0F;

/// Computes haptics::shareTurned() of a rectangle for each lane: within 1e-4 + 1e-6 |v|, v as
/// described there, up to kFarthestEdge; with an edge beyond that within 4e-4. Heights and places
/// are within 1e4.
// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
extern const base::Kernel<void(
    int width, const SheetView& sheet, const SheetPoint& point, float* shareRe, float* shareIm)>
    sharesTurned;

/// For a point at \a height: lanes on its side of the plane add factor times the wave of their
/// image to the reflected wave; of the direct wave of those on the other side the part reflection
/// is taken away. Nothing happens to lanes of the height 0. For a plane without end, or for a
/// rectangle, whose shares multiply both. Error 3e-7 of the terms.
extern const base::Kernel<void(
                              int width, float height, const SheetFactor& factor, const Waves& row),
                          void(int width,
                               float height,
                               const SheetFactor& factor,
                               const float* shareRe,
                               const float* shareIm,
                               const Waves& row)>
    reflect;

/// Adds the reflected wave to the direct one and returns sum_i |entry_i|; relative error 1e-5.
extern const base::Kernel<float(
    int width, const float* reflectedRe, const float* reflectedIm, float* re, float* im)>
    joinWaves;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
