#pragma once

#include "haptics/propagation/kernels/PropagationKernels.h"

namespace midair::haptics::kernels
{

/// Factor of the reflected wave, R exp(j phase).
struct MirrorFactor
{
    float re, im;
};

/// Computes rows as BuildRows does, in fixed point, for points on the transducers' side of a plane
/// without end: factor times the wave at \a images, the mirror images of \a points, is added, and
/// \a sums are those of the entries. \a images has the places of a batch; both are at least 1/4
/// wavelength from every transducer. Within the sum of the errors of both waves, relative to the
/// sum of their bounds; the sums within 1e-5.
template<typename Model>
using BuildMirroredRows = base::Kernel<void(const BlockGeometry& block,
                                            const PointBatch& points,
                                            const PointBatch& images,
                                            const MirrorFactor& factor,
                                            float decay,
                                            const Model& D,
                                            const FixedRows& rows,
                                            float* sums)>;

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
extern const BuildMirroredRows<DirectivityCubic> buildMirroredCubic;
extern const BuildMirroredRows<DirectivityTable> buildMirroredTable;
extern const BuildMirroredRows<DirectivityPoint> buildMirroredPoint;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
