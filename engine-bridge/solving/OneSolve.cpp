#include "engine-bridge/solving/OneSolve.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// A cap halves in most of them, down to silence.
constexpr int kMostCapPasses = 60;

haptics::ComposerOptions composerOptions(const SolveTask& task)
{
    haptics::ComposerOptions options;
    base::assignPart<haptics::SequenceSettings>(options, task.settings);
    base::assignPart<haptics::SolverSettings>(options.solverOptions, task.settings);
    options.modulation.amplitudeRate_Hz = task.modulation_Hz;
    options.solverOptions.updateRate_Hz = task.settings.fieldRate;
    options.solverOptions.stop = task.stop;
    const std::string name =
        task.settings.solver.empty() ? haptics::solverNames().front() : task.settings.solver;
    options.makeSolver = [name, solver = options.solverOptions, make = task.makeSolver]
    { return make ? make(name, solver) : haptics::makeSolver(name, solver); };
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

/// Composes the fields for \a array.
haptics::FieldSequence compose(const SolveTask& task, const haptics::TransducerArray& array)
{
    base::MessageLog messages;
    haptics::SequenceComposer composer(composerOptions(task), messages);
    if (task.outlines)
    {
        if (task.outlinesOutOfReach) return silentSequence(array);
        return composer.composeOutlines(
            *task.outlines, task.absolute, composer.options().modulation, array, task.medium);
    }
    if (task.sets.size() == 1)
    {
        haptics::FieldSequence one =
            composer.compose(0, task.sets.front(), task.plan, array, task.medium);
        if (task.places.size() == 0 || !one.isHeld()) return one;
        return composer.join({std::move(one)}, task.places, array, task.medium);
    }
    return composer.composeCycle(task.sets, task.places, array, task.medium);
}

/// Returns the cap of the task times \a share; without one, a cap at the highest possible pressure.
PressureCap pressureCap(const SolveTask& task, const haptics::DriveResolution& drive, double share)
{
    device::DriveAbility ability;
    ability.phaseLevels = drive.phaseLevels;
    ability.amplitudes = drive.amplitudeLevels;
    const double max_Pa = task.settings.maxPressure;
    return {max_Pa > 0.0 ? share * max_Pa : base::kMostPressure_Pa,
            [&drive](const device::DriveSignal& signal) { return playedBy(drive, signal); },
            std::move(ability)};
}

/// Encodes the drives, unless the cap did so already, and replaces the fields by those of the
/// drives.
void encodeFields(const SolveTask& task, SolvedFields& solved)
{
    std::vector<Eigen::VectorXcf>& fields = solved.sequence.fields;
    const bool isProven = !solved.signals.empty();
    solved.signals.resize(fields.size());
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        device::DriveSignal& signal = solved.signals[k];
        if (!isProven) device::encode(fields[k].data(), static_cast<int>(fields[k].size()), signal);
        for (const int i : task.array.dead)
            signal.duty[static_cast<std::size_t>(i)] = 0;
        fields[k] = playedBy(task.array.drive, signal);
    }
}

/// Returns |p| at the points of \a sequence (n), computed in double, each in its own field; for
/// evened fields as felt. Rows of G are made one after the other: all of them take megabytes, whose
/// first touch may cost more than the numbers in them.
Eigen::VectorXd measured(const haptics::FieldSequence& sequence, const SolveTask& task)
{
    std::vector<Eigen::VectorXcd> fields;
    for (const Eigen::VectorXcf& q : sequence.fields)
        fields.emplace_back(q.cast<std::complex<double>>());
    Eigen::VectorXd achieved_Pa = Eigen::VectorXd::Zero(sequence.points().size());
    const auto outsideAt = [&](const Eigen::Matrix3Xd& places, const Eigen::VectorXcf& q)
    {
        return task.outside_Pa && places.cols() > 0 ? task.outside_Pa(places, q)
                                                    : Eigen::VectorXcd::Zero(places.cols()).eval();
    };
    const auto rowAt = [&](const Eigen::Vector3d& place) -> Eigen::RowVectorXcd
    { return haptics::referencePropagationMatrix(place, task.array, task.medium); };
    if (sequence.evened)
    {
        const Eigen::Matrix3Xd places = sequence.points().positions;
        Eigen::MatrixXcd outside_Pa(places.cols(), static_cast<Eigen::Index>(fields.size()));
        for (std::size_t k = 0; k < fields.size(); ++k)
            outside_Pa.col(static_cast<Eigen::Index>(k)) = outsideAt(places, sequence.fields[k]);
        for (Eigen::Index l = 0; l < achieved_Pa.size(); ++l)
        {
            const Eigen::RowVectorXcd row = rowAt(places.col(l));
            double square = 0.0;
            for (std::size_t k = 0; k < fields.size(); ++k)
                square += std::norm((row * fields[k]).value() +
                                    outside_Pa(l, static_cast<Eigen::Index>(k)));
            achieved_Pa[l] = std::sqrt(square / static_cast<double>(fields.size()));
        }
        return achieved_Pa;
    }
    Eigen::Index done = 0;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), fields.size()); ++k)
    {
        const Eigen::Matrix3Xd& places = sequence.parts[k].positions;
        const Eigen::VectorXcd outside_Pa = outsideAt(places, sequence.fields[k]);
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            achieved_Pa[done++] =
                std::abs((rowAt(places.col(l)) * fields[k]).value() + outside_Pa[l]);
    }
    return achieved_Pa;
}

