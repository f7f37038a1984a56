#include "haptics/solvers/SolveReport.h"

#include <nlohmann/json.hpp>

namespace midair::haptics
{

const char* stopReasonName(StopReason reason)
{
    switch (reason)
    {
    case StopReason::NOTHING_TO_DO:
        return "nothing to do";
    case StopReason::CONVERGED:
        return "converged";
    case StopReason::STALLED:
        return "stalled";
    case StopReason::MAX_ITERATIONS:
        return "iteration limit";
    case StopReason::DEADLINE:
        return "deadline";
    case StopReason::SKIPPED:
        return "skipped";
    case StopReason::REFUSED:
        return "refused";
    case StopReason::STOPPED:
        return "stopped";
    }
    return "unknown";
}

std::vector<std::pair<std::string, double>> figuresOf(const SolveReport& report)
{
    std::vector<std::pair<std::string, double>> figures;
    const auto add = [&](const std::string& name, const auto& row, const auto& record)
    {
        std::visit([&](auto member) { figures.emplace_back(name, double(record.*member)); },
                   row.value);
    };
    for (const FigureRow& row : kFigures)
        add(row.name, row, report);
    if (report.surface.samples > 0)
        for (const SurfaceFigureRow& row : kSurfaceFigures)
            add(std::string("surface.") + row.name, row, report.surface);
    return figures;
}

nlohmann::ordered_json toJson(const SolveReport& report)
{
    nlohmann::ordered_json json = {{"solver", report.solver},
                                   {"stop", stopReasonName(report.stop)},
                                   {"message", report.message}};
    for (const FigureRow& row : kFigures)
        std::visit([&](auto member) { json[row.name] = report.*member; }, row.value);
    if (report.surface.samples == 0) return json;
    for (const SurfaceFigureRow& row : kSurfaceFigures)
        std::visit([&](auto member) { json["surface"][row.name] = report.surface.*member; },
                   row.value);
    return json;
}

} // namespace midair::haptics
