#include "samples/solve/Solution.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/certificate/Certificate.h"

#include <algorithm>
#include <cstdio>

namespace midair::samples
{

namespace
{

/// Returns the activations that the array plays for a drive: amplitudes rounded to its levels.
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

haptics::ComposerOptions composerOptions(const SolveArguments& arguments)
{
    haptics::ComposerOptions options;
    base::assignPart<haptics::SequenceSettings>(options, arguments.settings);
    base::assignPart<haptics::SolverSettings>(options.solverOptions, arguments.settings);
    options.solverOptions.updateRate_Hz = arguments.settings.fieldRate;
    options.sweeps = arguments.sweeps;
    const std::string name = arguments.settings.solver.empty() ? haptics::solverNames().front()
                                                               : arguments.settings.solver;
    options.makeSolver = [name, solver = options.solverOptions]
    { return haptics::makeSolver(name, solver); };
    return options;
}

/// Returns one silent field, like that of a solver without points.
haptics::FieldSequence silentSequence(const haptics::TransducerArray& array)
{
    haptics::FieldSequence sequence;
    sequence.report.solver = "outline";
    sequence.report.transducers = array.size();
    sequence.report.message = "there are no control points";
    return sequence;
}

haptics::FieldSequence compose(const SolveArguments& arguments, const SolveScene& scene)
{
    base::MessageLog messages;
    haptics::SequenceComposer composer(composerOptions(arguments), messages);
    if (arguments.outline)
    {
        bool any = false;
        const std::vector<haptics::Outline> outlines = modelOutlines(arguments, scene, any);
        // The composer reports a model without edges as an error; edges out of reach give silence.
        if (any && outlines.empty()) return silentSequence(scene.array);
        return composer.composeOutlines(outlines,
                                        arguments.pressure_Pa > 0.0,
                                        composer.options().modulation,
                                        scene.array,
                                        scene.medium);
    }
    const std::vector<haptics::ControlPoints> sets = pointSets(arguments, scene);
    if (sets.size() == 1) return composer.compose(0, sets.front(), {}, scene.array, scene.medium);
    Eigen::Matrix3Xd surface(3, 0);
    if (arguments.sweeps > 0)
    {
        haptics::ControlPoints all;
        for (const haptics::ControlPoints& set : sets)
            append(all, set);
        surface = feltSurface(arguments, all.positions, scene);
    }
    return composer.composeCycle(sets, surface, scene.array, scene.medium);
}

void holdToCap(const SolveArguments& arguments, Solution& solution)
{
    if (!(arguments.settings.maxPressure > 0.0) || solution.points.size() == 0) return;
    const haptics::TransducerArray& array = solution.scene.array;
    device::DriveAbility ability;
    ability.amplitudes = array.drive.amplitudeLevels;
    const bridge::PressureCap cap(
        arguments.settings.maxPressure,
        [&array](const device::DriveSignal& signal) { return playedBy(array, signal); },
        std::move(ability));
    solution.sequence.report.capFactor = cap.hold({solution.points.positions,
                                                   {&array},
                                                   solution.scene.medium,
                                                   false,
                                                   arguments.settings.threads},
                                                  solution.sequence);
}

/// Encodes the drives and replaces the fields by those that the drives play.
void encodeFields(Solution& solution)
{
    for (Eigen::VectorXcf& q : solution.sequence.fields)
    {
        device::DriveSignal& signal = solution.signals.emplace_back();
        device::encode(q.data(), static_cast<int>(q.size()), signal);
        q = playedBy(solution.scene.array, signal);
    }
}

/// Computes |p| at the points in double, each in the field made for it.
void measure(Solution& solution)
{
    const haptics::FieldSequence& sequence = solution.sequence;
    solution.achieved_Pa.resize(solution.points.size());
    Eigen::Index done = 0;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        const Eigen::Matrix3Xd& positions = sequence.parts[k].positions;
        if (positions.cols() == 0) continue;
        const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(
            positions, solution.scene.array, solution.scene.medium);
        solution.achieved_Pa.segment(done, positions.cols()) =
            (G * sequence.fields[k].cast<std::complex<double>>()).cwiseAbs();
        done += positions.cols();
    }
}

/// Computes targets in Pa; relative ones at the level that was reached.
void fitTargets(Solution& solution)
{
    const Eigen::VectorXd& a = solution.points.targets;
    const bool relative = !solution.points.absolute && a.squaredNorm() > 0.0;
    solution.target_Pa = relative ? a * haptics::fittedLevel(solution.achieved_Pa, a) : a;
}

void measureSurface(const SolveArguments& arguments, Solution& solution)
{
    haptics::SurfaceStatisticsOptions options;
    options.threads = arguments.settings.threads;
    solution.sequence.report.surface = haptics::surfaceStatistics(
        feltSurface(arguments, solution.points.positions, solution.scene),
        solution.scene.array,
        solution.scene.medium,
        solution.sequence.fields,
        options);
}

/// Certifies the field, or the first of the fields in turn that has points.
void certify(Solution& solution)
{
    const haptics::FieldSequence& sequence = solution.sequence;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        if (sequence.parts[k].size() == 0 || sequence.fields[k].isZero(0.0f)) continue;
        solution.parts.certificate = haptics::Certifier().certify(
            sequence.parts[k], solution.scene.array, solution.scene.medium, sequence.fields[k]);
        return;
    }
}

} // namespace

Solution solveAll(const SolveArguments& arguments)
{
    Solution solution;
    solution.scene = loadScene(arguments);
    solution.sequence = compose(arguments, solution.scene);
    haptics::SolveReport& report = solution.sequence.report;
    const bool refused = report.stop == haptics::StopReason::REFUSED;
    if (refused && solution.sequence.parts.size() > 1) throw base::InputError(report.message);
    solution.points = solution.sequence.points();
    if (solution.sequence.isEmpty())
        solution.sequence.fields = {Eigen::VectorXcf::Zero(solution.scene.array.size())};
    holdToCap(arguments, solution);
    encodeFields(solution);
    measure(solution);
    // A solver rates only its own field, not several fields or the effect of a cap.
    if (solution.sequence.report.capFactor < 1.0 || !solution.sequence.isHeld())
        haptics::rateLevel(solution.points, solution.achieved_Pa.cast<float>(), report);
    fitTargets(solution);
    solution.parts.fields = static_cast<int>(solution.sequence.fields.size());
    solution.parts.fieldRate_Hz = arguments.settings.fieldRate;
    const bool isModel = arguments.pointsFile.empty();
    if (isModel && solution.points.size() > 0) measureSurface(arguments, solution);
    if (arguments.certify && report.level_Pa > 0.0) certify(solution);
    return solution;
}

} // namespace midair::samples
