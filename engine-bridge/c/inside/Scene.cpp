#include "engine-bridge/c/inside/Scene.h"

#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::capi
{

void Misunderstood::note(std::vector<std::string> names, std::string why)
{
    for (const std::string& name : names)
        settle(name);
    _all.push_back({std::move(names), std::move(why)});
}

void Misunderstood::settle(const std::string& name)
{
    const auto isMeant = [&](const Wrong& one)
    { return std::find(one.names.begin(), one.names.end(), name) != one.names.end(); };
    _all.erase(std::remove_if(_all.begin(), _all.end(), isMeant), _all.end());
}

const std::string& Misunderstood::why() const
{
    static const std::string none;
    return _all.empty() ? none : _all.front().why;
}

std::string Scene::whySilenced() const
{
    if (!misunderstood.why().empty()) return misunderstood.why();
    for (const auto& [number, object] : objects)
        if (!object.misunderstood.why().empty())
            return fmt::format("object {}: {}", number, object.misunderstood.why());
    try
    {
        markedArray();
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return settings.enabled ? "" : "the scene is not enabled";
}

std::shared_ptr<const ArrayPair> Scene::markedArray() const
{
    if (settings.dead.empty() && settings.weak.empty()) return array;
    const std::string marks = settings.dead + "\n" + settings.weak;
    if (!_marked || marks != _marks)
    {
        auto pair = std::make_shared<ArrayPair>(*array);
        pair->given.mark(settings.dead, settings.weak);
        pair->solvable.mark(settings.dead, settings.weak);
        _marked = std::move(pair);
        _marks = marks;
    }
    return _marked;
}

void Scene::silence()
{
    bridge::SceneSnapshot none;
    if (thread) thread->submit(none);
}

bridge::SceneSnapshot Scene::snapshot() const
{
    bridge::SceneSnapshot now;
    now.frame = frame;
    now.time_s = base::steadySeconds();
    now.objects.reserve(objects.size());
    for (const auto& [number, object] : objects)
    {
        if (!object.properties.enabled) continue;
        bridge::HapticObject& felt = now.objects.emplace_back();
        felt.id = number;
        felt.path = fmt::format("object {}", number);
        felt.meshId = object.meshId;
        felt.topologyId = object.topologyId;
        felt.mesh = object.mesh;
        felt.pose = object.pose;
        felt.properties = object.felt;
        felt.touchEvents = object.properties.touchEvents;
        felt.origin = object.number;
    }
    now.around.reach_m = settings.reach;
    now.around.shadows = settings.shadows;
    return now;
}

std::unique_ptr<bridge::HologramThread> Scene::endPlaying()
{
    device.clear();
    proximity = std::make_unique<bridge::HandProximity>(); // nothing is touched any more
    return std::move(thread);
}

Handles<midair_array, const ArrayPair>& arrays()
{
    // Never destroyed, as threads of the application may outlive static objects.
    static auto* const all = new Handles<midair_array, const ArrayPair>("midair_array");
    return *all;
}

Handles<midair_scene, Scene>& scenes()
{
    static auto* const all = new Handles<midair_scene, Scene>("midair_scene");
    return *all;
}

std::shared_ptr<Scene> sceneOf(midair_scene* handle)
{
    if (CallbackScope::isInside())
        fail(MIDAIR_INVALID, "a callback may not call a function with a scene or a solver");
    return scenes().find(handle);
}

SceneObject& objectOf(Scene& scene, midair_object object)
{
    const auto found = scene.objects.find(object);
    if (found == scene.objects.end())
        fail(MIDAIR_UNKNOWN, fmt::format("the scene has no object {}", object));
    return found->second;
}

} // namespace midair::capi

using namespace midair::capi;

midair_status midair_scene_make(midair_array* array, midair_scene** scene)
{
    return called(
        [&]
        {
            given(scene, "scene");
            auto made = std::make_shared<Scene>();
            made->array = arrays().find(array);
            *scene = scenes().add(std::move(made));
            return MIDAIR_OK;
        });
}

midair_status midair_scene_close(midair_scene* scene)
{
    return called(
        [&]
        {
            sceneOf(scene);
            const std::shared_ptr<Scene> closed = scenes().take(scene);
            {
                const std::lock_guard<std::mutex> lock(closed->solveMutex);
                closed->stop->request();
            }
            std::unique_ptr<midair::bridge::HologramThread> thread;
            std::unique_ptr<midair::bridge::HandSource> source;
            {
                const std::lock_guard<std::mutex> lock(closed->mutex);
                closed->isClosed = true;
                thread = closed->endPlaying();
                source = std::move(closed->source);
            }
            thread.reset();
            source.reset();
            return MIDAIR_OK;
        });
}
