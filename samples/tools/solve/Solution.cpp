#include "samples/tools/solve/Solution.h"

#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/solvers/certificate/Certificate.h"

#include <algorithm>
#include <cstdio>

namespace midair::samples
{

namespace
{

/// Returns what is to be solved for; of outlines or of sets of points. \a scene outlives it.
bridge::SolveTask taskOf(const SolveArguments& arguments, const SolveScene& scene)
{
    bridge::SolveTask task{scene.array, scene.medium, arguments.settings};
    task.modulation_Hz = arguments.modulation_Hz;
    task.absolute = arguments.pressure_Pa > 0.0;
    task.remedy = {"--max-pressure", "--pressure or --loudness", "MaxAmplitude", "--ear-limit"};
    if (arguments.outline)
    {
        bool any = false;
        task.outlines = modelOutlines(arguments, scene, any);
        task.outlinesOutOfReach = any && task.outlines->empty();
        return task;
    }
    task.sets = pointSets(arguments, scene);
    if (task.sets.size() == 1 || arguments.settings.even == 0) return task;
    haptics::ControlPoints all;
    for (const haptics::ControlPoints& set : task.sets)
        append(all, set);
    task.places = placesToEven(arguments, all, scene);
    return task;
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

/// Certifies with the regularisation that the solver is given; throws InputError for one that is
/// too weak for a bound.
haptics::Certifier certifierOf(const SolveArguments& arguments)
{
    haptics::CertificateOptions options;
    options.lambdaRel = arguments.settings.lambda;
    return haptics::Certifier(options);
}

/// Certifies the field, or the first of the fields in turn that has points.
void certify(const SolveArguments& arguments, Solution& solution)
{

    const haptics::FieldSequence& sequence = solution.sequence;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        if (sequence.parts[k].size() == 0 || sequence.fields[k].isZero(0.0f)) continue;
        solution.parts.certificate = certifierOf(arguments).certify(
            sequence.parts[k], solution.scene.array, solution.scene.medium, sequence.fields[k]);
        return;
    }
}

} // namespace

Solution solveAll(const SolveArguments& arguments)
{
    Solution solution;
    if (arguments.certify) certifierOf(arguments); // or a long solve would end without a result
    solution.scene = loadScene(arguments);
    bridge::SolveTask task = taskOf(arguments, solution.scene);
    solution.ears = std::make_shared<SolveEars>(
        solution.scene.array,
        solution.scene.medium,
        arguments.earsFile.empty() ? Eigen::Matrix3Xd(3, 0) : readEars(arguments.earsFile),
        arguments.settings.earLimit);
    task.ears = solution.ears->bound();
    static_cast<bridge::SolvedFields&>(solution) = bridge::solveOnce(task);
    const haptics::SolveReport& report = solution.sequence.report;
    solution.parts.exposure = solution.ears->figures(solution.sequence.fields);
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
        certify(arguments, solution);
    return solution;
}

} // namespace midair::samples
