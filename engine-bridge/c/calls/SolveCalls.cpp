// midair_solve() and midair_solver_..(): fields that nothing plays.
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/rendering/ObjectModulation.h"
#include "engine-bridge/solving/OneSolve.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr int kMostPointsAtOnce = 2000; // as midair-solve; more than while objects move

/// What midair_solve() takes from a scene, so that the scene is free while it solves.
struct SolveInput
{
    std::shared_ptr<const ArrayPair> array;
    SceneSettings settings;
    bridge::SceneSnapshot snapshot;
    base::StopToken stop;
};

SolveInput inputOf(Scene& scene)
{
    SolveInput input;
    {
        const base::Lock lock(scene.mutex);
        const std::string why = scene.whySilenced();
        if (!why.empty()) fail(MIDAIR_SILENCED, why);
        input.array = scene.markedArray();
        input.settings = scene.settings;
        bridge::SceneSnapshot& snapshot = scene.fillSnapshot();
        if (scene.settings.reach > 0.0 || scene.settings.shadows)
            scene.player.locateHands(Eigen::Isometry3d::Identity());
        input.snapshot = snapshot;
        input.snapshot.around.reach_m = scene.settings.reach;
        input.snapshot.around.shadows = scene.settings.shadows;
    }
    if (input.settings.maxPoints == 0) input.settings.maxPoints = kMostPointsAtOnce;
    const base::Lock lock(scene.solveMutex);
    input.stop = scene.stop->token();
    return input;
}

/// The number of shifted sets of points that the objects can give.
int setsOf(const SolveInput& input)
{
    const bool isAny =
        std::any_of(input.snapshot.objects.begin(),
                    input.snapshot.objects.end(),
                    [](const bridge::HapticObject& object)
                    {
                        using haptics::Sampling;
                        const Sampling sampling = object.properties.sampling;
                        return sampling != Sampling::VERTICES && sampling != Sampling::POINTS;
                    });
    return isAny ? input.settings.cycle : 1;
}

/// Selects the points of each set within the reach of hands.
std::vector<haptics::ControlPoints>
pointSets(const SolveInput& input, bridge::ReachAndShadow& around, base::MessageLog& messages)
{
    bridge::PointAssembler::Options options;
    options.wavelength_m =
        haptics::mediumOf(input.settings).wavelength(input.array->solvable.frequency_Hz);
    options.maxPoints = input.settings.maxPoints;
    options.sets = setsOf(input);
    options.loudness = input.settings.loudness;
    bridge::PointAssembler assembler(input.array->solvable, options, messages);
    assembler.setStop(input.stop);
    around.begin(input.snapshot.around);
    std::vector<haptics::ControlPoints> sets;
    for (int set = 0; set < options.sets; ++set)
    {
        bridge::AssembledPoints assembled = assembler.assemble(input.snapshot, set);
        around.keepWithinReach(assembled.points, assembled.skipped);
        // Identities let a solver go on from an earlier field, and there is none.
        assembled.points.identity.clear();
        sets.push_back(std::move(assembled.points));
    }
    return sets;
}

haptics::ControlPoints placesToEven(const SolveInput& input,
                                    const std::vector<haptics::ControlPoints>& sets,
                                    double wavelength_m)
{
    if (sets.size() == 1 || input.settings.even == 0) return {};
    haptics::ControlPoints all;
    for (const haptics::ControlPoints& set : sets)
        append(all, set);
    bridge::FeltSurface surface(wavelength_m);
    surface.setStop(input.stop);
    return surface.places(input.snapshot.objects, all).value_or(haptics::ControlPoints());
}

/// What listens, where there is an ear limit.
std::unique_ptr<bridge::EarBound> earsOf(const SolveInput& input,
                                         const haptics::TransducerArray& array,
                                         const haptics::Medium& medium,
                                         const Eigen::Matrix3Xd& given)
{
    if (input.settings.earLimit == 0.0) return nullptr;
    return std::make_unique<bridge::EarBound>(
        input.settings.earLimit,
        std::make_shared<haptics::Exposure>(array, medium, placesHeard(array, given)));
}

std::shared_ptr<Field> solved(const SolveInput& input, base::MessageLog& messages)
{
    auto field = std::make_shared<Field>();
    field->medium = haptics::mediumOf(input.settings);
    readPlaces(input.settings.earPoints, field->ears);
    field->earLimit_dB = input.settings.earLimit;
    bridge::ReachAndShadow around;
    std::vector<haptics::ControlPoints> sets = pointSets(input, around, messages);
    const double wavelength_m = field->medium.wavelength(input.array->solvable.frequency_Hz);
    const haptics::TransducerArray& array =
        around.shadowed(sets.front(), input.array->solvable, wavelength_m);
    const bool isShadowed = &array != &input.array->solvable;
    field->array =
        isShadowed
            ? std::make_shared<const haptics::TransducerArray>(array)
            : std::shared_ptr<const haptics::TransducerArray>(input.array, &input.array->solvable);
    const auto ears = earsOf(input, *field->array, field->medium, field->ears);
    bridge::SolveTask task{*field->array, field->medium, input.settings};
    task.places = placesToEven(input, sets, wavelength_m);
    if (sets.size() == 1)
        task.plan = bridge::modulationOf(input.snapshot.objects, sets.front(), {}, messages);
    task.sets = std::move(sets);
    task.ears = ears.get();
    task.remedy = {"maxPressure", "pressure or loudness", "maxAmplitude", "earLimit"};
    task.makeSolver = bridge::makeAnySolver;
    task.stop = input.stop;
    bridge::SolvedFields fields = bridge::solveOnce(task);
    haptics::rateRinging(fields.sequence, field->array->ringing_s);
    field->drive = field->array->drive;
    field->sequence = std::move(fields.sequence);
    field->signals = std::move(fields.signals);
    field->points = std::move(fields.points);
    field->wanted_Pa = std::move(fields.target_Pa);
    field->achieved_Pa = std::move(fields.achieved_Pa);
    for (const bridge::HapticObject& object : input.snapshot.objects)
        field->objects.push_back(object.id);
    field->complete();
    return field;
}

} // namespace

midair_status midair_solve(midair_scene* scene, midair_field** field)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(field, "field");
            const SolveInput input = inputOf(*of);
            base::MessageLog messages;
            std::shared_ptr<Field> made;
            try
            {
                made = solved(input, messages);
            }
            catch (const base::InputError& error) // of fields in turn
            {
                failUnsolved(input.settings.solver, error.what());
            }
            {
                const base::Lock lock(of->mutex);
                for (const base::Message& message : messages.messages())
                    of->player.log().take(message);
            }
            haptics::SolveReport& report = made->sequence.report;
            if (report.stop == haptics::StopReason::STOPPED) throw base::Stopped();
            requireSolved(report);
            if (const auto left = messages.all(); report.message.empty() && isSilence(*made))
                report.message = left.empty() ? "there are no control points" : left.front();
            *field = fields().add(made);
            return soundsOrWhy(*made);
        });
}

midair_status midair_cancel(midair_scene* scene)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->solveMutex);
            of->stop->request();
            of->stop = std::make_shared<base::StopSource>();
        });
}
