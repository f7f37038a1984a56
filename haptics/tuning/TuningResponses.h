#pragma once

#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// What the microphone heard of each transducer at each place, by itself and at full drive of the
/// plan's duty.
struct TuningResponses
{
    /// P x m, in the readings' unit; NaN: not measured. Levels give it up to a phase for each
    /// place.
    Eigen::MatrixXcd y;
    Eigen::VectorXd noise; ///< P: rms of |error of y|, as silent rows or unused columns show it
    std::vector<std::string> notes; ///< what was filled in or left out, a sentence each
    /// Why nothing can be made of the readings, a sentence; empty: it can.
    std::string refusal;
};

/// Takes the transducers apart. \a expected: P x m, the amplitudes that equal transducers would
/// have, up to a factor. \a clip: level at which the microphone is known to clip, in the readings'
/// unit; 0: not known.
TuningResponses responsesOf(const TuningPlan& plan,
                            const TuningReadings& readings,
                            const Eigen::MatrixXd& expected,
                            double clip = 0.0);

} // namespace midair::haptics
