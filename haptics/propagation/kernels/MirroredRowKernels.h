#pragma once

#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/ReflectionKernels.h"

namespace midair::haptics::kernels
{

/// The ends of a reflector, as a block of transducers and the points of a batch see it.
struct MirrorEnds
{
    SheetView sheet;
    SheetPoint points[PointBatch::kSize];
};

/// Factor of the reflected wave, reflection exp(j 2 pi turns), |turns| <= 1/2.
struct Mirror
{
    float reflection, turns;
    const MirrorEnds* ends; ///< null: it has none
};

/// Computes rows as BuildRows does, in fixed point, for points on the side of a reflector on which
/// all transducers of the block are: factor times the wave at \a images, the mirror images of \a
/// points, is added, times the share of haptics::shareTurned() if the reflector has ends, and \a
/// sums are those of the entries. \a images has the places of a batch; both are at least 1/4
/// wavelength from every transducer. Within the sum of the errors of both waves, relative to the
/// sum of their bounds, that of an image with ends 1.802 times as large, and with kernels::
/// sharesTurned()'s error of the image; the sums within 1e-5.
template<typename Model>
using BuildMirroredRows = base::Kernel<void(const BlockGeometry& block,
                                            const PointBatch& points,
                                            const PointBatch& images,
                                            const Mirror& mirror,
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
