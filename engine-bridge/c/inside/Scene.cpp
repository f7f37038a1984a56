#include "engine-bridge/c/inside/Scene.h"

#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/sensations/SensationLibrary.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <pthread.h>

namespace midair::capi
{

bridge::HapticProperties forPipeline(const ObjectSettings& properties)
{
    const bridge::ObjectMaterial made = bridge::materialOf(properties);
    if (!made.problem.empty()) fail(made.isUnknown ? MIDAIR_UNKNOWN : MIDAIR_INVALID, made.problem);
    bridge::HapticProperties felt = bridge::propertiesOf(properties, made.material);
    if (const std::string problem = bridge::sensationOf(properties).problem; !problem.empty())
        fail(felt.sensation.pattern ? MIDAIR_INVALID : MIDAIR_REFUSED, problem);
    return felt;
}

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

ArrayPair::ArrayPair(haptics::TransducerArray array, std::string itsFile) :
    given(array),
    solvable(std::move(array)),
    file(std::move(itsFile))
{
    bridge::keepToSignal(solvable.drive);
}

bool SetHands::frameAt(double time_s, bridge::HandFrame& frame)
{
    const double now_s = base::steadySeconds();
    const bool any = bridge::InjectedHandSource::frameAt(now_s, frame);
    for (bridge::Hand& hand : frame.hands)
        hand.age_s += now_s - frame.time_s;
    frame.time_s = time_s;
    return any;
}

bool SetHead::headAt(double time_s, bridge::Head& head)
{
    const double now_s = base::steadySeconds();
    const bool isTracked = bridge::InjectedHeadSource::headAt(now_s, head);
    head.age_s += now_s - head.time_s;
    head.time_s = time_s;
    return isTracked;
}

Scene::Scene(std::shared_ptr<const ArrayPair> itsArray) :
    array(std::move(itsArray)),
    player({{}, [](const std::string& uri) { return bridge::openHands(uri); }})
{
    player.setHandSource(hands);
    player.setHeadSource(head);
}

std::vector<base::Message> Scene::faults() const
{
    using base::MessageCode;
    std::vector<base::Message> all;
    if (!misunderstood.why().empty())
        all.emplace_back(MessageCode::SETTINGS_SILENCED, misunderstood.why());
    for (const auto& [number, object] : objects)
        if (!object.misunderstood.why().empty())
            all.push_back(base::about(MessageCode::PROPERTY_SILENCED,
                                      fmt::format("object {}", number),
                                      object.misunderstood.why(),
                                      object.number));
    try
    {
        markedArray();
    }
    catch (const base::InputError& error)
    {
        all.emplace_back(MessageCode::ARRAY_INVALID, error.what());
    }
    return all;
}

std::string Scene::whySilenced(const std::vector<base::Message>& all) const
{
    if (!all.empty()) return all.front().text;
    return settings.enabled ? "" : "the scene is not enabled";
}

std::shared_ptr<const ArrayPair> Scene::markedArray() const
{
    const auto read = followsFile ? player.array() : nullptr;
    if (read != _read || !_current)
    {
        _read = read;
        _current = read ? std::make_shared<const ArrayPair>(*read, array->file) : array;
        _marked.reset();
    }
    if (settings.dead.empty() && settings.weak.empty()) return _current;
    const std::string marks = settings.dead + "\n" + settings.weak;
    if (!_marked || marks != _marks)
    {
        auto pair = std::make_shared<ArrayPair>(*_current);
        pair->given.mark(settings.dead, settings.weak);
        pair->solvable.mark(settings.dead, settings.weak);
        _marked = std::move(pair);
        _marks = marks;
    }
    return _marked;
}

void Scene::configure()
{
    SceneSettings used = settings;
    used.enabled = true; // a disabled scene keeps its device; whySilenced() handles it
    bridge::PlayedOn on;
    if (followsFile)
        on.array = array->file;
    else
        on.described = array;
    on.make = [given = array] { return given->given; };
    on.device = device;
    if (device.empty()) on = {};
    if (!sceneTable().areSame(used, player.settings()) || !(on == player.playedOn()))
        player.configure(std::make_shared<const SceneSettings>(used), on, "a scene of libmidair");
    else
        player.refresh();
}

bridge::SceneSnapshot& Scene::fillSnapshot()
{
    bridge::SceneSnapshot& now = player.snapshot();
    now.frame = frame;
    now.time_s = base::steadySeconds();
    now.simulationTime_s = time_s;
    now.ears = ears;
    now.reflectors = reflectors;
    player.locateHead(time_s);
    if (const auto& last = player.heads().lastPlace())
    {
        now.ears.conservativeResize(3, ears.cols() + 2);
        now.ears.rightCols<2>() = bridge::earsOf(*last);
    }
    bridge::Viewing viewing;
    viewing.display = display;
    viewing.head = player.heads().lastPlace().value_or(viewing.head);
    if (display && !player.heads().head().isTracked)
        viewing.lost = player.heads().lastPlace() ? "the head is lost" : "no head is known";
    player.setViewing(std::move(viewing));
    now.objects.clear();
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
    return now;
}

std::shared_ptr<void> Scene::endPlaying()
{
    device.clear();
    return player.end();
}

namespace
{

/// Blocks handle lookups during a fork, so that the child can look up handles.
void lockHandles() MIDAIR_NO_THREAD_ANALYSIS
{
    arrays().lock();
    scenes().lock();
    fields().lock();
}

void unlockHandles() MIDAIR_NO_THREAD_ANALYSIS
{
    fields().unlock();
    scenes().unlock();
    arrays().unlock();
}

const int kForkIsWatched = ::pthread_atfork(lockHandles, unlockHandles, unlockHandles);

/// Returns a scene of this process equal to \a before that isn't played: threads and devices of the
/// original belong to the parent.
std::shared_ptr<Scene> heirOf(Scene& before)
{
    auto heir = std::make_shared<Scene>(before.array);
    const base::Lock lock(heir->mutex);
    heir->isHeir = true;
    heir->player.log().say({base::MessageCode::SCENE_CLOSED, base::kForked});
    if (!before.mutex.try_lock())
    {
        // Another thread of the parent was using it, so its state is undefined.
        heir->isClosed = true;
        return heir;
    }
    heir->settings = before.settings;
    heir->misunderstood = before.misunderstood;
    heir->objects = before.objects;
    heir->ears = before.ears;
    before.mutex.unlock();
    return heir;
}

} // namespace

Handles<midair_array, const ArrayPair>& arrays()
{
    // Never destroyed, because threads of the application may outlive static objects.
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
    static_cast<void>(kForkIsWatched);
    std::shared_ptr<Scene> scene = scenes().find(handle);
    if (!scene->isOurs) scene = scenes().replace(handle, scene, heirOf(*scene));
    return scene;
}

void refuseUnused(const SceneSettings& settings,
                  const char* who,
                  const std::function<bool(const base::SettingFacts& row)>& isUsed)
{
    static const haptics::FieldSettings kDefaults;
    for (const auto& row : haptics::fieldSettings().rows())
    {
        if (isUsed(row)) continue;
        if (base::isSame<haptics::FieldSettings>(row.member, settings, kDefaults)) continue;
        fail(MIDAIR_REFUSED,
             fmt::format("{} {} no {}, which is {}{}: use midair_solve()",
                         who,
                         row.isSafety ? "keeps" : "knows",
                         row.name,
                         row.defaultText(settings),
                         row.unit.empty() ? "" : " " + row.unit));
    }
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
            *scene = scenes().add(std::make_shared<Scene>(arrays().find(array)));
        });
}

midair_status midair_scene_close(midair_scene* scene)
{
    return called(
        [&]
        {
            sceneOf(scene);
            const std::shared_ptr<Scene> closed = scenes().take(scene);
            closed->silenceNow();
            {
                const midair::base::Lock lock(closed->solveMutex);
                closed->stop->request();
            }
            std::shared_ptr<void> ended; // destroyed without the mutex, like the next one
            std::shared_ptr<midair::bridge::HandSource> source;
            std::shared_ptr<midair::bridge::HeadSource> head;
            const midair::base::Lock lock(closed->mutex);
            closed->isClosed = true;
            ended = closed->endPlaying();
            source = closed->player.hands().active();
            closed->player.setHandSource(nullptr);
            head = closed->player.heads().active();
            closed->player.setHeadSource(nullptr);
        });
}
