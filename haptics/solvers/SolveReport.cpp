#include "haptics/solvers/SolveReport.h"

#include <cstdint>

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
    case StopReason::SILENCED:
        return "silenced";
    }
    return "unknown";
}

namespace
{

const std::string kSurface = "surface.";

// A figure by name with the type of its row, so that whole numbers are written without a point.
template<typename Rows>
nlohmann::ordered_json asIts(const Rows& rows, const std::string& name, double value)
{
    for (const auto& row : rows)
        if (row.name == name && row.value.index() == 0) return static_cast<std::int64_t>(value);
    return value;
}

} // namespace

std::vector<std::pair<std::string, double>> figuresOf(const SolveReport& report)
{
    std::vector<std::pair<std::string, double>> figures;
    const auto add = [&](const std::string& name, const auto& row, const auto& record)
    {
        std::visit([&](auto member) { figures.emplace_back(name, double(record.*member)); },
                   row.value);
    };
    for (const auto& row : kFigures)
        add(row.name, row, report);
    if (report.surface.samples > 0)
        for (const auto& row : kSurfaceFigures)
            add(kSurface + row.name, row, report.surface);
    return figures;
}

nlohmann::ordered_json toJson(const std::vector<std::pair<std::string, double>>& figures)
{
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const auto& [name, value] : figures)
        if (name.compare(0, kSurface.size(), kSurface) != 0)
            json[name] = asIts(kFigures, name, value);
        else
        {
            const std::string own = name.substr(kSurface.size());
            json["surface"][own] = asIts(kSurfaceFigures, own, value);
        }
    return json;
}

nlohmann::ordered_json toJson(const SolveReport& report)
{
    nlohmann::ordered_json json = {{"solver", report.solver},
                                   {"stop", stopReasonName(report.stop)},
                                   {"message", report.message}};
    json.update(toJson(figuresOf(report)));
    return json;
}

} // namespace midair::haptics
