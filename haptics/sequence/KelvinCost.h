#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// What is left of a field in air that is 1 K warmer than it was solved for: sound is faster by
/// 0.17 %, so that waves from near and far transducers no longer arrive in step.
struct KelvinCost
{
    double rms = 0.0;   ///< relative, at the points; 0: not measured
    double level = 0.0; ///< fitted level over that in \a medium; 0: not measured
};

/// Plays \a q (m) in \a medium and in air 1 K warmer, or colder where the medium can't be warmer,
/// and compares |p| at those of \a points that have a target. Takes as long as two matrices for
/// them. Nothing is measured without such points, and for silence. Throws base::Stopped.
KelvinCost kelvinCost(const ControlPoints& points,
                      const Eigen::VectorXcf& q,
                      const TransducerArray& array,
                      const Medium& medium,
                      int threads,
                      const base::StopToken& stop = {});

} // namespace midair::haptics
