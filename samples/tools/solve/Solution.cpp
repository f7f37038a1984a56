#include "samples/tools/solve/Solution.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/FittingSize.h"
#include "haptics/points/Workspace.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/FieldSettings.h"
#include "haptics/sequence/FocusShare.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "samples/tools/solve/SolveFiles.h"
#include "samples/tools/solve/SolveScatterer.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

Eigen::Isometry3d poseOf(const SolveArguments& arguments)
{
    const auto angle = [&](int axis)
    { return base::toRadians(arguments.rotation_deg[static_cast<std::size_t>(axis)]); };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(
        Eigen::Vector3d(arguments.position[0], arguments.position[1], arguments.position[2]));
    pose.rotate(Eigen::AngleAxisd(angle(2), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(angle(1), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(angle(0), Eigen::Vector3d::UnitX()));
    return pose;
}

/// Returns the spacing of control points, metres.
double spacingOf(const SolveArguments& arguments, const SolveScene& scene)
{
    return arguments.spacing_m > 0.0 ? arguments.spacing_m : scene.wavelength_m();
}

/// Returns samples of the model, \a spacing_m apart, array frame.
Eigen::Matrix3Xd samplesOf(const SolveArguments& arguments,
                           const SolveScene& scene,
                           double spacing_m,
                           bool isBetween = false)
{
    haptics::SamplerOptions sampling;
    sampling.spacing_m = spacing_m;
    sampling.sampling = arguments.outline ? haptics::Sampling::EDGES : arguments.sampling;
    sampling.maxPoints = 200000;
    return scene.pose * (isBetween ? haptics::sampleBetween(scene.mesh, sampling)
                                   : haptics::sampleSurface(scene.mesh, sampling))
                            .positions;
}

/// Returns the model's samples in the array frame, a set for each field. All targets are 1, or the
/// requested pressure.
std::vector<haptics::PosedObject> sampleModel(const SolveArguments& arguments,
                                              const SolveScene& scene)
{
    haptics::SamplerOptions options;
    options.spacing_m = spacingOf(arguments, scene);
    options.sampling = arguments.sampling;
    std::vector<haptics::PosedObject> objects;
    for (const haptics::SurfaceSamples& samples :
         haptics::sampleSurfaceSets(scene.mesh, options, arguments.settings.cycle))
    {
        haptics::PosedObject& object = objects.emplace_back();
        object.pose(samples, scene.pose);
        object.spacing_m = options.spacing_m;
        if (arguments.pressure_Pa > 0.0) object.target = arguments.pressure_Pa;
    }
    return objects;
}

/// Keeps points from the user's file unchanged, except duplicates, unless an option says how to
/// treat crowded points.
haptics::PosedObject
asObject(const haptics::ControlPoints& points, bool crowdingGiven, double wavelength_m)
{
    haptics::PosedObject object;
    object.positions = points.positions;
    object.normals = points.normals;
    object.intensity = points.targets.cast<float>();
    object.spacing_m = crowdingGiven ? wavelength_m : 1e-6;
    return object;
}

/// If the model is as small as one focus, warns and returns how many points it would have at a size
/// that fits; otherwise returns 0.
int pointsIfSmall(const SolveArguments& arguments, const SolveScene& scene)
{
    if (!haptics::isOneFocus(scene.mesh, scene.wavelength_m())) return 0;
    haptics::SamplerOptions sampling;
    sampling.spacing_m = spacingOf(arguments, scene);
    sampling.sampling = arguments.sampling;
    haptics::SelectorOptions options;
    if (arguments.settings.maxPoints > 0) options.maxPoints = arguments.settings.maxPoints;
    const haptics::Workspace workspace(scene.array, scene.wavelength_m(), options);
    haptics::LargeModel model{scene.mesh, scene.pose, scene.mesh.extent().maxCoeff()};
    if (arguments.sampling == haptics::Sampling::SURFACE) model.spacing_m = sampling.spacing_m;
    model.mayGrow = true;
    const double size_m =
        haptics::fittingSize_m(model,
                               workspace,
                               haptics::ArrayFront(scene.array.positions, scene.array.normals),
                               options.maxPoints);
    std::fprintf(
        stderr,
        "midair-solve: object.small: the model is %.3g m wide, under half a wavelength (%.2g m): "
        "it becomes a single focus, no stronger than one point of a larger model",
        model.width_m,
        0.5 * scene.wavelength_m());
    std::fprintf(
        stderr, size_m > 0.0 ? "; --size %g fits\n" : "\n", haptics::proposedSize_m(size_m));
    return haptics::pointsAtSize(scene.mesh, sampling, size_m, options.maxPoints);
}

/// Selects the points that the array can reach, with a message if some are left out.
haptics::ControlPoints selectPoints(const SolveArguments& arguments,
                                    const haptics::PosedObject& object,
                                    bool absolute,
                                    const SolveScene& scene)
{
    haptics::SelectorOptions options;
    if (arguments.settings.maxPoints > 0) options.maxPoints = arguments.settings.maxPoints;
    options.crowding = arguments.crowding;
    const haptics::Workspace workspace(scene.array, scene.wavelength_m(), options);
    haptics::Selection selection = haptics::selectControlPoints({object}, workspace, options);
    const std::string left = selection.report.summary();
    if (!left.empty()) std::fprintf(stderr, "midair-solve: uses %s\n", left.c_str());
    selection.points.absolute = absolute;
    return std::move(selection.points);
}

/// Throws base::InputError if \a file is in another format by its name.
void requireObj(const std::string& file)
{
    const std::string ending = base::lowerCase(std::filesystem::path(file).extension().string());
    if (ending.empty() || ending == ".obj") return;
    throw base::InputError(file + ": midair-solve reads OBJ files (.obj) only, not " + ending +
                           ". Convert it, or use midair-check or midair-demo, which read what "
                           "OpenSceneGraph reads");
}

/// Adds the reflectors of a file; none if \a file is empty. Throws base::InputError.
void addReflectors(const std::string& file, haptics::TransducerArray& array)
{
    if (file.empty()) return;
    for (haptics::Reflector& one : haptics::reflectorsFromJson(textOf(file), file))
        array.reflectors.push_back(std::move(one));
    std::string error;
    if (!haptics::areValid(array.reflectors, &error))
        throw base::InputError(file + ": with the array's own the " + error);
}

/// Loads the array, air and model of \a arguments. Throws base::InputError.
SolveScene loadScene(const SolveArguments& arguments)
{
    SolveScene scene;
    scene.array = haptics::TransducerArray::load(arguments.array);
    scene.array.mark(arguments.settings.dead, arguments.settings.weak);
    if (bridge::keepToSignal(scene.array.drive))
        std::fprintf(
            stderr,
            "midair-solve: the array has more phase levels than the 256 of a drive; using 256\n");
    if (!arguments.directivity.empty())
        scene.array.directivity = haptics::directivityFromName(arguments.directivity);
    if (arguments.ringing_s >= 0.0) scene.array.ringing_s = arguments.ringing_s;
    addReflectors(arguments.reflectorsFile, scene.array);
    scene.medium = haptics::mediumOf(arguments.settings);
    std::string error;
    if (!scene.medium.isValid(&error)) throw base::InputError(error);
    if (!arguments.pointsFile.empty()) return scene;
    requireObj(arguments.model);
    std::vector<std::string> warnings;
    scene.mesh = haptics::readObj(arguments.model, &warnings);
    for (const std::string& warning : warnings)
        std::fprintf(stderr, "midair-solve: %s\n", warning.c_str());
    if (arguments.size_m > 0.0) scene.mesh = scene.mesh.scaledTo(arguments.size_m);
    scene.pose = poseOf(arguments);
    return scene;
}

/// Returns control points in the array frame, a set for each field of a cycle. Points that the
/// array can't reach are left out, with a message on standard error. Throws base::InputError.
std::vector<haptics::ControlPoints> pointSets(const SolveArguments& arguments,
                                              const SolveScene& scene)
{
    if (!arguments.pointsFile.empty())
    {
        const haptics::ControlPoints points = readControlPoints(arguments.pointsFile);
        const haptics::PosedObject object =
            asObject(points, arguments.crowdingGiven, scene.wavelength_m());
        return {selectPoints(arguments, object, points.absolute, scene)};
    }
    std::vector<haptics::ControlPoints> sets;
    const int whole = pointsIfSmall(arguments, scene);
    for (const haptics::PosedObject& object : sampleModel(arguments, scene))
    {
        haptics::ControlPoints points =
            selectPoints(arguments, object, arguments.pressure_Pa > 0.0, scene);
        std::vector<int> small(whole > 0 ? static_cast<std::size_t>(points.size()) : 0);
        std::iota(small.begin(), small.end(), 0);
        haptics::holdToShare(
            small, whole, arguments.settings.loudness, scene.array, scene.medium, points);
        sets.push_back(std::move(points));
    }
    return sets;
}

/// Returns the model's feature edges in the array frame, with the requested pressure or 1 as
/// targets. Edges that are not entirely within the array's reach are left out, with a message.
/// \a any is set to true if the model has edges. Throws base::InputError.
std::vector<haptics::Outline>
modelOutlines(const SolveArguments& arguments, const SolveScene& scene, bool& any)
{
    if (pointsIfSmall(arguments, scene) > 0)
        throw base::InputError("the model is too small for an outline: it is a single focus");
    const haptics::Workspace workspace(
        scene.array, scene.wavelength_m(), haptics::SelectorOptions());
    const double target =
        arguments.pressure_Pa > 0.0 ? arguments.pressure_Pa : haptics::Outline().target;
    haptics::ReachedOutlines reached =
        haptics::reachedOutlines(scene.mesh, scene.pose, target, workspace);
    const std::size_t all = reached.inside.size() + static_cast<std::size_t>(reached.outside);
    any = all > 0;
    if (reached.outside > 0)
        std::fprintf(stderr,
                     "midair-solve: uses %zu of %zu outlines: %d are not entirely within the "
                     "array's reach\n",
                     reached.inside.size(),
                     all,
                     reached.outside);
    if (reached.apart > 0)
        std::fprintf(stderr,
                     "midair-solve: %d points of the model are on no outline and are left out; "
                     "without --outline they are used\n",
                     reached.apart);
    return std::move(reached.inside);
}

/// Returns places near \a points, with targets, where fields are evened out. Returns none, with a
/// message, if the surface is too large.
haptics::ControlPoints placesToEven(const SolveArguments& arguments,
                                    const haptics::ControlPoints& points,
                                    const SolveScene& scene)
{
    for (const double spacing : haptics::placeSpacings(arguments.settings.cycle))
    {
        const double spacing_m = spacing * scene.wavelength_m();
        haptics::ControlPoints places = haptics::feltPlaces(
            samplesOf(arguments, scene, spacing_m),
            points,
            haptics::kFeltReach * std::max(spacingOf(arguments, scene), spacing_m));
        if (places.size() <= haptics::kMostPlaces) return places;
    }
    std::fprintf(stderr,
                 "midair-solve: the fields are not evened out: the surface is too large for %d "
                 "places %g wavelengths apart\n",
                 haptics::kMostPlaces,
                 haptics::kPlaceSpacings.back());
    return {};
}

/// Returns samples of the felt surface near \a points (3 x n), at most a fifth of a wavelength
/// apart. \a isEvened: between the places at which fields are evened out, where they are better.
Eigen::Matrix3Xd feltSurface(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& points,
                             const SolveScene& scene,
                             bool isEvened)
{
    // No place is farther from a sample than this times kFeltReach.
    const double sampled_m = 0.18 * scene.wavelength_m();
    // At least the spacing of the samples, or a point might have none nearby.
    const double spacing_m = std::max(spacingOf(arguments, scene), sampled_m);
    return haptics::samplesNear(
        samplesOf(arguments, scene, sampled_m, isEvened), points, haptics::kFeltReach * spacing_m);
}

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

/// Returns the mean radiation pressure at a point over the steps of \a schedule, each as its steady
/// field.
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

/// Returns the task: outlines or sets of points. \a scene must outlive it.
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
    // A single field stays the solver's own unless something else is asked for.
    if ((task.sets.size() == 1 && !arguments.evenGiven) || arguments.settings.even == 0)
        return task;
    if (task.sets.size() == 1 && arguments.sampling != haptics::Sampling::SURFACE)
        throw base::InputError("--even: a single field of vertices, points or edges isn't evened "
                               "out; use --sampling surface or --even 0");
    haptics::ControlPoints all;
    for (const haptics::ControlPoints& set : task.sets)
        append(all, set);
    if (arguments.evenGiven && all.absolute)
        throw base::InputError(
            "--even: fields for pressures in Pa aren't evened out; use --even 0");
    if (arguments.evenGiven && arguments.settings.subsets > 1)
        throw base::InputError("--even: the fields of --subsets aren't evened out; use --even 0");
    task.places = placesToEven(arguments, all, scene);
    return task;
}

/// Solves for free air and, unless told otherwise, for the reflectors of the array; keeps the
/// drives that err less if the reflectors are as far off as their accuracy says. Throws
/// base::InputError by the name of a reflector that can't be corrected for.
void solveWithReflectors(const SolveArguments& arguments,
                         bridge::SolveTask& task,
                         Solution& solution)
{
    SolvedReflectors& told = solution.parts.reflectors.emplace();
    told.count = static_cast<int>(task.array.reflectors.size());
    haptics::TransducerArray free = task.array;
    free.reflectors.clear();
    const auto solve =
        [&](const haptics::TransducerArray& solvedFor, haptics::ReflectorFigures& figures)
    {
        task.solvedFor = &solvedFor;
        bridge::SolvedFields solved = bridge::solveOnce(task);
        figures = haptics::reflectorFigures(
            solved.sequence, task.array, task.medium, arguments.settings.threads);
        return solved;
    };
    bridge::SolvedFields& played = solution;
    played = solve(free, told.played);
    told.hidden = haptics::hiddenTransducers(played.points.positions, task.array, task.medium);
    const std::string why =
        haptics::whyUncorrectable(played.points.positions, task.array, task.medium);
    if (!why.empty() && !arguments.noCorrection)
        throw base::InputError("the field can't be corrected for the reflectors: " + why +
                               "; --no-correction tells what they do to it");
    if (!why.empty())
        std::fprintf(
            stderr, "midair-solve: figures with reflectors are rough, as %s\n", why.c_str());
    if (!arguments.noCorrection)
    {
        bridge::SolvedFields corrected = solve(task.array, told.other);
        told.isCorrected = told.other.expectedRms < told.played.expectedRms;
        if (told.isCorrected)
        {
            std::swap(told.played, told.other);
            played = std::move(corrected);
        }
    }
    task.solvedFor = nullptr;
    solution.sequence.report.reflectorRms = told.played.expectedRms;
    told.freeEars_dB = solution.ears->levelOf_dB(free, task.medium, played.sequence.fields);
}

void measureSurface(const SolveArguments& arguments, Solution& solution)
{
    haptics::SurfaceStatisticsOptions options;
    options.threads = arguments.settings.threads;
    options.fieldRate_Hz = solution.sequence.modulation.fieldRate_Hz;
    solution.sequence.report.surface = haptics::surfaceStatistics(
        feltSurface(arguments, solution.points.positions, solution.scene, solution.sequence.evened),
        solution.scene.array,
        solution.scene.medium,
        solution.sequence.fields,
        options);
}

/// Rates the effect of ringing on the fields as played, and on their level at the points.
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

/// Rates the effect of 1 K on the field, or on the first of the fields in turn that has points.
void rateKelvin(const SolveArguments& arguments, Solution& solution)
{
    const haptics::FieldSequence& sequence = solution.sequence;
    // What scatters isn't known at another temperature.
    if (sequence.evened || solution.truth) return;
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

/// Returns a certifier with the solver's regularisation. Throws InputError if it is too weak for a
/// bound.
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
        haptics::ControlPoints points = sequence.parts[k];
        if (solution.truth)
        {
            solution.truth->setDrive(sequence.fields[k]);
            points.outside_Pa = solution.truth->beyond_Pa(points.positions, solution.scene.array);
        }
        solution.parts.certificate = certifierOf(arguments).certify(
            points, solution.scene.array, solution.scene.medium, sequence.fields[k]);
        return;
    }
}

