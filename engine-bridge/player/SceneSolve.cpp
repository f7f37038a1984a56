#include "engine-bridge/player/SceneSolve.h"

#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "engine-bridge/pipeline/SceneReflectors.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/rendering/ObjectModulation.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr int kMostPointsAtOnce = 2000; // as midair-solve; more than while objects move

/// Number of shifted sets of points that the objects support.
int setsOf(const SceneSolve& scene)
{
    const bool isAny =
        std::any_of(scene.snapshot.objects.begin(),
                    scene.snapshot.objects.end(),
                    [](const HapticObject& object)
                    {
                        using haptics::Sampling;
                        const Sampling sampling = object.properties.sampling;
                        return sampling != Sampling::VERTICES && sampling != Sampling::POINTS;
                    });
    return isAny ? scene.settings.cycle : 1;
}

/// Selects the points of each set within the reach of hands.
std::vector<haptics::ControlPoints>
pointSets(const SceneSolve& scene, ReachAndShadow& around, base::MessageLog& messages)
{
    PointAssembler::Options options;
    options.wavelength_m = haptics::mediumOf(scene.settings).wavelength(scene.array->frequency_Hz);
    options.maxPoints =
        scene.settings.maxPoints == 0 ? kMostPointsAtOnce : scene.settings.maxPoints;
    options.sets = setsOf(scene);
    options.loudness = scene.settings.loudness;
    PointAssembler assembler(*scene.array, options, messages);
    assembler.setStop(scene.stop);
    around.begin(scene.snapshot.around);
    std::vector<haptics::ControlPoints> sets;
    for (int set = 0; set < options.sets; ++set)
    {
        AssembledPoints assembled = assembler.assemble(scene.snapshot, set);
        around.keepWithinReach(assembled.points, assembled.skipped);
        // Identities would let a solver continue an earlier field, and there is none.
        assembled.points.identity.clear();
        sets.push_back(std::move(assembled.points));
    }
    return sets;
}

haptics::ControlPoints placesToEven(const SceneSolve& scene,
                                    const std::vector<haptics::ControlPoints>& sets,
                                    double wavelength_m)
{
    if (sets.size() == 1 || scene.settings.even == 0) return {};
    haptics::ControlPoints all;
    for (const haptics::ControlPoints& set : sets)
        append(all, set);
    FeltSurface surface(wavelength_m);
    surface.setStop(scene.stop);
    const auto found = surface.places(scene.snapshot.objects, all, static_cast<int>(sets.size()));
    return found ? found->places : haptics::ControlPoints();
}

Eigen::Matrix3Xd earsOf(const SceneSolve& scene)
{
    Eigen::Matrix3Xd points(3, 0);
    readPlaces(scene.settings.earPoints, points);
    Eigen::Matrix3Xd all(3, scene.snapshot.ears.cols() + points.cols());
    all << scene.snapshot.ears, points;
    return all;
}

/// Exposure for the ear limit, if there is one.
std::unique_ptr<EarBound> boundOf(const SceneSolve& scene, const SolvedScene& solved)
{
    if (scene.settings.earLimit == 0.0) return nullptr;
    return std::make_unique<EarBound>(
        scene.settings.earLimit,
        std::make_shared<haptics::Exposure>(
            *solved.array, solved.medium, placesHeard(*solved.array, solved.ears)));
}

/// Solves for those of the array's reflectors that are \a corrected.
SolvedScene solveBeside(const SceneSolve& scene,
                        const std::vector<haptics::Reflector>& corrected,
                        base::MessageLog& messages)
{
    SolvedScene solved;
    for (const HapticObject& object : scene.snapshot.objects)
        if (object.properties.sensation.isMeant)
            messages.say(base::about(base::MessageCode::SENSATION_LIMITED,
                                     object.path,
                                     "its sensation is a course in time, which a single field "
                                     "hasn't; it is left out",
                                     object.origin));
    solved.medium = haptics::mediumOf(scene.settings);
    solved.ears = earsOf(scene);
    ReachAndShadow around;
    std::vector<haptics::ControlPoints> sets = pointSets(scene, around, messages);
    const double wavelength_m = solved.medium.wavelength(scene.array->frequency_Hz);
    const haptics::TransducerArray& heard =
        around.shadowed(sets.front(), *scene.array, wavelength_m);
    solved.array = &heard == scene.array.get()
                       ? scene.array
                       : std::make_shared<const haptics::TransducerArray>(heard);
    const auto ears = boundOf(scene, solved);
    SolveTask task{*solved.array, solved.medium, scene.settings};
    haptics::TransducerArray solvedFor;
    if (corrected != solved.array->reflectors)
    {
        solvedFor = *solved.array;
        solvedFor.reflectors = corrected;
        task.solvedFor = &solvedFor;
    }
    task.places = placesToEven(scene, sets, wavelength_m);
    if (sets.size() == 1)
        task.plan = modulationOf(scene.snapshot.objects, sets.front(), {}, messages);
    task.sets = std::move(sets);
    task.ears = ears.get();
    task.remedy = scene.remedy;
    task.makeSolver = makeAnySolver;
    task.stop = scene.stop;
    solved.fields = solveOnce(task);
    haptics::rateRinging(solved.fields.sequence, solved.array->ringing_s);
    return solved;
}

} // namespace

SolvedScene solveScene(const SceneSolve& scene, base::MessageLog& messages)
{
    const SceneReflectors beside = reflectorsBeside(*scene.array, scene.snapshot.reflectors);
    for (const std::string& problem : beside.problems)
        messages.say({base::MessageCode::REFLECTOR_LIMITED, problem});
    if (beside.all == scene.array->reflectors)
        return solveBeside(scene, beside.corrected, messages);
    SceneSolve placed = scene;
    haptics::TransducerArray array = *scene.array;
    array.reflectors = beside.all;
    placed.array = std::make_shared<const haptics::TransducerArray>(std::move(array));
    return solveBeside(placed, beside.corrected, messages);
}

bool isSilent(haptics::StopReason stop)
{
    return stop == haptics::StopReason::REFUSED || stop == haptics::StopReason::NOTHING_TO_DO ||
           stop == haptics::StopReason::SILENCED;
}

Eigen::Matrix3Xd placesHeard(const haptics::TransducerArray& array, const Eigen::Matrix3Xd& ears)
{
    constexpr int kEarsAround = 32;                                            // like midair-solve
    const Eigen::Matrix3Xd around = haptics::placesAround(array, kEarsAround); // or fewer
    Eigen::Matrix3Xd places(3, around.cols() + ears.cols());
    places << around, ears;
    return places;
}

} // namespace midair::bridge
