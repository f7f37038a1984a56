#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <string>

namespace midair::haptics
{

/// Worst accuracy of a reflector, mm, that a correction for it is made with: beyond it the
/// corrected field is as wrong as one that is solved for free air.
constexpr double kMostCorrectedAccuracy_mm = 1.0;

/// Share of transducers behind reflectors that is told.
constexpr double kToldHidden = 0.01;

/// What reflectors make of the drives of a sequence.
struct ReflectorFigures
{
    double rms = 0.0;      ///< at the points, as FieldFigures::rms
    double worst = 0.0;    ///< the largest error of a point
    double level_Pa = 0.0; ///< FieldFigures::level_Pa
    /// rms to expect if each reflector is off by its accuracy along its normal: the root of rms^2
    /// and, for each reflector, the mean square by which the points' errors change.
    double expectedRms = 0.0;
    double freeRms = 0.0;      ///< rms without the reflectors
    double freeLevel_Pa = 0.0; ///< level without them
};

/// Measures the drives of \a sequence, whose points have targets above 0, with the reflectors of \a
/// array. In single precision, to some 1e-4 of the level.
ReflectorFigures reflectorFigures(const FieldSequence& sequence,
                                  const TransducerArray& array,
                                  const Medium& medium,
                                  int threads = 1,
                                  const base::StopToken& stop = {});

/// Returns the number of transducers, of gain above 0, that reflectors hide from most of \a points
/// (3 x n): their direct wave loses more than half of its power there.
int hiddenTransducers(const Eigen::Matrix3Xd& points,
                      const TransducerArray& array,
                      const Medium& medium);

/// Returns why the reflectors of \a array can't be corrected for at \a points, by the name of the
/// one to blame: its accuracy, or a point nearer than a wavelength to it. Empty: they can. Boards
/// belong to the array, so their accuracy is no reason: the rms to expect decides.
std::string whyUncorrectable(const Eigen::Matrix3Xd& points,
                             const TransducerArray& array,
                             const Medium& medium);

} // namespace midair::haptics
