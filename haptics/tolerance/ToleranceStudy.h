#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/sequence/FieldSequence.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Deviation of the array or the air from what a field was solved for.
enum class Deviation
{
    POSITION,    ///< each board as a whole: normal error in x, y and z, m rms each
    TILT,        ///< each board turned about its middle, about x, y and z, degrees rms each
    PHASE,       ///< each transducer's phase: normal error, degrees rms
    TEMPERATURE, ///< warmer air, K
    DEAD         ///< share of randomly chosen silent transducers
};

/// Options of toleranceOf(). isValid() names the first value out of range.
struct ToleranceOptions
{
    std::vector<double> position_m = {1e-4, 2e-4, 5e-4, 1e-3, 2e-3};          ///< 0 .. 0.1
    std::vector<double> tilt_deg = {0.05, 0.1, 0.2, 0.5, 1.0};                ///< 0 .. 45
    std::vector<double> phase_deg = {2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0}; ///< 0 .. 180
    std::vector<double> temperature_K = {-5.0, -2.0, -1.0, 1.0, 2.0, 5.0};    ///< -50 .. 50
    std::vector<double> dead = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1};         ///< 0 .. 1
    int draws = 20;         ///< 1 .. 10,000; random arrays per value, the same for each value
    std::uint64_t seed = 1; ///< equal seeds give equal arrays
    int threads = 1;        ///< 1 .. kMostThreads

    bool isValid(std::string* error = nullptr) const;
};

/// Results for one deviation: median, and the worst tenth of the draws.
struct ToleranceRow
{
    Deviation deviation = Deviation::POSITION;
    double value = 0.0; ///< in the unit of the options
    int draws = 1;      ///< random arrays; temperatures need one
    /// relative error at the points, as FieldFigures::rms; 90 % of the draws are below rms90
    double rms = 0.0, rms90 = 0.0;
    /// E of FieldFigures, for the nominal array; 90 % of the draws are above loudness10
    double loudness = 0.0, loudness10 = 0.0;
    /// pressure of a single focus in the middle of the points, over that of the nominal array; 90 %
    /// of the draws are above focus10
    double focus = 0.0, focus10 = 0.0;
    /// Theory for independent errors, for PHASE and DEAD; otherwise NaN. Phases of s rad leave
    /// e^{-s^2/2} of a focus, a share d of dead transducers 1 - d; phases add s sqrt(n/2m)/E to the
    /// rms of n points, because only the part in phase with a pressure changes it.
    double expectedRms = 0.0, expectedFocus = 0.0;
};

/// All rows, with the nominal result.
struct ToleranceStudy
{
    ToleranceRow nominal; ///< value 0
    std::vector<ToleranceRow> rows;
    int draws = 1;      ///< of the options
    int arrays = 0;     ///< number of arrays played
    double cpu_s = 0.0; ///< processor time of all threads
};

/// Plays \a sequence, made for \a array and \a medium, with arrays and air that deviate in one
/// respect at a time (Monte Carlo), and measures the result at its points. \a sequence has points
/// and is not silent, and its report has the level and loudness there. Throws base::InputError for
/// invalid options and for sequences without points.
ToleranceStudy toleranceOf(const FieldSequence& sequence,
                           const TransducerArray& array,
                           const Medium& medium,
                           const ToleranceOptions& options);

const char* deviationName(Deviation deviation); ///< "position", "tilt", ..
const char* deviationUnit(Deviation deviation); ///< "m", "deg", "deg", "K", "share"

} // namespace midair::haptics
