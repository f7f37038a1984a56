#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Measured foci of a tuned array at one microphone position, compared with the prediction.
struct FocusFigures
{
    Eigen::Vector3d place; ///< microphone position fitted to the levels of all foci, metres
    double ratio = 0.0;    ///< measured over predicted level, scaled by single transducers
    /// Full width at half pressure of foci that pass the microphone along x, y and z, metres;
    /// infinite: wider than the foci reach.
    Eigen::Vector3d width_m, predictedWidth_m;
};

/// Check after a tuning: strength and width of foci at each place of a focus plan.
struct FocusCheck
{
    std::string refusal; ///< reason, a sentence, if there is no result; empty: the rest is valid
    std::vector<std::string> notes;
    std::vector<FocusFigures> places;

    /// Returns true if every focus has at least \a least of its predicted level.
    bool passes(double least = 0.9) const;
    std::string text() const;
};

/// Compares \a readings of \a plan, of the method focus, with the prediction for \a tuned. Throws
/// InputError if they don't belong together.
FocusCheck
checkFocus(const TransducerArray& tuned, const TuningPlan& plan, const TuningReadings& readings);

} // namespace midair::haptics
