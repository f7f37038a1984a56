// midair_solve_many(): fields by the thousand.
#include "engine-bridge/c/inside/Scene.h"
#include "haptics/base/InputError.h"
#include "haptics/sequence/FieldSettings.h"
#include "haptics/solvers/many/ManyFields.h"

#include <algorithm>
#include <memory>
#include <tuple>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kMostFields = 1'000'000'000;

/// Input that doesn't depend on the call's arguments, so that the scene is free during the solve.
struct Conditions
{
    std::shared_ptr<const ArrayPair> array;
    haptics::Medium medium;
    haptics::ManyFieldsOptions options;
};

bool isUsedByMany(const base::SettingFacts& row)
{
    for (const char* name :
         {"dead", "weak", "temperature", "humidity", "airPressure", "threads", "fieldRate"})
        if (row.name == name) return true;
    return false;
}

Conditions conditionsOf(Scene& scene)
{
    Conditions all;
    SceneSettings settings;
    {
        const base::Lock lock(scene.mutex);
        if (scene.isHeir && scene.isClosed) fail(MIDAIR_CLOSED, base::kForked);
        const std::string why = scene.whySilenced();
        if (!why.empty()) fail(MIDAIR_SILENCED, why);
        settings = scene.settings;
        all.array = scene.markedArray();
    }
    refuseUnused(settings, "midair_solve_many() solves for sets of points and", isUsedByMany);
    all.medium = haptics::mediumOf(settings);
    all.options.threads = settings.threads;
    const base::Lock lock(scene.solveMutex);
    all.options.stop = scene.stop->token();
    return all;
}

haptics::ManyPoints pointsOf(const midair_many& many)
{
    requireSize(many);
    for (const auto& [count, name, most] :
         {std::tuple{many.fields, "fields", kMostFields},
          {many.points, "points", std::size_t(haptics::ManyFields::kMostPoints)}})
        if (count < 1 || count > most)
            fail(MIDAIR_INVALID, fmt::format("{} is {}; it must be 1 .. {}", name, count, most));
    if (many.same_targets != 0 && many.same_targets != 1)
        fail(MIDAIR_INVALID, fmt::format("same_targets is {}, not 0 or 1", many.same_targets));
    if (many.reserved != 0)
        fail(MIDAIR_INVALID, fmt::format("reserved is {}, not 0", many.reserved));
    given(many.positions, "positions");
    return {static_cast<int>(many.fields),
            static_cast<int>(many.points),
            many.positions,
            many.targets,
            many.same_targets != 0};
}

/// Passes InputErrors of \a check on as invalid arguments.
template<typename Check>
auto requireValid(const Check& check)
{
    try
    {
        return check();
    }
    catch (const base::InputError& error)
    {
        fail(MIDAIR_INVALID, error.what());
    }
}

static_assert(sizeof(midair_many_figures) == sizeof(haptics::ManyFieldsFigures));
static_assert(alignof(midair_many_figures) == alignof(haptics::ManyFieldsFigures));

} // namespace

midair_status midair_solve_many(midair_scene* scene,
                                const midair_many* many,
                                uint8_t* phases,
                                size_t size,
                                midair_many_layout* layout,
                                midair_many_figures* figures)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const midair_many& wanted = given(many, "many");
            const haptics::ManyPoints points = pointsOf(wanted);
            Conditions all = conditionsOf(*of);
            const haptics::TransducerArray& array = all.array->solvable;
            const auto m = static_cast<std::size_t>(array.size());
            haptics::ManyFieldsOptions& options = all.options;
            // A path longer than all fields is all fields.
            options.fieldsInPath = static_cast<int>(std::min(wanted.fields_in_path, kMostFields));
            if (wanted.tolerance != 0.0) options.rmsTolerance = wanted.tolerance;
            options.largestPhaseStep_rad = wanted.largest_phase_step_rad;
            options.seed = wanted.seed;
            const auto solver = requireValid(
                [&] { return std::make_unique<haptics::ManyFields>(array, all.medium, options); });
            if (layout != nullptr)
                *layout = {static_cast<std::uint32_t>(m),
                           static_cast<std::uint32_t>(haptics::ManyFields::phaseLevelsOf(array))};
            if (size == 0) return;
            if (wanted.fields > size / m)
                fail(MIDAIR_TOO_SMALL,
                     fmt::format("size is {}; {} fields of {} transducers take more",
                                 size,
                                 wanted.fields,
                                 m));
            given(phases, "phases");
            requireValid([&] { solver->check(points); });
            solver->solve(points, phases, reinterpret_cast<haptics::ManyFieldsFigures*>(figures));
        });
}
