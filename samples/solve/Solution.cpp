#include "samples/solve/Solution.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/KelvinCost.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "samples/solve/ArrayLevels.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

haptics::ComposerOptions composerOptions(const SolveArguments& arguments)
{
    haptics::ComposerOptions options;
    base::assignPart<haptics::SequenceSettings>(options, arguments.settings);
    base::assignPart<haptics::SolverSettings>(options.solverOptions, arguments.settings);
    options.modulation.amplitudeRate_Hz = arguments.modulation_Hz;
    options.solverOptions.updateRate_Hz = arguments.settings.fieldRate;
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
    haptics::ControlPoints places;
    if (arguments.settings.even > 0)
    {
        haptics::ControlPoints all;
        for (const haptics::ControlPoints& set : sets)
            append(all, set);
        places = placesToEven(arguments, all, scene);
    }
    return composer.composeCycle(sets, places, scene.array, scene.medium);
}

/// Returns what holds fields to the cap of the arguments; without one, to the most that can be.
bridge::PressureCap pressureCap(const SolveArguments& arguments,
                                const haptics::DriveResolution& drive)
{
    device::DriveAbility ability;
    ability.phaseLevels = drive.phaseLevels;
    ability.amplitudes = drive.amplitudeLevels;
    const double max_Pa = arguments.settings.maxPressure;
    return {max_Pa > 0.0 ? max_Pa : base::kMostPressure_Pa,
            [&drive](const device::DriveSignal& signal) { return playedBy(drive, signal); },
            std::move(ability)};
}

/// Encodes the drives and replaces the fields by those that the drives play.
void encodeFields(Solution& solution)
{
    for (Eigen::VectorXcf& q : solution.sequence.fields)
    {
        device::DriveSignal& signal = solution.signals.emplace_back();
        device::encode(q.data(), static_cast<int>(q.size()), signal);
        for (const int i : solution.scene.array.dead)
            signal.duty[static_cast<std::size_t>(i)] = 0;
        q = playedBy(solution.scene.array.drive, signal);
    }
}

/// Returns |p| at the points of \a sequence (n), computed in double, each in the field made for it;
/// of an evened one what is felt.
Eigen::VectorXd measured(const haptics::FieldSequence& sequence, const SolveScene& scene)
{
    if (sequence.evened)
    {
        const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(
            sequence.points().positions, scene.array, scene.medium);
        Eigen::VectorXd square = Eigen::VectorXd::Zero(G.rows());
        for (const Eigen::VectorXcf& q : sequence.fields)
            square += (G * q.cast<std::complex<double>>()).cwiseAbs2();
        return (square / static_cast<double>(sequence.fields.size())).cwiseSqrt();
    }
    Eigen::VectorXd achieved_Pa = Eigen::VectorXd::Zero(sequence.points().size());
    Eigen::Index done = 0;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        const Eigen::Matrix3Xd& positions = sequence.parts[k].positions;
        if (positions.cols() == 0) continue;
        const Eigen::MatrixXcd G =
            haptics::referencePropagationMatrix(positions, scene.array, scene.medium);
        achieved_Pa.segment(done, positions.cols()) =
            (G * sequence.fields[k].cast<std::complex<double>>()).cwiseAbs();
        done += positions.cols();
    }
    return achieved_Pa;
}

/// Tells in the report what the cap has made of the fields \a before it, which sound.
void tellOfCap(const std::string& cap,
               const SolveArguments& arguments,
               const haptics::FieldSequence& before,
               Solution& solution)
{
    haptics::SolveReport& report = solution.sequence.report;
    const double rmsBefore = before.report.rms;
    std::string told;
    if (report.worstShortfall > before.report.worstShortfall + haptics::kShortBy)
        told = fmt::format("{} leaves {} of {} points short of their targets, by "
                           "up to {:.1f} %",
                           cap,
                           report.shortPoints,
                           report.points,
                           100.0 * report.worstShortfall);
    else if (report.rms > std::max(arguments.settings.rmsTolerance, 1.5 * rmsBefore))
        told = fmt::format("the amplitudes that {} leaves are coarse: the rms "
                           "error is {:.2f} %, {:.2f} % before",
                           cap,
                           100.0 * report.rms,
                           100.0 * rmsBefore);
    if (told.empty()) return;
    if (report.stop == haptics::StopReason::CONVERGED) report.stop = haptics::StopReason::STALLED;
    report.message += (report.message.empty() ? "" : "; ") + told;
}

