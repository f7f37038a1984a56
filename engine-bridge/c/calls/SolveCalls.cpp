// midair_solve() and midair_solver_..(): fields that aren't played.
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/player/SceneSolve.h"

#include <utility>

using namespace midair;
using namespace midair::capi;

namespace
{

/// Copies the scene's present state, so that the scene is free during the solve.
bridge::SceneSolve inputOf(Scene& scene)
{
    bridge::SceneSolve input;
    {
        const base::Lock lock(scene.mutex);
        if (scene.isHeir && scene.isClosed) fail(MIDAIR_CLOSED, base::kForked);
        const std::string why = scene.whySilenced();
        if (!why.empty()) fail(MIDAIR_SILENCED, why);
        const std::shared_ptr<const ArrayPair> array = scene.markedArray();
        input.array = {array, &array->solvable};
        input.settings = scene.settings;
        bridge::SceneSnapshot& snapshot = scene.fillSnapshot();
        if (scene.settings.reach > 0.0 || scene.settings.shadows)
            scene.player.locateHands(Eigen::Isometry3d::Identity());
        input.snapshot = snapshot;
        input.snapshot.around.reach_m = scene.settings.reach;
        input.snapshot.around.shadows = scene.settings.shadows;
    }
    input.remedy = {"maxPressure", "pressure or loudness", "maxAmplitude", "earLimit"};
    const base::Lock lock(scene.solveMutex);
    input.stop = scene.stop->token();
    return input;
}

std::shared_ptr<Field> fieldOf(bridge::SolvedScene solved, const bridge::SceneSolve& input)
{
    auto field = std::make_shared<Field>();
    field->array = std::move(solved.array);
    field->medium = solved.medium;
    field->ears = std::move(solved.ears);
    field->earLimit_dB = input.settings.earLimit;
    field->feelThreshold_N = input.settings.feelThreshold;
    field->drive = field->array->drive;
    field->sequence = std::move(solved.fields.sequence);
    field->signals = std::move(solved.fields.signals);
    field->points = std::move(solved.fields.points);
    field->wanted_Pa = std::move(solved.fields.target_Pa);
    field->achieved_Pa = std::move(solved.fields.achieved_Pa);
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
            const bridge::SceneSolve input = inputOf(*of);
            base::MessageLog messages;
            std::shared_ptr<Field> made;
            try
            {
                made = fieldOf(bridge::solveScene(input, messages), input);
            }
            catch (const base::InputError& error) // of fields in turn
            {
                failUnsolved(input.settings.solver, error.what());
            }
            {
                const base::Lock lock(of->mutex);
                for (base::Message& message : messages.messages())
                {
                    message.isActive = false; // it belongs to this solve
                    of->player.log().take(message);
                }
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
