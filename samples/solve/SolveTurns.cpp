#include "samples/solve/SolveTurns.h"

#include "haptics/base/InputError.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/propagation/AudibleChange.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/sequence/SpeckleCycle.h"
#include "haptics/sequence/TimeMultiplexer.h"
#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SurfaceSampler.h"

#include <algorithm>
#include <cstdio>

namespace midair::samples
{

namespace
{

Turns solveSubsets(const std::vector<haptics::ControlPoints>& sets,
                   const TurnOptions& options,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium)
{
    Turns turns;
    for (const haptics::ControlPoints& set : sets)
        for (haptics::ControlPoints& part : haptics::subsetsInTurn(set, options.subsets))
            turns.parts.push_back(std::move(part));
    haptics::TimeMultiplexer fields(
        [&] { return haptics::makeSolver(options.solver, options.solverOptions); });
    turns.report = fields.solve(turns.parts, array, medium, turns.fields);
    if (turns.report.stop == haptics::StopReason::REFUSED)
        throw base::InputError(turns.report.message);
    haptics::alignFields(turns.fields, array.drive);
    return turns;
}

// Without subsets: the fields in the order in which they differ least, so that the sets have to follow.
Turns solveCycle(const std::vector<haptics::ControlPoints>& sets,
                 const TurnOptions& options,
                 const Eigen::Matrix3Xd& surface,
                 const haptics::TransducerArray& array,
                 const haptics::Medium& medium)
{
    haptics::SpeckleCycleOptions cycleOptions;
    cycleOptions.solver = options.solver;
    cycleOptions.solverOptions = options.solverOptions;
    cycleOptions.sweeps = options.sweeps;
    haptics::SpeckleCycle cycle(cycleOptions);
    cycle.solve(sets, options.sweeps > 0 ? surface : Eigen::Matrix3Xd(3, 0), array, medium);
    Turns turns;
    turns.fields = cycle.smoothed(options.cycleSteps);
    turns.report = haptics::together(cycle.reports());
    const auto step = static_cast<std::size_t>(options.cycleSteps + 1);
    turns.parts.resize(turns.fields.size());
    for (std::size_t k = 0; k < sets.size(); ++k)
        turns.parts[k * step] = sets[static_cast<std::size_t>(cycle.order()[k])];
    return turns;
}

} // namespace

namespace
{

/// Leaves out those that aren't whole within the array's reach, and says so.
void keepWithinReach(std::vector<haptics::Outline>& outlines,
                     const haptics::TransducerArray& array,
                     double wavelength_m)
{
    const haptics::Workspace workspace(array, wavelength_m, haptics::SelectorOptions());
    const auto isOutside = [&](const haptics::Outline& outline)
    {
        const Eigen::Matrix3Xd points = outline.points(0.5 * wavelength_m);
        for (Eigen::Index k = 0; k < points.cols(); ++k)
            if (workspace.judge(points.col(k)) != haptics::Workspace::Verdict::INSIDE) return true;
        return false;
    };
    const std::size_t before = outlines.size();
    outlines.erase(std::remove_if(outlines.begin(), outlines.end(), isOutside), outlines.end());
    if (outlines.size() < before)
        std::fprintf(stderr,
                     "midair-solve: solves for %zu of %zu outlines: %zu are not whole within the "
                     "array's reach\n",
                     outlines.size(),
                     before,
                     before - outlines.size());
}

/// One field that is silent, as a solver's without points.
Turns silentTurns(const std::string& solver, const haptics::TransducerArray& array)
{
    Turns turns;
    turns.fields.push_back(Eigen::VectorXcf::Zero(array.size()));
    turns.parts.resize(1);
    turns.report.solver = solver;
    turns.report.transducers = array.size();
    turns.report.message = "there are no control points";
    return turns;
}

} // namespace

Turns solveInTurn(const std::vector<haptics::ControlPoints>& sets,
                  const TurnOptions& options,
                  const Eigen::Matrix3Xd& surface,
                  const haptics::TransducerArray& array,
                  const haptics::Medium& medium)
{
    Turns turns = options.subsets > 1 ? solveSubsets(sets, options, array, medium)
                                      : solveCycle(sets, options, surface, array, medium);
    const haptics::CycleSteps steps = haptics::cycleSteps(turns.fields);
    turns.report.meanPhaseStep_rad = steps.meanPhaseStep_rad;
    turns.report.driveChange = steps.driveChange;
    turns.report.audibleChange = steps.driveChange * haptics::audibleShare(options.fieldRate_Hz);
    return turns;
}

Turns solveOutlines(const haptics::TriangleMesh& mesh,
                    const Eigen::Isometry3d& pose,
                    double pressure_Pa,
                    const haptics::TransducerArray& array,
                    const haptics::Medium& medium)
{
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    std::vector<haptics::Outline> outlines =
        haptics::featureOutlines(mesh, haptics::SamplerOptions().creaseAngle_rad, wavelength_m);
    for (haptics::Outline& outline : outlines)
        outline.vertices = (pose * outline.vertices).eval();
    if (!outlines.empty())
    {
        keepWithinReach(outlines, array, wavelength_m);
        if (outlines.empty()) return silentTurns("outline", array);
    }
    haptics::OutlineHologram hologram;
    Turns turns;
    turns.fields.resize(1);
    const haptics::OutlineReport found =
        hologram.solve(outlines, array, medium, turns.fields.front());
    turns.parts.push_back(hologram.points());
    haptics::ControlPoints& points = turns.parts.front();
    const Eigen::VectorXd y =
        haptics::pressureAt(points.positions, array, medium, turns.fields.front(), 2)
            .cwiseAbs()
            .cast<double>();
    if (pressure_Pa > 0.0)
    {
        points.targets *= pressure_Pa;
        const double share = y.size() > 0 ? pressure_Pa / y.mean() : 1.0;
        if (share < 1.0)
            haptics::scaleField(turns.fields.front(), static_cast<float>(share), array.drive);
    }
    turns.report.solver = "outline";
    turns.report.stop = haptics::StopReason::STALLED;
    turns.report.points = points.size();
    turns.report.transducers = array.size();
    turns.report.iterations = found.corrections;
    turns.report.solve_ms = found.solve_ms;
    return turns;
}

} // namespace midair::samples