/// Applies the cap, encodes, measures and rates: all figures are then of the written drives.
void finish(const SolveArguments& arguments, Solution& solution)
{
    haptics::SolveReport& report = solution.sequence.report;
    const haptics::FieldSequence before = solution.sequence;
    const haptics::TransducerArray& array = solution.scene.array;
    const bridge::PressureCap cap = pressureCap(arguments, array.drive);
    const bridge::PressureCap::Where where{solution.points.positions,
                                           {&array},
                                           solution.scene.medium,
                                           false,
                                           arguments.settings.threads,
                                           {},
                                           solution.ears->bound()};
    const bool isCapped = arguments.settings.maxPressure > 0.0 || where.ears;
    if (isCapped && solution.points.size() > 0)
        report.capFactor = cap.hold(where, solution.sequence);
    encodeFields(solution);
    solution.achieved_Pa = measured(solution.sequence, solution.scene);
    // A solver rates its own field in float and in the levels that it planned with, and silence as
    // without errors.
    haptics::rateLevel(solution.points, solution.achieved_Pa.cast<float>(), report);
    if (bridge::isSilent(solution.sequence.fields))
        cap.tellOfSilence(
            where,
            before.fields,
            {"--max-pressure", "--pressure or --loudness", "MaxAmplitude", "--ear-limit"},
            report);
    else if (report.capFactor < 1.0)
        tellOfCap(cap.isForEars(where, solution.sequence.fields)
                      ? fmt::format("the ear limit of {:g} dB", arguments.settings.earLimit)
                      : fmt::format("the cap of {:g} Pa", arguments.settings.maxPressure),
                  arguments,
                  before,
                  solution);
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
    options.fieldRate_Hz = solution.sequence.modulation.fieldRate_Hz;
    solution.sequence.report.surface = haptics::surfaceStatistics(
        feltSurface(arguments, solution.points.positions, solution.scene),
        solution.scene.array,
        solution.scene.medium,
        solution.sequence.fields,
        options);
}

/// Rates what ringing makes of the fields as the drives play them, and of their level at the
/// points.
void rateRinging(const SolveArguments& arguments, Solution& solution)
{
    haptics::FieldSequence& sequence = solution.sequence;
    const SolveScene& scene = solution.scene;
    haptics::rateRinging(sequence, scene.array.ringing_s);
    const Eigen::Matrix3Xd& places = solution.points.positions;
    if (sequence.fields.size() < 2 || places.cols() == 0) return;
    const int threads = arguments.settings.threads;
    const Eigen::ArrayXd ringing =
        haptics::ringingMeanSquare(places,
                                   scene.array,
                                   scene.medium,
                                   sequence.fields,
                                   1.0 / sequence.modulation.fieldRate_Hz,
                                   threads);
    const Eigen::ArrayXd steady =
        haptics::meanSquarePressure(places, scene.array, scene.medium, sequence.fields, threads);
    const Eigen::ArrayXd left = (steady > 0.0).select((ringing / steady).sqrt(), 1.0);
    solution.parts.ringing = sequence.report;
    haptics::rateLevel(solution.points,
                       (solution.achieved_Pa.array() * left).cast<float>(),
                       *solution.parts.ringing);
}

/// Rates what 1 K costs the field, or the first of the fields in turn that has points.
void rateKelvin(const SolveArguments& arguments, Solution& solution)
{
    const haptics::FieldSequence& sequence = solution.sequence;
    if (sequence.evened) return;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        if (sequence.parts[k].size() == 0) continue;
        const haptics::KelvinCost cost = haptics::kelvinCost(sequence.parts[k],
                                                             sequence.fields[k],
                                                             solution.scene.array,
                                                             solution.scene.medium,
                                                             arguments.settings.threads);
        solution.sequence.report.kelvinRms = cost.rms;
        solution.sequence.report.kelvinLevel = cost.level;
        return;
    }
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
    solution.ears = std::make_shared<SolveEars>(
        solution.scene.array,
        solution.scene.medium,
        arguments.earsFile.empty() ? Eigen::Matrix3Xd(3, 0) : readEars(arguments.earsFile),
        arguments.settings.earLimit);
    finish(arguments, solution);
    solution.parts.exposure = solution.ears->figures(solution.sequence.fields);
    fitTargets(solution);
    solution.parts.fields = static_cast<int>(solution.sequence.fields.size());
    solution.parts.evened = solution.sequence.evened;
    solution.parts.fieldRate_Hz = arguments.settings.fieldRate;
    const bool isModel = arguments.pointsFile.empty();
    if (isModel && solution.points.size() > 0) measureSurface(arguments, solution);
    rateRinging(arguments, solution);
    rateKelvin(arguments, solution);
    if (asksForProbes(arguments))
        solution.probe = probe(arguments,
                               probePlaces(arguments, solution.points.positions, solution.scene),
                               solution.sequence,
                               solution.scene);
    if (arguments.hasTolerance)
        solution.tolerance = haptics::toleranceOf(
            solution.sequence, solution.scene.array, solution.scene.medium, arguments.tolerance);
    if (arguments.certify && solution.parts.evened)
        std::fprintf(stderr,
                     "midair-solve: no certificate: no field of a cycle that is evened out is for "
                     "its points alone; --even 0 leaves them as they are\n");
    else if (arguments.certify && report.level_Pa > 0.0)
        certify(solution);
    return solution;
}

} // namespace midair::samples
