#pragma once

#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Response of each transducer at each place, on its own and at full drive of the plan's duty.
struct TuningResponses
{
    /// P x m, in the readings' unit; NaN: not measured. From levels it is known up to a phase per
    /// place.
    Eigen::MatrixXcd y;
    Eigen::VectorXd noise;          ///< P: rms of |error of y|, from silent rows or unused columns
    std::vector<std::string> notes; ///< notes on what was filled in or left out, a sentence each
    /// Reason, a sentence, if the readings are unusable; otherwise empty.
    std::string refusal;
};

/// Separates the transducers. \a expected: P x m, amplitudes of equal transducers, up to a factor.
/// \a clip: level at which the microphone clips, in the readings' unit; 0: unknown.
TuningResponses responsesOf(const TuningPlan& plan,
                            const TuningReadings& readings,
                            const Eigen::MatrixXd& expected,
                            double clip = 0.0);

} // namespace midair::haptics
