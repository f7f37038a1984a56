#include "samples/solve/Solution.h"

#include "device/DriveEncoder.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/InputError.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/TimeMultiplexer.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"

#include <algorithm>
#include <cstdio>

namespace midair::samples
{

using base::InputError;

namespace
{

Eigen::Isometry3d poseOf(const SolveArguments& arguments)
{
    const auto angle = [&](int axis)
    { return arguments.rotation_deg[static_cast<std::size_t>(axis)] * M_PI / 180.0; };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(
        Eigen::Vector3d(arguments.position[0], arguments.position[1], arguments.position[2]));
    pose.rotate(Eigen::AngleAxisd(angle(2), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(angle(1), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(angle(0), Eigen::Vector3d::UnitX()));
    return pose;
}

/// The model's samples in the array frame, a set for each field; every target 1, or the pressure asked for.
std::vector<haptics::PosedObject> sampleModel(const SolveArguments& arguments, Solution& solution)
{
    solution.mesh = haptics::readObj(arguments.model);
    if (arguments.size_m > 0.0) solution.mesh = solution.mesh.scaledTo(arguments.size_m);
    solution.pose = poseOf(arguments);
    haptics::SamplerOptions options;
    options.spacing_m = arguments.spacing_m > 0.0
                            ? arguments.spacing_m
                            : solution.medium.wavelength(solution.array.frequency_Hz);
    options.sampling = arguments.sampling;
    solution.absolute = arguments.pressure_Pa > 0.0;

    std::vector<haptics::PosedObject> objects;
    for (const haptics::SurfaceSamples& samples :
         haptics::sampleSurfaceSets(solution.mesh, options, arguments.cycle))
    {
        haptics::PosedObject& object = objects.emplace_back();
        object.pose(samples, solution.pose);
        object.spacing_m = options.spacing_m;
        if (solution.absolute) object.target = arguments.pressure_Pa;
    }
    return objects;
}

/// Points that the user lists are taken as they are, but for doubles.
haptics::PosedObject readPoints(const SolveArguments& arguments, Solution& solution)
{
    const haptics::ControlPoints points =
        readControlPoints(arguments.pointsFile, solution.absolute);
    haptics::PosedObject object;
    object.positions = points.positions;
    object.normals = points.normals;
    object.intensity = points.targets.cast<float>();
    object.spacing_m = 1e-6;
    return object;
}

/// Leaves out what the array can't reach, and says so.
haptics::ControlPoints selectPoints(const SolveArguments& arguments,
                                    const haptics::PosedObject& object,
                                    const Solution& solution)
{
    haptics::SelectorOptions options;
    options.maxPoints = 2000;
    options.crowding = arguments.crowding;
    const haptics::Workspace workspace(
        solution.array, solution.medium.wavelength(solution.array.frequency_Hz), options);
    haptics::Selection selection = haptics::selectControlPoints({object}, workspace, options);
    const std::string left = selection.report.summary();
    if (!left.empty()) std::fprintf(stderr, "midair-solve: solves for %s\n", left.c_str());
    return std::move(selection.points);
}

/// What the array makes of a drive: its amplitudes are rounded to the levels that it has.
Eigen::VectorXcf playedBy(const haptics::TransducerArray& array, const device::DriveSignal& signal)
{
    std::vector<std::complex<float>> played;
    device::decode(signal, played);
    const std::vector<float>& levels = array.drive.amplitudeLevels;
    for (std::complex<float>& q : played)
    {
        const float amplitude = std::abs(q);
        if (levels.empty() || !(amplitude > 0.0f)) continue;
        const auto above = std::lower_bound(levels.begin(), levels.end(), amplitude);
        float nearest = above == levels.end() ? levels.back() : *above;
        if (above != levels.end() && above != levels.begin() &&
            amplitude - *(above - 1) < *above - amplitude)
            nearest = *(above - 1);
        q *= nearest / amplitude;
    }
    return Eigen::Map<Eigen::VectorXcf>(played.data(), static_cast<Eigen::Index>(played.size()));
}

bridge::PressureCap capOf(const SolveArguments& arguments, const haptics::TransducerArray& array)
{
    device::DriveAbility ability;
    ability.amplitudes = array.drive.amplitudeLevels;
    return {arguments.maxPressure_Pa,
            [&array](const device::DriveSignal& signal) { return playedBy(array, signal); },
            std::move(ability)};
}

void holdToCap(const SolveArguments& arguments, Solution& solution)
{
    bridge::CappedField field =
        capOf(arguments, solution.array)
            .hold({solution.points.positions, {&solution.array}, solution.medium, false, 2},
                  solution.signal);
    solution.parts.capFactor = field.factor;
    if (field.factor >= 1.0) return;
    solution.played = std::move(field.played);
    device::encode(
        solution.played.data(), static_cast<int>(solution.played.size()), solution.signal);
    bridge::rate(solution.points, field.achieved_Pa, solution.absolute, solution.report);
}

TurnOptions turnOptions(const SolveArguments& arguments, const Solution& solution)
{
    TurnOptions options;
    options.solver = arguments.solver.empty() ? haptics::solverNames().front() : arguments.solver;
    options.solverOptions.absoluteTargets = solution.absolute;
    options.solverOptions.threads = 2;
    options.solverOptions.loudness = arguments.loudness;
    options.subsets = arguments.subsets;
    options.cycleSteps = arguments.cycleSteps;
    options.sweeps = arguments.sweeps;
    options.fieldRate_Hz = arguments.fieldRate_Hz;
    return options;
}

/// Targets in Pa: as they are, or at the level that was reached.
void fitTargets(Solution& solution)
{
    const Eigen::VectorXd& a = solution.points.targets;
    const bool relative = !solution.absolute && a.squaredNorm() > 0.0;
    solution.target_Pa = relative ? a * haptics::fittedLevel(solution.achieved_Pa, a) : a;
}

void solve(const SolveArguments& arguments, Solution& solution)
{
    const TurnOptions options = turnOptions(arguments, solution);
    const auto solver = haptics::makeSolver(options.solver, options.solverOptions);
    Eigen::VectorXcf q;
    solution.report = solver->solve(solution.points, solution.array, solution.medium, q);

    device::encode(q.data(), static_cast<int>(q.size()), solution.signal);
    solution.played = playedBy(solution.array, solution.signal);
    if (arguments.maxPressure_Pa > 0.0) holdToCap(arguments, solution);
    const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(
        solution.points.positions, solution.array, solution.medium);
    solution.achieved_Pa = (G * solution.played.cast<std::complex<double>>()).cwiseAbs();
    fitTargets(solution);
}

Eigen::VectorXd achievedBy(const Eigen::VectorXcf& q,
                           const haptics::ControlPoints& points,
                           const Solution& solution)
{
    return haptics::pressureAt(points.positions, solution.array, solution.medium, q, 2)
        .cwiseAbs()
        .cast<double>();
}

/// Fields in turn, or outlines, as the drive that is written plays them.
void playTurns(const SolveArguments& arguments, Turns turns, Solution& solution)
{
    solution.points = {};
    for (const haptics::ControlPoints& part : turns.parts)
        haptics::append(solution.points, part);
    if (arguments.maxPressure_Pa > 0.0)
    {
        solution.parts.capFactor =
            capOf(arguments, solution.array)
                .holdAll({solution.points.positions, {&solution.array}, solution.medium, false, 2},
                         turns.fields);
    }
    for (std::size_t k = 0; k < turns.fields.size(); ++k)
    {
        Eigen::VectorXcf& q = turns.fields[k];
        device::DriveSignal signal;
        device::encode(q.data(), static_cast<int>(q.size()), signal);
        q = playedBy(solution.array, signal);
        solution.signals.push_back(signal);
        if (k >= turns.parts.size()) continue;
        const Eigen::VectorXd part = achievedBy(q, turns.parts[k], solution);
        solution.achieved_Pa.conservativeResize(solution.achieved_Pa.size() + part.size());
        solution.achieved_Pa.tail(part.size()) = part;
    }
    solution.signal = solution.signals.front();
    solution.played = turns.fields.front();
    solution.report = turns.report;
    bridge::rate(
        solution.points, solution.achieved_Pa.cast<float>(), solution.absolute, solution.report);
    solution.parts.fields = static_cast<int>(turns.fields.size());
    solution.parts.fieldRate_Hz = arguments.fieldRate_Hz;
    fitTargets(solution);
    solution.turns = std::move(turns);
}

/// Samples of what is to be felt, a fifth of a wavelength apart at most.
Eigen::Matrix3Xd feltSurface(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& points,
                             const Solution& solution)
{
    const double wavelength_m = solution.medium.wavelength(solution.array.frequency_Hz);
    haptics::SamplerOptions sampling;
    sampling.spacing_m = 0.18 * wavelength_m; // no spot is farther than 1.1 of it from a sample
    sampling.sampling = arguments.outline ? haptics::Sampling::EDGES : arguments.sampling;
    sampling.maxPoints = 200000;
    // No nearer than the samples, or a point would have none.
    const double spacing_m = std::max(
        arguments.spacing_m > 0.0 ? arguments.spacing_m : wavelength_m, sampling.spacing_m);
    return haptics::samplesNear(solution.pose *
                                    haptics::sampleSurface(solution.mesh, sampling).positions,
                                points,
                                1.1 * spacing_m);
}

void measureSurface(const SolveArguments& arguments, Solution& solution)
{
    haptics::SurfaceStatisticsOptions options;
    options.threads = 2;
    std::vector<Eigen::VectorXcf> cycle = solution.turns.fields;
    if (cycle.empty()) cycle.push_back(solution.played);
    solution.report.surface =
        haptics::surfaceStatistics(feltSurface(arguments, solution.points.positions, solution),
                                   solution.array,
                                   solution.medium,
                                   cycle,
                                   options);
}

void solveModel(const SolveArguments& arguments, Solution& solution)
{
    std::vector<haptics::ControlPoints> sets;
    for (const haptics::PosedObject& object : sampleModel(arguments, solution))
        if (!arguments.outline) sets.push_back(selectPoints(arguments, object, solution));
    if (arguments.outline)
        playTurns(arguments,
                  solveOutlines(solution.mesh,
                                solution.pose,
                                arguments.pressure_Pa,
                                solution.array,
                                solution.medium),
                  solution);
    else if (arguments.cycle > 1 || arguments.subsets > 1)
    {
        Eigen::Matrix3Xd surface(3, 0);
        for (const haptics::ControlPoints& set : sets)
        {
            const Eigen::Index n = surface.cols();
            surface.conservativeResize(3, n + set.size());
            surface.rightCols(set.size()) = set.positions;
        }
        if (arguments.sweeps > 0) surface = feltSurface(arguments, surface, solution);
        playTurns(
            arguments,
            solveInTurn(
                sets, turnOptions(arguments, solution), surface, solution.array, solution.medium),
            solution);
    }
    else
    {
        solution.points = std::move(sets.front());
        solve(arguments, solution);
    }
    if (solution.points.size() > 0) measureSurface(arguments, solution);
}

/// The field, or the first of those in turn that has points.
void certify(Solution& solution)
{
    const Turns& turns = solution.turns;
    const haptics::ControlPoints* points = &solution.points;
    const Eigen::VectorXcf* played = &solution.played;
    for (std::size_t k = 0; k < turns.parts.size(); ++k)
    {
        points = &turns.parts[k];
        played = &turns.fields[k];
        if (points->size() > 0 && !played->isZero(0.0f)) break;
    }
    solution.parts.certificate =
        haptics::Certifier().certify(*points, solution.array, solution.medium, *played);
}

} // namespace

Solution solveAll(const SolveArguments& arguments)
{
    Solution solution;
    solution.array = haptics::TransducerArray::load(arguments.array);
    if (solution.array.drive.amplitudeLevels.empty())
        solution.array.drive.amplitudeLevels = device::amplitudeLevels();
    if (!arguments.directivity.empty())
        solution.array.directivity = haptics::directivityFromName(arguments.directivity);
    solution.medium.temperature_C = arguments.temperature_C;
    std::string error;
    if (!solution.medium.isValid(&error)) throw base::InputError(error);

    if (arguments.pointsFile.empty())
        solveModel(arguments, solution);
    else
    {
        solution.points = selectPoints(arguments, readPoints(arguments, solution), solution);
        if (arguments.subsets > 1)
            playTurns(arguments,
                      solveInTurn({solution.points},
                                  turnOptions(arguments, solution),
                                  Eigen::Matrix3Xd(3, 0),
                                  solution.array,
                                  solution.medium),
                      solution);
        else
            solve(arguments, solution);
    }
    if (arguments.certify && solution.report.level_Pa > 0.0) certify(solution);
    return solution;
}

} // namespace midair::samples
