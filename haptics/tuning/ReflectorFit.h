#pragma once

#include "haptics/array/Reflector.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/tuning/MicrophoneFit.h"
#include "haptics/tuning/TuningReadings.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

struct ReflectorFitOptions
{
    MicrophonePrior prior;         ///< of the microphone's places and the air
    double relativeHumidity = 0.5; ///< 0 .. 1
    double clip = 0.0;             ///< >= 0, level at which the microphone clips; 0: unknown
    /// 0 .. 0.02: largest distance of the reflector from its guess, along its normal, metres
    double search_m = 6e-3;
    /// >= 0, standard error of the guess's reflectionPhase_rad. Hard, smooth plates turn it little.
    double phaseError_rad = 0.26;
    /// 0 .. 0.1: largest tilt of its normal from the guess, about each of its sides, rad
    double tilt_rad = 0.035;
};

/// Place and reflection of a flat reflector, found with one microphone before a tuned array.
struct ReflectorFit
{
    /// Reason, a sentence, if there is no result; empty: the rest is valid.
    std::string refusal;
    std::vector<std::string> notes; ///< notes on the readings, a sentence each
    /// The guess, moved along its normal and tilted, with what it reflects; accuracy_mm is the
    /// standard error of its place along its normal, over its size.
    Reflector reflector;
    Eigen::Matrix3Xd places; ///< 3 x P, of the microphone, metres
    double soundSpeed_m_s = 0.0;
    /// rms of what the model leaves of the readings, over their rms: without the reflector, with it
    double before = 0.0, after = 0.0;
    double placeError_m = 0.0; ///< standard error of its centre along its normal
    Eigen::Vector2d tiltErrors_rad = Eigen::Vector2d::Zero(); ///< about along, about across
    double reflectionError = 0.0, reflectionPhaseError_rad = 0.0;

    bool usable() const { return refusal.empty(); }
    /// Returns true if fields are corrected for a reflector of this accuracy.
    bool isUseful() const { return reflector.accuracy_mm <= kMostCorrectedAccuracy_mm; }
    /// The report, several lines.
    std::string text() const;
};

/// Fits the reflector \a guess, at rest, to complex \a readings of \a plan (method single or
/// hadamard) by \a tuned, an array whose phases and gains were found without it:
///     y_pi = c_p G_pi,   G: referencePropagationMatrix() with the reflectors of tuned and this one
/// with a factor c_p for each place of the microphone. Sound that it reflects arrives later, so its
/// phase turns by 2 k cos(angle) for each metre: starts a sixteenth of a wavelength apart along the
/// normal, the best of which are refined by Levenberg-Marquardt steps over the reflector's place,
/// two tilts, reflection and its phase, the microphone's places and the speed of sound. Refuses
/// readings that the reflector doesn't explain better than its absence. Throws InputError if
/// arguments don't belong together or an option is out of range.
ReflectorFit fitReflector(const TransducerArray& tuned,
                          const TuningPlan& plan,
                          const TuningReadings& readings,
                          const Reflector& guess,
                          const ReflectorFitOptions& options = {});

} // namespace midair::haptics
