#include "haptics/sequence/TimeMultiplexer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

bool isField(const SolveReport& report)
{
    return report.stop != StopReason::NOTHING_TO_DO && report.stop != StopReason::REFUSED &&
           report.stop != StopReason::STOPPED;
}

} // namespace

double unitLevel(const SolveReport& report, const ControlPoints& points)
{
    return isField(report) && points.size() > 0 ? report.level_Pa / points.targets.maxCoeff() : 0.0;
}

SolveReport together(const std::vector<SolveReport>& reports)
{
    // A single field's steps are relative to its last one; solvers don't know the steps between
    // fields in turn.
    if (reports.size() == 1) return reports.front();
    SolveReport all = reports.front();
    double squares = 0.0, squaresOfLargest = 0.0;
    int points = 0, fields = 0;
    all.points = all.iterations = all.rowsBuilt = all.leftOut = all.shortPoints = 0;
    all.matrix_ms = all.solve_ms = all.max = all.maxOfLargest = all.loudness = all.level_Pa = 0.0;
    all.meanPhaseStep_rad = all.driveChange = all.audibleChange = all.worstShortfall = 0.0;
    all.message.clear();
    bool chosen = false;
    for (const SolveReport& r : reports)
    {
        all.points += r.points;
        all.iterations += r.iterations;
        all.rowsBuilt += r.rowsBuilt;
        all.leftOut += r.leftOut;
        all.shortPoints += r.shortPoints;
        all.matrix_ms += r.matrix_ms;
        all.solve_ms += r.solve_ms;
        all.max = std::max(all.max, r.max);
        all.maxOfLargest = std::max(all.maxOfLargest, r.maxOfLargest);
        all.level_Pa = std::max(all.level_Pa, r.level_Pa);
        all.worstShortfall = std::max(all.worstShortfall, r.worstShortfall);
        if (all.message.empty() && isField(r)) all.message = r.message;
        // The stop reason of the first field that did not converge; a refusal takes precedence.
        const bool isReason = isField(r) && r.stop != StopReason::CONVERGED && !chosen;
        const bool isEnd = r.stop == StopReason::REFUSED || r.stop == StopReason::STOPPED;
        if (isEnd || isReason)
        {
            all.stop = r.stop;
            all.message = r.message;
            chosen = true;
        }
        if (isEnd) break;
        if (!isField(r)) continue;
        if (!chosen) all.stop = r.stop;
        squares += r.rms * r.rms * (r.points - r.leftOut);
        squaresOfLargest += r.rmsOfLargest * r.rmsOfLargest * (r.points - r.leftOut);
        points += r.points - r.leftOut;
        all.loudness += r.loudness;
        ++fields;
    }
    // The message about missing points is used only if no part has points.
    if (fields == 0 && all.message.empty()) all.message = reports.front().message;
    all.rms = points > 0 ? std::sqrt(squares / points) : 0.0;
    all.rmsOfLargest = points > 0 ? std::sqrt(squaresOfLargest / points) : 0.0;
    if (fields > 0) all.loudness /= fields;
    return all;
}

Eigen::VectorXf TimeMultiplexer::achieved_Pa() const
{
    return _reports.size() == 1 ? _solvers.front()->achieved_Pa() : Eigen::VectorXf();
}

bool TimeMultiplexer::setOptions(const SolverOptions& options)
{
    return std::all_of(_solvers.begin(),
                       _solvers.end(),
                       [&](const auto& solver) { return solver->setOptions(options); });
}

SolveReport TimeMultiplexer::solve(const std::vector<ControlPoints>& parts,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   std::vector<Eigen::VectorXcf>& fields)
{
    if (parts.empty())
        throw base::InputError(
            "fields in turn: there are no points; there must be at least one set");
    Eigen::Index points = 0;
    for (const ControlPoints& part : parts)
        points += part.size();
    if (points > base::kMostPointsInTurn)
        throw base::InputError(fmt::format("fields in turn: the {} fields have {} control points "
                                           "together; there must be at most {}",
                                           parts.size(),
                                           points,
                                           base::kMostPointsInTurn));
    while (_solvers.size() < parts.size())
        _solvers.push_back(_makeSolver());
    fields.resize(parts.size());
    _reports.resize(parts.size());
    double common = 0.0; // Pa per unit of target
    for (std::size_t k = 0; k < parts.size(); ++k)
    {
        _reports[k] = _solvers[k]->solve(parts[k], array, medium, fields[k]);
        if (_reports[k].stop == StopReason::STOPPED)
        {
            for (Eigen::VectorXcf& field : fields)
                field.setZero(array.size());
            return _reports[k];
        }
        const double level = unitLevel(_reports[k], parts[k]);
        if (level > 0.0) common = common > 0.0 ? std::min(common, level) : level;
    }
    const bool absolute = parts.front().absolute;
    for (std::size_t k = 0; k < parts.size() && !absolute && parts.size() > 1; ++k)
    {
        const double level = unitLevel(_reports[k], parts[k]);
        if (!(level > common)) continue;
        scaleField(fields[k], static_cast<float>(common / level), array.drive);
        _reports[k].level_Pa *= common / level;
        _reports[k].loudness *= common / level;
    }
    return together(_reports);
}

} // namespace midair::haptics
