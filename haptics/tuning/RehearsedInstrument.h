#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningPlan.h"

#include <Eigen/Core>

#include <complex>
#include <cstdint>
#include <random>
#include <vector>

namespace midair::haptics
{

/// Hidden errors of a rehearsal. Transducers are detuned by df ~ N(0, detuning): a resonator of
/// quality Q driven off its resonance has the phase atan(2 Q df/f) and the gain cos(phase).
struct RehearsalOptions
{
    std::uint32_t seed = 1;
    double detuning_Hz = 226.0; ///< >= 0; 15 degrees with kRehearsedQuality
    double reversed = 0.5;      ///< 0 .. 1, share of reversed transducers
    double dead = 0.01;         ///< 0 .. 1, share of dead ones
    double gainSpread = 0.05;   ///< >= 0, additional, relative
    double placeError_m = 2e-3; ///< >= 0, rms of the microphone's distance from its planned place
    /// >= 0: exactly this far from its planned place, in a random direction; 0: placeError_m
    /// applies
    double displacement_m = 0.0;
    double temperature_C = 21.0;   ///< of the air
    double noise_dB = -40.0;       ///< of the microphone, relative to one transducer's median
    double reflections_dB = -20.0; ///< rms of the reflections, relative to the direct sound
    double clip = 0.0;             ///< >= 0, level in Pa where the microphone clips; 0: none
    double sensitivity = 1.0;      ///< > 0, of the microphone, units/Pa
};

/// Quality of the T4010A1 from its circuit (TransducerArray::ringing_s): pi f tau.
constexpr double kRehearsedQuality = 23.6;

/// A microphone in front of an array with hidden errors, which answers each row of a plan. It sums
/// the drives of driveOf() with referencePropagationMatrix(), independently of the fit.
class RehearsedInstrument
{
public:
    /// Throws InputError if \a array doesn't fit \a plan, or an option is out of range.
    RehearsedInstrument(const TransducerArray& array,
                        const TuningPlan& plan,
                        const RehearsalOptions& options);

    /// The true array: with the hidden offsets, gains and dead transducers.
    const TransducerArray& truth() const { return _truth; }
    const std::vector<bool>& reversed() const { return _reversed; } ///< m
    const Eigen::Matrix3Xd& places() const { return _places; }      ///< true microphone places

    /// Returns the reading of row \a row; for levels the imaginary part is 0. Repeated readings of
    /// a row are equal. \a tuned: the array that focuses.
    std::complex<double> reading(int row, const TransducerArray* tuned = nullptr);

private:
    void hideErrors();
    void standAt(int place);

    const TuningPlan _plan;
    const RehearsalOptions _options;
    TransducerArray _truth;
    std::vector<bool> _reversed;
    Eigen::Matrix3Xd _places;
    Eigen::Matrix3Xd _mirrors; ///< 3 x 2 n: a point and a normal of each wall
    std::mt19937 _random;
    int _place = -1;
    Eigen::VectorXcd _heard; ///< m, pressure of each transducer at full drive, Pa, including
                             ///< reflections
    double _noise_Pa = 0.0;
};

} // namespace midair::haptics