/// Returns the places to probe: those of --probe, then the control points or the surface's places
/// within --probe-patch of a --probe. Throws base::InputError if there are none, or more than 10^7
/// samples in total.
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
            feltSurface(arguments, controlPoints, scene, false), places, arguments.probePatch_m);
        if (places.cols() == 0)
            throw base::InputError(
                fmt::format("--probe-patch: no point of the surface is within {:g} m of a --probe",
                            arguments.probePatch_m));
    }
    if (arguments.probePoints) append(controlPoints, places);
    if (places.cols() == 0) throw base::InputError("--probe-points: there are no control points");
    const double samples = static_cast<double>(places.cols()) * options.samples();
    if (samples > kMostSamples)
        throw base::InputError(fmt::format("{} probes of {} samples exceed the limit of {:g} "
                                           "samples: shorten --duration, or lower --probe-rate",
                                           places.cols(),
                                           options.samples(),
                                           kMostSamples));
    return places;
}

/// Probes \a sequence at \a places (3 x n). Throws base::InputError.
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

double SolveEars::levelOf_dB(const haptics::TransducerArray& array,
                             const haptics::Medium& medium,
                             const std::vector<Eigen::VectorXcf>& fields) const
{
    haptics::Exposure exposure(array, medium, _exposure->places());
    return bridge::steadyExposure(exposure, fields, _limit_dB).level_dB;
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
    if (arguments.certify) certifierOf(arguments); // fail now rather than after a long solve
    if (arguments.hasTolerance && !arguments.scattererFile.empty())
        throw base::InputError("--tolerance doesn't know what scatters; leave out --scatterer");
    if (!arguments.scattererAt_m.empty() && arguments.scattererFile != kScatteringHand)
        throw base::InputError("--scatterer-at places a hand; use --scatterer hand");
    solution.scene = loadScene(arguments);
    bridge::SolveTask task = taskOf(arguments, solution.scene);
    solution.ears = std::make_shared<SolveEars>(
        solution.scene.array,
        solution.scene.medium,
        arguments.earsFile.empty() ? Eigen::Matrix3Xd(3, 0) : readEars(arguments.earsFile),
        arguments.settings.earLimit);
    task.ears = solution.ears->bound();
    loadScatterer(arguments, task, solution);
    if (solution.truth)
        task.outside_Pa = [&solution](const Eigen::Matrix3Xd& places, const Eigen::VectorXcf& q)
        {
            solution.truth->setDrive(q);
            return solution.truth->beyond_Pa(places, solution.scene.array);
        };
    if (solution.scene.array.reflectors.empty())
        static_cast<bridge::SolvedFields&>(solution) = bridge::solveOnce(task);
    else
        solveWithReflectors(arguments, task, solution);
    if (solution.truth) correctForScatterer(arguments, task, solution);
    const haptics::SolveReport& report = solution.sequence.report;
    solution.parts.exposure = solution.ears->figures(solution.sequence.fields);
    solution.parts.fingertip = haptics::strongestForce(solution.points,
                                                       solution.achieved_Pa,
                                                       solution.scene.array,
                                                       solution.scene.medium,
                                                       solution.sequence);
    solution.parts.fingertip.threshold_N = arguments.settings.feelThreshold;
    solution.parts.fields = static_cast<int>(solution.sequence.fields.size());
    solution.parts.evened = solution.sequence.evened;
    solution.parts.fieldRate_Hz = arguments.settings.fieldRate;
    const bool isModel = arguments.pointsFile.empty();
    if (isModel && solution.points.size() > 0) measureSurface(arguments, solution);
    rateRinging(arguments, solution);
    rateKelvin(arguments, solution);
    if (!arguments.probes.empty() || arguments.probePoints)
        solution.probe = probe(arguments,
                               probePlaces(arguments, solution.points.positions, solution.scene),
                               solution.sequence,
                               solution.scene);
    if (arguments.hasTolerance)
        solution.tolerance = haptics::toleranceOf(
            solution.sequence, solution.scene.array, solution.scene.medium, arguments.tolerance);
    if (arguments.certify && solution.parts.evened)
        std::fprintf(stderr,
                     "midair-solve: no certificate, because what is played is evened out over the "
                     "surface, not solved for at points; --even 0 turns that off\n");
    else if (arguments.certify && report.level_Pa > 0.0)
        certify(arguments, solution);
    return solution;
}

} // namespace midair::samples
