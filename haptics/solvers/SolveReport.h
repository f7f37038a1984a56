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
    NOTHING_TO_DO,  ///< there are no points, or none that can be reached
    CONVERGED,      ///< the error that was asked for is reached
    STALLED,        ///< the error no longer falls, or all of it comes from rounding
    MAX_ITERATIONS, ///< the options' or the method's limit of iterations is reached
    DEADLINE,       ///< the options' deadline has passed
    SKIPPED,        ///< nothing moved by more than the options' tolerance; the last field stays
    REFUSED,        ///< the input can't be solved; message says why; activations are zero
    STOPPED         ///< the options' token asked for it; activations are zero, the next start cold
};

/// A reason as text: "nothing to do", "converged", "iteration limit" and so on.
const char* stopReasonName(StopReason reason);

/// What was solved and how well, for q as the device plays it (clipped and rounded to its levels).
/// Symbols: y = |G q| at the points, a their targets, s = (y.a)/(a.a) the fitted level.
/// This is the one record of a field's figures: to add one, add it here with its row in kFigures,
/// and fill it in where it is known; summary.json and the kit's report and statistics then show it.
struct SolveReport
{
    std::string solver; ///< the method's name
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< what the user should know; empty: nothing
    int points = 0;      ///< as given, those that were left out among them
    int transducers = 0;
    int iterations = 0;
    /// sqrt(mean((y_l/(s a_l) - 1)^2)); with targets in Pa s = 1. 0.01: one percent.
    double rms = 0.0;
    double max = 0.0; ///< the largest |y_l/(s a_l) - 1|
    /// E = s |a| / mean_l(sum_i |G_li|): 1 is as loud as one focus's energy, shared among the
    /// points.
    double loudness = 0.0;
    double level_Pa = 0.0; ///< peak pressure that is played where the target is largest
    /// 0 .. 1; the factor on all amplitudes that kept to a cap of pressure. 1: none; 0: silenced.
    double capFactor = 1.0;
    double matrix_ms = 0.0;         ///< to build G
    double solve_ms = 0.0;          ///< for all the rest
    int rowsBuilt = 0;              ///< rows of G that were computed anew; the others had not moved
    int leftOut = 0;                ///< points with target 0, or that no transducer reaches
    int shortPoints = 0;            ///< targets in Pa: points that fall short by more than 1 %
    double worstShortfall = 0.0;    ///< targets in Pa: the largest 1 - y_l/a_l; 0: none falls short
    double meanPhaseStep_rad = 0.0; ///< mean |change of a transducer's phase| from the last field
    /// sum_i |q_i - q_i before|^2 / sum_i |q_i|^2: the energy of the drive's change. 0 for the
    /// first field.
    double driveChange = 0.0;
    /// The part of driveChange that lies from 20 Hz to 20 kHz beside the carrier at the options'
    /// updateRate_Hz (audibleShare()).
    double audibleChange = 0.0;
    /// What a hand would find between the points. Filled by the caller with surfaceStatistics(),
    /// which takes the time of many solves; in a live scene it belongs to the newest field that was
    /// measured. samples == 0: not measured.
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

/// The one writer of figures, as figuresOf() gives them: {NAME: value, .., "surface": {NAME: value,
/// ..}}, the latter where there are any.
nlohmann::ordered_json toJson(const std::vector<std::pair<std::string, double>>& figures);

/// Solver, stop and message, then the figures.
nlohmann::ordered_json toJson(const SolveReport& report);

} // namespace midair::haptics
