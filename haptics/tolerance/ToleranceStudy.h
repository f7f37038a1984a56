#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/sequence/FieldSequence.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// How the array or the air may differ from what a field was solved for.
enum class Deviation
{
    POSITION,    ///< each board, as a whole, is off by a normal error in x, y and z, m rms each
    TILT,        ///< each board is turned about its middle, about x, y and z, degrees rms each
    PHASE,       ///< each transducer's phase is off by a normal error, degrees rms
    TEMPERATURE, ///< the air is warmer by this, K
    DEAD         ///< this share of the transducers, chosen at random, is silent
};

/// What is asked of toleranceOf(). isValid() names the first value out of range.
struct ToleranceOptions
{
    std::vector<double> position_m = {1e-4, 2e-4, 5e-4, 1e-3, 2e-3};          ///< 0 .. 0.1
    std::vector<double> tilt_deg = {0.05, 0.1, 0.2, 0.5, 1.0};                ///< 0 .. 45
    std::vector<double> phase_deg = {2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0}; ///< 0 .. 180
    std::vector<double> temperature_K = {-5.0, -2.0, -1.0, 1.0, 2.0, 5.0};    ///< -50 .. 50
    std::vector<double> dead = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1};         ///< 0 .. 1
    int draws = 20;         ///< 1 .. 10,000; random arrays for each value, the same at each
    std::uint64_t seed = 1; ///< the same seed gives the same arrays
    int threads = 1;        ///< 1 .. kMostThreads

    bool isValid(std::string* error = nullptr) const;
};

/// What is left of a field at one deviation: median, and the tenth that fares worst, of the draws.
struct ToleranceRow
{
    Deviation deviation = Deviation::POSITION;
    double value = 0.0; ///< in the unit of the options
    int draws = 1;      ///< random arrays; temperatures need one
    /// relative error at the points, as FieldFigures::rms; 90 % of the draws are below the second
    double rms = 0.0, rms90 = 0.0;
    /// E of FieldFigures, against the array as it was meant; 90 % of the draws are above the second
    double loudness = 0.0, loudness10 = 0.0;
    /// pressure of a single focus in the middle of the points, over what it has in the array as it
    /// was meant; 90 % of the draws are above the second
    double focus = 0.0, focus10 = 0.0;
    /// What theory says of independent errors, for PHASE and DEAD; else NaN. Phases of s rad leave
    /// e^{-s^2/2} of a focus, a share d of dead ones 1 - d; phases add s sqrt(n/2m)/E to the rms of
    /// n points, as only what is in step with a pressure changes it.
    double expectedRms = 0.0, expectedFocus = 0.0;
};

/// All rows, and what they begin with.
struct ToleranceStudy
{
    ToleranceRow nominal; ///< value 0
    std::vector<ToleranceRow> rows;
    int draws = 1;      ///< of the options
    int arrays = 0;     ///< that were played
    double cpu_s = 0.0; ///< time of the processor, all threads together
};

/// Plays \a sequence, which was made for \a array and \a medium, with arrays and air that deviate
/// from them by one thing at a time (Monte Carlo), and measures what is left at its points. \a
/// sequence has points and sounds, and its report has the level and loudness that it has there.
/// Throws base::InputError for options that are not valid and for sequences without points.
ToleranceStudy toleranceOf(const FieldSequence& sequence,
                           const TransducerArray& array,
                           const Medium& medium,
                           const ToleranceOptions& options);

const char* deviationName(Deviation deviation); ///< "position", "tilt", ..
const char* deviationUnit(Deviation deviation); ///< "m", "deg", "deg", "K", "share"

} // namespace midair::haptics
