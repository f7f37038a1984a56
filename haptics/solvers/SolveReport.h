#pragma once

#include "haptics/propagation/SurfaceStatistics.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace midair::haptics
{

enum class StopReason
{
    NOTHING_TO_DO,  ///< no points, or none that can be reached
    CONVERGED,      ///< the error asked for is reached
    STALLED,        ///< no longer improving
    MAX_ITERATIONS, ///< the limit of iterations is reached
    DEADLINE,       ///< the time is up
    SKIPPED,        ///< nothing moved by more than the tolerance
    REFUSED,        ///< the input is not solvable; message says why; activations are zero
    STOPPED ///< SolverOptions::stop asked for it; activations are zero, the next solve starts from nothing
};

const char* stopReasonName(StopReason reason);

/// What was solved and how well, for q as the device plays it (clipped, quantised): the one record of a field's figures. To add
/// one, add it here with its row in kFigures, and fill it in where it is known: summary.json, the kit's report and its
/// statistics show it by themselves.
struct SolveReport
{
    std::string solver;
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< empty, or what the user should know
    int points = 0;      ///< that were asked for
    int transducers = 0; ///< of the array
    int iterations = 0;  ///< of the method; of fields in turn all of them
    int rowsBuilt = 0;   ///< rows of G that were computed anew; the others had not moved
    int leftOut = 0;     ///< points with target 0, or that no transducer reaches
    int shortPoints = 0; ///< absolute targets: points that fall short by more than 1 %
    double rms =
        0.0; ///< sqrt(mean((y_l/(s a_l) - 1)^2)), s = (y.a)/(a.a); with absolute targets s = 1
    double max = 0.0;      ///< the largest of the same
    double loudness = 0.0; ///< E = s |a| / mean_l(sum_i |G_li|)
    double level_Pa =
        0.0; ///< s times the largest target: the peak pressure played where the target is largest
    double capFactor =
        1.0; ///< what keeping to a cap of pressure took off all amplitudes; 1: nothing; 0: silenced
    double worstShortfall =
        0.0; ///< absolute targets: the largest 1 - y_l/a_l, 0 if none falls short
    double meanPhaseStep_rad =
        0.0;                  ///< mean |change of phase| of the transducers from the field before
    double driveChange = 0.0; ///< sum_i |q_i - q_i before|^2 / sum_i |q_i|^2; 0 for the first field
    /// Of that, what lies from 20 Hz to 20 kHz beside the carrier at SolverOptions::updateRate_Hz: see audibleShare().
    double audibleChange = 0.0;
    double matrix_ms = 0.0; ///< the matrix's share of the time
    double solve_ms = 0.0;  ///< the rest of it
    /// What a hand would find between the points. Filled by the caller, since it takes many solves' time; samples == 0: not
    /// measured.
    SurfaceStatistics surface;
};

/// A number of a SolveReport: its name wherever it is shown.
struct FigureRow
{
    const char* name; ///< with its unit
    std::variant<int SolveReport::*, double SolveReport::*> value;
};

inline const std::vector<FigureRow> kFigures = {
    {"points", &SolveReport::points},
    {"transducers", &SolveReport::transducers},
    {"iterations", &SolveReport::iterations},
    {"rms", &SolveReport::rms},
    {"max", &SolveReport::max},
    {"loudness", &SolveReport::loudness},
    {"level_Pa", &SolveReport::level_Pa},
    {"capFactor", &SolveReport::capFactor},
    {"leftOut", &SolveReport::leftOut},
    {"shortPoints", &SolveReport::shortPoints},
    {"worstShortfall", &SolveReport::worstShortfall},
    {"meanPhaseStep_rad", &SolveReport::meanPhaseStep_rad},
    {"driveChange", &SolveReport::driveChange},
    {"audibleChange", &SolveReport::audibleChange},
    {"rowsBuilt", &SolveReport::rowsBuilt},
    {"matrix_ms", &SolveReport::matrix_ms},
    {"solve_ms", &SolveReport::solve_ms},
};

/// All of kFigures by name, and where the surface was measured kSurfaceFigures as "surface.NAME".
std::vector<std::pair<std::string, double>> figuresOf(const SolveReport& report);

/// The figures' one writer: solver, stop, message and all of kFigures, and "surface" where it was measured.
nlohmann::ordered_json toJson(const SolveReport& report);

} // namespace midair::haptics
