#pragma once

#include "haptics/propagation/SurfaceStatistics.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace midair::haptics
{

/// Reason for the end of a solve.
enum class StopReason
{
    NOTHING_TO_DO,  ///< no point in reach has a target above 0; activations are zero
    CONVERGED,      ///< the error is at most the options' tolerance
    STALLED,        ///< the error no longer falls, or is entirely due to rounding
    MAX_ITERATIONS, ///< the options' or the method's limit of iterations is reached
    DEADLINE,       ///< the options' deadline has passed
    SKIPPED,        ///< no point moved by more than the options' tolerance; the last field stays
    REFUSED,        ///< the input can't be solved, for the reason in message; activations are zero
    STOPPED,        ///< stopped on request; activations are zero, and the next solve starts cold
    SILENCED ///< solved but not played: the array's levels are not low enough for a cap or a target
};

/// Returns a reason as text: "nothing to do", "converged", "iteration limit" and so on.
const char* stopReasonName(StopReason reason);

/// Input, method and quality of a solve. Callers measure the surface with surfaceStatistics().
struct SolveReport : FieldFigures
{
    std::string solver; ///< the method's name
    StopReason stop = StopReason::NOTHING_TO_DO;
    std::string message; ///< message for the user; may be empty
    int rowsBuilt = 0;   ///< rows of G that were computed; the others were kept
};

/// All figures of a SolveReport.
inline const std::vector<FigureRow<SolveReport>> kFigures = []
{
    std::vector<FigureRow<SolveReport>> rows;
    for (const FigureRow<FieldFigures>& row : kFieldFigures)
        std::visit([&](auto value) { rows.push_back({row.name, value}); }, row.value);
    rows.push_back({"rowsBuilt", &SolveReport::rowsBuilt});
    return rows;
}();

/// Returns all of kFigures by name and, if the surface was measured, kSurfaceFigures as
/// "surface.NAME".
std::vector<std::pair<std::string, double>> figuresOf(const SolveReport& report);

/// Returns figures of figuresOf() as JSON: {NAME: value, .., "surface": {NAME: value, ..}}, the
/// latter if measured. All files get their figures from here.
nlohmann::ordered_json toJson(const std::vector<std::pair<std::string, double>>& figures);

/// Returns solver, stop and message, followed by the figures.
nlohmann::ordered_json toJson(const SolveReport& report);

} // namespace midair::haptics
