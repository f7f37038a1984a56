#include "samples/tools/solve/SolvePoints.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/FittingSize.h"
#include "haptics/points/Workspace.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldSettings.h"
#include "haptics/sequence/FocusShare.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "samples/tools/solve/SolveFiles.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>

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
Eigen::Matrix3Xd
samplesOf(const SolveArguments& arguments, const SolveScene& scene, double spacing_m)
{
    haptics::SamplerOptions sampling;
    sampling.spacing_m = spacing_m;
    sampling.sampling = arguments.outline ? haptics::Sampling::EDGES : arguments.sampling;
    sampling.maxPoints = 200000;
    return scene.pose * haptics::sampleSurface(scene.mesh, sampling).positions;
}

/// Returns the model's samples in the array frame, a set for each field; all targets are 1, or the
/// wanted pressure.
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

/// Points from the user's file are kept unchanged, without doubles, unless the user says what is
/// done with crowded ones.
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

/// Asks about a model that is one focus, and returns how many points it would have at the size that
/// fits; 0: it is more than a focus.
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
    std::fprintf(stderr,
                 "midair-solve: object.small: the model is %.3g m wide, under half a wavelength "
                 "(%.2g m): it is one focus, and no louder than one point of something larger",
                 model.width_m,
                 0.5 * scene.wavelength_m());
    std::fprintf(stderr, size_m > 0.0 ? "; --size %g fits\n" : "\n", size_m);
    return haptics::pointsAtSize(scene.mesh, sampling, size_m, options.maxPoints);
}

/// Leaves out points that the array can't reach, with a message.
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
    if (!left.empty()) std::fprintf(stderr, "midair-solve: solves for %s\n", left.c_str());
    selection.points.absolute = absolute;
    return std::move(selection.points);
}

} // namespace

SolveScene loadScene(const SolveArguments& arguments)
{
    SolveScene scene;
    scene.array = haptics::TransducerArray::load(arguments.array);
    scene.array.mark(arguments.settings.dead, arguments.settings.weak);
    if (bridge::keepToSignal(scene.array.drive))
        std::fprintf(stderr,
                     "midair-solve: the array has finer phases than the 256 levels of a drive: "
                     "solves for 256\n");
    if (!arguments.directivity.empty())
        scene.array.directivity = haptics::directivityFromName(arguments.directivity);
    if (arguments.ringing_s >= 0.0) scene.array.ringing_s = arguments.ringing_s;
    scene.medium = haptics::mediumOf(arguments.settings);
    std::string error;
    if (!scene.medium.isValid(&error)) throw base::InputError(error);
    if (!arguments.pointsFile.empty()) return scene;
    std::vector<std::string> warnings;
    scene.mesh = haptics::readObj(arguments.model, &warnings);
    for (const std::string& warning : warnings)
        std::fprintf(stderr, "midair-solve: %s\n", warning.c_str());
    if (arguments.size_m > 0.0) scene.mesh = scene.mesh.scaledTo(arguments.size_m);
    scene.pose = poseOf(arguments);
    return scene;
}

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

std::vector<haptics::Outline>
modelOutlines(const SolveArguments& arguments, const SolveScene& scene, bool& any)
{
    if (pointsIfSmall(arguments, scene) > 0)
        throw base::InputError("a model that is one focus has no outline that can be felt");
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
                     "midair-solve: solves for %zu of %zu outlines: %d are not whole within the "
                     "array's reach\n",
                     reached.inside.size(),
                     all,
                     reached.outside);
    if (reached.apart > 0)
        std::fprintf(stderr,
                     "midair-solve: %d points of the model are on no outline: left out (without "
                     "--outline they are solved for)\n",
                     reached.apart);
    return std::move(reached.inside);
}

haptics::ControlPoints placesToEven(const SolveArguments& arguments,
                                    const haptics::ControlPoints& points,
                                    const SolveScene& scene)
{
    for (const double spacing : haptics::kPlaceSpacings)
    {
        const double spacing_m = spacing * scene.wavelength_m();
        haptics::ControlPoints places = haptics::feltPlaces(
            samplesOf(arguments, scene, spacing_m),
            points,
            haptics::kFeltReach * std::max(spacingOf(arguments, scene), spacing_m));
        if (places.size() <= haptics::kMostPlaces) return places;
    }
    std::fprintf(stderr,
                 "midair-solve: the fields are not evened out: the surface has more than %d "
                 "places %g wavelengths apart\n",
                 haptics::kMostPlaces,
                 haptics::kPlaceSpacings.back());
    return {};
}

Eigen::Matrix3Xd feltSurface(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& points,
                             const SolveScene& scene)
{
    // No place is farther than kFeltReach times this from a sample.
    const double sampled_m = 0.18 * scene.wavelength_m();
    // Not less than the samples' spacing, or a point might have no samples.
    const double spacing_m = std::max(spacingOf(arguments, scene), sampled_m);
    return haptics::samplesNear(
        samplesOf(arguments, scene, sampled_m), points, haptics::kFeltReach * spacing_m);
}

} // namespace midair::samples
