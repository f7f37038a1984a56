#pragma once

#include "haptics/propagation/SurfaceStatistics.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace midair::haptics
{

/// Why a solve ended.
enum class StopReason
{
    NOTHING_TO_DO,  ///< there are no points with a target above 0 in reach; activations are zero
    CONVERGED,      ///< the error is at most the options' tolerance
    STALLED,        ///< the error no longer falls, or all of it comes from rounding
    MAX_ITERATIONS, ///< the options' or the method's limit of iterations is reached
    DEADLINE,       ///< the options' deadline has passed
    SKIPPED,        ///< no point moved by more than the options' tolerance; the last field stays
    REFUSED,        ///< the input can't be solved; message says why; activations are zero
    STOPPED         ///< stopped on request; activations are zero, and the next solve starts cold
};

/// Returns a reason as text: "nothing to do", "converged", "iteration limit" and so on.
const char* stopReasonName(StopReason reason);

/// What was solved and how well, for q as the device plays it (clipped and rounded to its levels).
/// Symbols: y = |G q| at the points, a their targets, s = (y.a)/(a.a) the fitted level.
/// This is the one record of a field's figures. To add a figure, add it here and its row to
/// kFigures, and set it where it is known; summary.json and the kit's report and statistics then
/// show it.
struct SolveReport
{
    std::string solver; ///< the method's name
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< what the user should know; empty: nothing
    int points = 0;      ///< points given, including those left out
    int transducers = 0;
    int iterations = 0;
    /// sqrt(mean((y_l/(s a_l) - 1)^2)), the relative rms error; with targets in Pa s = 1
    double rms = 0.0;
    double max = 0.0; ///< largest |y_l/(s a_l) - 1|, with the same s
    /// E = s |a| / mean_l(sum_i |G_li|); 1: the energy of one focus, shared among the points
    double loudness = 0.0;
    double level_Pa = 0.0; ///< fitted peak pressure at the points with the largest target
    /// 0 .. 1; factor on all amplitudes that keeps a pressure cap. 1: no effect; 0: silenced
    double capFactor = 1.0;
    double matrix_ms = 0.0;         ///< time to build G
    double solve_ms = 0.0;          ///< time for the rest of the solve
    int rowsBuilt = 0;              ///< rows of G that were computed; the others were kept
    int leftOut = 0;                ///< points with target 0 or out of the array's reach
    int shortPoints = 0;            ///< targets in Pa: points that fall short by more than 1 %
    double worstShortfall = 0.0;    ///< targets in Pa: largest 1 - y_l/a_l; 0: none falls short
    double meanPhaseStep_rad = 0.0; ///< mean |change of a transducer's phase| from the last field
    /// sum_i |q_i - last q_i|^2 / sum_i |q_i|^2: relative energy of the drive's change; 0 for the
    /// first field
    double driveChange = 0.0;
    /// Part of driveChange within 20 Hz to 20 kHz of the carrier, at the options' updateRate_Hz
    /// (audibleShare())
    double audibleChange = 0.0;
    /// Radiation pressure over the surfaces, between the points too. Filled by the caller with
    /// surfaceStatistics(), which takes as long as many solves; in a live scene it belongs to the
    /// newest field that was measured. samples == 0: not measured.
    SurfaceStatistics surface;
};

/// A figure of a SolveReport with the name under which it is shown.
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

/// Returns all of kFigures by name and, if the surface was measured, kSurfaceFigures as
/// "surface.NAME".
std::vector<std::pair<std::string, double>> figuresOf(const SolveReport& report);

/// Returns figures as figuresOf() gives them as JSON: {NAME: value, .., "surface": {NAME: value,
/// ..}}, the latter if there are any. All files get the figures from here.
nlohmann::ordered_json toJson(const std::vector<std::pair<std::string, double>>& figures);

/// Returns solver, stop and message, followed by the figures.
nlohmann::ordered_json toJson(const SolveReport& report);

} // namespace midair::haptics