/// Reports how the cap changed the fields \a before it, which sound.
void tellOfCap(const std::string& cap,
               const SolveTask& task,
               const haptics::FieldSequence& before,
               SolvedFields& solved)
{
    haptics::SolveReport& report = solved.sequence.report;
    const double rmsBefore = before.report.rms;
    std::string told;
    if (report.worstShortfall > before.report.worstShortfall + haptics::kShortBy)
        told = fmt::format("{} leaves {} of {} points short of their targets, by "
                           "up to {:.1f} %",
                           cap,
                           report.shortPoints,
                           report.points,
                           100.0 * report.worstShortfall);
    else if (report.rms > std::max(task.settings.rmsTolerance, 1.5 * rmsBefore))
        told = fmt::format(
            "{} leaves only coarse amplitudes: the rms error is {:.2f} %, {:.2f} % before",
            cap,
            100.0 * report.rms,
            100.0 * rmsBefore);
    if (told.empty()) return;
    if (report.stop == haptics::StopReason::CONVERGED) report.stop = haptics::StopReason::STALLED;
    report.message += (report.message.empty() ? "" : "; ") + told;
}

/// Applies the cap times \a share to the fields \a before it, encodes, measures and rates, so that
/// all figures belong to the written drives. Returns false if something outside raises a point
/// above the cap.
bool capAndRate(const SolveTask& task,
                const haptics::FieldSequence& before,
                double share,
                SolvedFields& solved)
{
    solved.sequence = before;
    haptics::SolveReport& report = solved.sequence.report;
    const PressureCap cap = pressureCap(task, task.array.drive, share);
    const PressureCap::Where where{solved.points.positions,
                                   {&task.array},
                                   task.medium,
                                   false,
                                   task.settings.threads,
                                   task.stop,
                                   task.ears};
    haptics::keepAmplitudes(task.settings.maxAmplitude, solved.sequence.fields);
    const bool isCapped = task.settings.maxPressure > 0.0 || where.ears;
    CappedDrives proven;
    if (isCapped && solved.points.size() > 0)
        report.capFactor = cap.hold(where, solved.sequence, &proven);
    solved.signals = std::move(proven.drives);
    encodeFields(task, solved);
    solved.achieved_Pa = measured(solved.sequence, task);
    // A solver rates its own field in float and in its planned levels, and rates silence as free of
    // errors.
    haptics::rateLevel(solved.points, solved.achieved_Pa.cast<float>(), report);
    if (isSilent(solved.sequence.fields))
        cap.tellOfSilence(where, before.fields, task.remedy, report);
    else if (report.capFactor < 1.0)
        tellOfCap(cap.isForEars(where, solved.sequence.fields)
                      ? fmt::format("the ear limit of {:g} dB", task.settings.earLimit)
                      : fmt::format("the cap of {:g} Pa", task.settings.maxPressure),
                  task,
                  before,
                  solved);
    return !task.outside_Pa || !(task.settings.maxPressure > 0.0) || solved.points.size() == 0 ||
           solved.achieved_Pa.maxCoeff() <= task.settings.maxPressure;
}

/// Lowers the fields until their pressures meet the cap.
void finish(const SolveTask& task, SolvedFields& solved)
{
    solved.sequence.report.reflectorCount = static_cast<int>(task.array.reflectors.size());
    const haptics::FieldSequence before = solved.sequence;
    // A cap knows the array's own pressures. What something outside adds follows the drive, so a
    // lower cap leaves no more than asked for; one of nothing is silence.
    double share = 1.0;
    for (int pass = 0; !capAndRate(task, before, share, solved); ++pass)
    {
        if (pass == kMostCapPasses)
            throw base::InputError(
                fmt::format("what stands in the field leaves no field below the cap of {:g} Pa",
                            task.settings.maxPressure));
        share *= pass < 4 ? 0.999 * task.settings.maxPressure / solved.achieved_Pa.maxCoeff() : 0.5;
    }
}

/// Computes targets in Pa; relative ones at the level that was reached.
void fitTargets(SolvedFields& solved)
{
    const Eigen::VectorXd& a = solved.points.targets;
    const bool relative = !solved.points.absolute && a.squaredNorm() > 0.0;
    solved.target_Pa = relative ? a * haptics::fittedLevel(solved.achieved_Pa, a) : a;
}

} // namespace

SolvedFields solveOnce(const SolveTask& task)
{
    SolvedFields solved;
    solved.sequence = compose(task, task.solvedFor ? *task.solvedFor : task.array);
    const haptics::SolveReport& report = solved.sequence.report;
    const bool refused = report.stop == haptics::StopReason::REFUSED;
    if (refused && solved.sequence.parts.size() > 1) throw base::InputError(report.message);
    solved.points = solved.sequence.points();
    if (solved.sequence.isEmpty())
        solved.sequence.fields = {Eigen::VectorXcf::Zero(task.array.size())};
    finish(task, solved);
    fitTargets(solved);
    return solved;
}

haptics::ExposureFigures steadyExposure(haptics::Exposure& exposure,
                                        const std::vector<Eigen::VectorXcf>& fields,
                                        double limit_dB)
{
    haptics::ExposureFigures figures;
    figures.places = static_cast<int>(exposure.size());
    figures.limit_dB = limit_dB;
    if (figures.places == 0) return figures;
    Eigen::Index at = 0;
    const double most_Pa2 = exposure.heard_Pa2(fields).maxCoeff(&at);
    figures.level_dB = figures.eq_dB = figures.max_dB = haptics::soundLevel_dB(most_Pa2);
    figures.x_m = exposure.places()(0, at);
    figures.y_m = exposure.places()(1, at);
    figures.z_m = exposure.places()(2, at);
    return figures;
}

} // namespace midair::bridge
