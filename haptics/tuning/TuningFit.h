#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/MicrophoneFit.h"
#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

struct TuningFitOptions
{
    MicrophonePrior prior;
    double relativeHumidity = 0.5; ///< 0 .. 1
    /// 0.01 .. 0.5: a transducer of less gain, beside the median, is dead. Raised to three times
    /// its error, but not beyond 0.4.
    double deadGain = 0.1;
    double clip = 0.0; ///< >= 0, level at which the microphone clips; 0: not known
};

/// What a transducer turned out to be.
enum class TransducerState
{
    FINE,
    REVERSED,    ///< fine, but of the other polarity than most
    DEAD,        ///< of no gain to speak of
    UNSURE,      ///< too much noise to tell whether it is dead; taken as it was measured
    NOT_MEASURED ///< keeps what the array's file says
};

/// The transducers of an array as they are, found by a microphone.
struct TuningFit
{
    /// Why nothing was found, a sentence; empty: the rest holds.
    std::string refusal;
    std::vector<std::string> notes; ///< what was left out or filled in, a sentence each
    MicrophoneFit microphone;
    /// The array with phase offsets (rad, -pi .. pi), gains (of the live ones the median is 1) and
    /// dead ones.
    TransducerArray array;
    std::vector<TransducerState> states; ///< m
    Eigen::VectorXd gainErrors;          ///< m, standard errors by noise alone
    /// Standard deviation of the live ones' phases, polarity aside, and of their gains.
    double phaseSpread_rad = 0.0;
    double gainSpread = 0.0;
    /// Expected rms error of the phases: what places and scatter leave. Of one place the scatter
    /// isn't known and counts as 0.
    double expectedError_rad = 0.0;
    /// Amplitude of a focus at the first place over that of an array that is known perfectly: by
    /// the array's file as it was, and the 1 that is reached by definition is left out.
    double focusBefore = 0.0;

    bool usable() const { return refusal.empty(); }
    std::vector<int> of(TransducerState state) const;
    /// The report, several lines.
    std::string text() const;
};

/// Fits \a array's transducers to \a readings of \a plan. Throws InputError where plan and array
/// don't belong together, or an option is out of range.
TuningFit fitTuning(const TransducerArray& array,
                    const TuningPlan& plan,
                    const TuningReadings& readings,
                    const TuningFitOptions& options = {});

} // namespace midair::haptics
