#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// What a microphone says of the foci of a tuned array at one place, beside what the array should
/// do.
struct FocusFigures
{
    Eigen::Vector3d place; ///< of the microphone, as the levels of all foci say, metres
    double ratio = 0.0;    ///< measured over predicted level; single transducers are the scale
    /// Full width at half pressure of foci that pass the microphone along x, y and z, metres;
    /// infinite: more than the foci reach.
    Eigen::Vector3d width_m, predictedWidth_m;
};

/// The check after a tuning: how strong and how wide foci are at each place of a plan of foci.
struct FocusCheck
{
    std::string refusal; ///< why nothing can be said, a sentence; empty: the rest holds
    std::vector<std::string> notes;
    std::vector<FocusFigures> places;

    /// True if every focus has at least \a least of its predicted level.
    bool passes(double least = 0.9) const;
    std::string text() const;
};

/// Compares \a readings of \a plan, of the method focus, with what \a tuned should do. Throws
/// InputError where they don't belong together.
FocusCheck
checkFocus(const TransducerArray& tuned, const TuningPlan& plan, const TuningReadings& readings);

} // namespace midair::haptics
