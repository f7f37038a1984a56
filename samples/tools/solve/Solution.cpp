#include "samples/tools/solve/Solution.h"

#include "haptics/base/InputError.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/solvers/certificate/Certificate.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kMostSamples = 1e7; // about 700 MB of text

haptics::ProbeOptions optionsOf(const SolveArguments& arguments)
{
    haptics::ProbeOptions options;
    options.rate_Hz = arguments.probeRate_Hz;
    options.duration_s = arguments.probeDuration_s;
    return options;
}

Eigen::Matrix3Xd givenPlaces(const SolveArguments& arguments)
{
    return Eigen::Map<const Eigen::Matrix3Xd>(
        arguments.probes.data(), 3, static_cast<Eigen::Index>(arguments.probes.size() / 3));
}

void append(const Eigen::Matrix3Xd& more, Eigen::Matrix3Xd& places)
{
    places.conservativeResize(3, places.cols() + more.cols());
    places.rightCols(more.cols()) = more;
}

/// The mean radiation pressure at a point over the steps of \a schedule, each as its steady field.
double steadyMean_Pa(const haptics::PressureProbe& probe,
                     const haptics::DriveSchedule& schedule,
                     const Eigen::Vector3d& point,
                     const haptics::Medium& medium)
{
    const std::vector<std::complex<double>> steady = probe.steadyAt(point);
    double sum = 0.0;
    for (const haptics::ScheduledDrive& step : schedule.steps)
        sum += step.duration_s * std::norm(step.amplitude * steady[std::size_t(step.drive)]);
    return sum / schedule.duration_s() * haptics::radiationPressure(1.0, medium);
}

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

SolveEars::SolveEars(const haptics::TransducerArray& array,
                     const haptics::Medium& medium,
                     const Eigen::Matrix3Xd& given,
                     double limit_dB) :
    _given(given.cols()),
    _limit_dB(limit_dB)
{
    constexpr int kAround = 32;
    const Eigen::Matrix3Xd around = haptics::placesAround(array, kAround);
    Eigen::Matrix3Xd all(3, around.cols() + given.cols());
    all << around, given;
    _exposure = std::make_shared<haptics::Exposure>(array, medium, all);
    if (limit_dB > 0.0) _bound = std::make_unique<bridge::EarBound>(limit_dB, _exposure);
}

haptics::ExposureFigures SolveEars::figures(const std::vector<Eigen::VectorXcf>& fields) const
{
    return bridge::steadyExposure(*_exposure, fields, _limit_dB);
}

void SolveEars::write(const std::string& path, const std::vector<Eigen::VectorXcf>& fields) const
{
    Eigen::VectorXd coherent = Eigen::VectorXd::Zero(_exposure->size());
    Eigen::VectorXd incoherent = coherent;
    for (const Eigen::VectorXcf& q : fields)
    {
        coherent += _exposure->coherent_Pa2(q).cast<double>() / static_cast<double>(fields.size());
        incoherent +=
            _exposure->incoherent_Pa2(q).cast<double>() / static_cast<double>(fields.size());
    }
    TextFile file(path);
    file.line("x_m,y_m,z_m,L_dB,incoherent_dB");
    for (Eigen::Index l = _exposure->size() - _given; l < _exposure->size(); ++l)
        file.line("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                  _exposure->places()(0, l),
                  _exposure->places()(1, l),
                  _exposure->places()(2, l),
                  haptics::soundLevel_dB(coherent[l]),
                  haptics::soundLevel_dB(incoherent[l]));
    file.finish();
}

bool asksForProbes(const SolveArguments& arguments)
{
    return !arguments.probes.empty() || arguments.probePoints;
}

Eigen::Matrix3Xd probePlaces(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& controlPoints,
                             const SolveScene& scene)
{
    const haptics::ProbeOptions options = optionsOf(arguments);
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    Eigen::Matrix3Xd places = givenPlaces(arguments);
    if (arguments.probePatch_m > 0.0)
    {
        places = haptics::samplesNear(
            feltSurface(arguments, controlPoints, scene), places, arguments.probePatch_m);
        if (places.cols() == 0)
            throw base::InputError(fmt::format(
                "--probe-patch: no place of the felt surface is within {:g} m of a --probe",
                arguments.probePatch_m));
    }
    if (arguments.probePoints) append(controlPoints, places);
    if (places.cols() == 0) throw base::InputError("--probe-points: there are no control points");
    const double samples = static_cast<double>(places.cols()) * options.samples();
    if (samples > kMostSamples)
        throw base::InputError(fmt::format(
            "{} probes of {} samples are more than {:g} in all: shorten --duration, or lower "
            "--probe-rate",
            places.cols(),
            options.samples(),
            kMostSamples));
    return places;
}

ProbeTraces probe(const SolveArguments& arguments,
                  const Eigen::Matrix3Xd& places,
                  const haptics::FieldSequence& sequence,
                  const SolveScene& scene)
{
    const haptics::ProbeOptions options = optionsOf(arguments);
    const haptics::DriveSchedule schedule = haptics::stepsOf(sequence, options.duration_s);
    const haptics::PressureProbe probe(scene.array, scene.medium, schedule);
    ProbeTraces traces;
    traces.rate_Hz = options.rate_Hz;
    traces.ringing_s = scene.array.ringing_s;
    traces.points = places;
    traces.steadyMean_Pa.resize(places.cols());
    for (Eigen::Index l = 0; l < places.cols(); ++l)
    {
        traces.pressure_Pa.push_back(probe.at(places.col(l), options));
        traces.steadyMean_Pa[l] = steadyMean_Pa(probe, schedule, places.col(l), scene.medium);
    }
    return traces;
}

void writeProbe(const std::string& folder, const ProbeTraces& traces, const haptics::Medium& medium)
{
    TextFile probes(folder + "/probe.csv");
    TextFile spectra(folder + "/spectrum.csv");
    TextFile places(folder + "/probe_points.csv");
    probes.line("point,time_s,p_re_Pa,p_im_Pa,radiation_Pa");
    spectra.line("point,frequency_Hz,radiation_Pa");
    places.line("point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa");
    for (std::size_t l = 0; l < traces.pressure_Pa.size(); ++l)
    {
        const Eigen::VectorXcd& p_Pa = traces.pressure_Pa[l];
        const Eigen::VectorXd radiation_Pa = haptics::radiationOf(p_Pa, medium);
        for (Eigen::Index k = 0; k < p_Pa.size(); ++k)
            probes.line("{},{:.9g},{:.9g},{:.9g},{:.9g}",
                        l,
                        static_cast<double>(k) / traces.rate_Hz,
                        p_Pa[k].real(),
                        p_Pa[k].imag(),
                        radiation_Pa[k]);
        const auto column = static_cast<Eigen::Index>(l);
        places.line("{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                    l,
                    traces.points(0, column),
                    traces.points(1, column),
                    traces.points(2, column),
                    radiation_Pa.mean(),
                    traces.steadyMean_Pa[column]);
        if (radiation_Pa.size() < 2) continue;
        const haptics::Spectrum spectrum = haptics::spectrumOf(radiation_Pa, traces.rate_Hz);
        for (Eigen::Index k = 0; k < spectrum.amplitude.size(); ++k)
            spectra.line("{},{:.9g},{:.9g}",
                         l,
                         static_cast<double>(k) * spectrum.step_Hz,
                         spectrum.amplitude[k]);
    }
    probes.finish();
    spectra.finish();
    places.finish();
}

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
