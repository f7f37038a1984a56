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
    /// 0.01 .. 0.5: a transducer of lower gain, relative to the median, is dead. Raised to three
    /// times its error, up to 0.4.
    double deadGain = 0.1;
    double clip = 0.0; ///< >= 0, level at which the microphone clips; 0: unknown
};

/// State of a transducer.
enum class TransducerState
{
    FINE,
    REVERSED,    ///< good, but of the opposite polarity to most
    DEAD,        ///< almost no gain
    UNSURE,      ///< too noisy to tell whether it is dead; the measured values are used
    NOT_MEASURED ///< keeps the values of the array's file
};

/// State of an array's transducers, measured by a microphone.
struct TuningFit
{
    /// Reason, a sentence, if there is no result; empty: the rest is valid.
    std::string refusal;
    std::vector<std::string> notes; ///< notes on what was left out or filled in, a sentence each
    MicrophoneFit microphone;
    /// The array with phase offsets (rad, -pi .. pi), gains (median 1 for live transducers) and
    /// dead ones.
    TransducerArray array;
    std::vector<TransducerState> states; ///< m
    Eigen::VectorXd gainErrors;          ///< m, standard errors due to noise alone
    /// Standard deviation of the live transducers' phases, ignoring polarity, and of their gains.
    double phaseSpread_rad = 0.0;
    double gainSpread = 0.0;
    /// Expected rms error of the phases, from places and scatter. For a single place the scatter is
    /// unknown and counts as 0.
    double expectedError_rad = 0.0;
    /// Amplitude of a focus at the first place relative to a perfectly known array, with the
    /// array's previous file. After tuning it is 1 by definition.
    double focusBefore = 0.0;

    bool usable() const { return refusal.empty(); }
    std::vector<int> of(TransducerState state) const;
    /// The report, several lines.
    std::string text() const;
};

/// Fits \a array's transducers to \a readings of \a plan. Throws InputError if plan and array don't
/// belong together, or an option is out of range.
TuningFit fitTuning(const TransducerArray& array,
                    const TuningPlan& plan,
                    const TuningReadings& readings,
                    const TuningFitOptions& options = {});

} // namespace midair::haptics
