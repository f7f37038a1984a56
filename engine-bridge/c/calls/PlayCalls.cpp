// midair_play() and its like: a scene on a device.
#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "device/limits/UserLimits.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

static_assert(static_cast<int>(bridge::ArrayState::CLOSED) == MIDAIR_STATE_CLOSED);
static_assert(static_cast<int>(bridge::ArrayState::OPENING) == MIDAIR_STATE_OPENING);
static_assert(static_cast<int>(bridge::ArrayState::SILENT) == MIDAIR_STATE_QUIET);
static_assert(static_cast<int>(bridge::ArrayState::PLAYING) == MIDAIR_STATE_PLAYING);
static_assert(static_cast<int>(bridge::ArrayState::MUTED) == MIDAIR_STATE_MUTED);
static_assert(static_cast<int>(bridge::ArrayState::LOST) == MIDAIR_STATE_LOST);
static_assert(static_cast<int>(bridge::ArrayState::FAULT) == MIDAIR_STATE_FAULT);

/// Ends all playing, since what a device was given last would sound on after the program's end.
void stopAll()
{
    for (const std::shared_ptr<Scene>& scene : scenes().all())
    {
        std::unique_ptr<bridge::HologramThread> thread;
        {
            const std::lock_guard<std::mutex> lock(scene->mutex);
            scene->isClosed = true;
            thread = scene->endPlaying();
        }
        thread.reset();
    }
}

void stopAtExit()
{
    // What threads use while they end has to be made before, so that it is destroyed after.
    static const bool isSet = []
    {
        bridge::ownSolverNames();
        device::ownSchemes();
        sceneTable();
        return std::atexit(stopAll) == 0;
    }();
    if (!isSet) fail(MIDAIR_FAILED, "the program's end can't be watched: nothing is played");
}

bridge::HologramThread::PipelineFactory makerOf(const Scene& scene)
{
    return [options = optionsOf(scene.applied, scene.appliedCaps),
            array = scene.markedArray(),
            device = scene.device]() mutable
    {
        options.array = array->given;
        options.deviceUri = device;
        return std::make_unique<bridge::HologramPipeline>(options);
    };
}

void applySettings(Scene& scene)
{
    device::UserCaps caps = device::capsOfUser();
    if (sceneTable().areSame(scene.settings, scene.applied) && caps == scene.appliedCaps) return;
    scene.applied = scene.settings;
    scene.appliedCaps = std::move(caps);
    bridge::HologramOptions options = optionsOf(scene.applied, scene.appliedCaps);
    options.array = scene.markedArray()->given;
    options.deviceUri = scene.device;
    scene.thread->setOptions(std::move(options), makerOf(scene));
}

/// Fails for what is no URI, or plays by itself.
void requireDevice(const std::string& device)
{
    if (device::playsByItself(device))
        fail(MIDAIR_REFUSED, "device \"" + device + "\": a recording takes no fields of a scene");
}

bridge::HologramThread& threadOf(Scene& scene)
{
    if (!scene.thread) fail(MIDAIR_NOT_YET, "nothing is played: midair_play() begins");
    return *scene.thread;
}

} // namespace

midair_status midair_play(midair_scene* scene, const char* device)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string uri = textGiven(device, "device", 4096);
            requireDevice(uri);
            stopAtExit();
            std::unique_ptr<bridge::HologramThread> before;
            {
                const std::lock_guard<std::mutex> lock(of->mutex);
                before = of->endPlaying();
            }
            before.reset(); // its device is closed before the other one is opened
            const std::lock_guard<std::mutex> lock(of->mutex);
            if (of->isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
            if (of->thread) fail(MIDAIR_INVALID, "another thread plays the scene at the same time");
            of->device = uri;
            of->applied = of->settings;
            of->appliedCaps = device::capsOfUser();
            of->isTimed = false;
            of->thread = std::make_unique<bridge::HologramThread>(makerOf(*of));
            of->thread->setMuted(of->isMuted);
            // So that the device is opened before the first update.
            of->silence();
            return MIDAIR_OK;
        });
}

midair_status midair_update(midair_scene* scene, double time_s)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            requireFinite(&time_s, 1, "time_s");
            const std::lock_guard<std::mutex> lock(of->mutex);
            bridge::HologramThread& thread = threadOf(*of);
            if (of->isTimed && time_s < of->time_s)
                fail(MIDAIR_INVALID,
                     fmt::format("time_s is {:g}, that of the update before was {:g}; it must not "
                                 "decrease",
                                 time_s,
                                 of->time_s));
            of->time_s = time_s;
            of->isTimed = true;
            ++of->frame;
            thread.keepAlive();
            const std::string why = of->whySilenced();
            if (!why.empty())
            {
                of->silence();
                bridge::SceneSnapshot nothing; // ends all touches
                locateHands(*of, time_s, nothing);
                fail(MIDAIR_SILENCED, why);
            }
            applySettings(*of);
            bridge::SceneSnapshot snapshot = of->snapshot();
            snapshot.simulationTime_s = time_s;
            locateHands(*of, time_s, snapshot);
            // A snapshot without objects is silence, which breaks off a solve: hands alone don't.
            thread.submit(snapshot);
            return MIDAIR_OK;
        });
}

midair_status midair_stop(midair_scene* scene)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            std::unique_ptr<bridge::HologramThread> thread;
            {
                const std::lock_guard<std::mutex> lock(of->mutex);
                thread = of->endPlaying();
            }
            thread.reset();
            return MIDAIR_OK;
        });
}

midair_status midair_mute(midair_scene* scene, int32_t muted)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            if (muted != 0 && muted != 1)
                fail(MIDAIR_INVALID, fmt::format("muted is {}; it must be 0 or 1", muted));
            const std::lock_guard<std::mutex> lock(of->mutex);
            of->isMuted = muted != 0;
            if (of->thread) of->thread->setMuted(of->isMuted);
            return MIDAIR_OK;
        });
}

midair_status midair_state(midair_scene* scene, midair_device_state* state)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(state, "state");
            midair_device_state now{};
            const std::lock_guard<std::mutex> lock(of->mutex);
            if (of->thread)
            {
                const bridge::ArrayFields counted = of->thread->reading().fields;
                now.state = static_cast<int32_t>(of->thread->state());
                now.sent = counted.sent;
                now.played = counted.played;
                now.dropped = counted.dropped;
                now.lost = counted.lost;
                now.refused = counted.refused;
                now.waiting = counted.waiting;
                now.faults = counted.faults;
                now.reconnects = counted.reconnects;
            }
            *state = now;
            return MIDAIR_OK;
        });
}

midair_status midair_device_status(midair_scene* scene, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::lock_guard<std::mutex> lock(of->mutex);
            return writeText(threadOf(*of).deviceStatus(), text, size, needed);
        });
}

midair_status midair_messages(midair_scene* scene, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::lock_guard<std::mutex> lock(of->mutex);
            const auto newest = of->thread ? of->thread->latestResult() : nullptr;
            if (newest)
                for (const base::Message& message : newest->told)
                    of->messages.take(message);
            return writeText(
                fmt::format("{}", fmt::join(of->messages.all(), "\n")), text, size, needed);
        });
}

midair_status midair_newest_field(midair_scene* scene, midair_field** field)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(field, "field");
            std::shared_ptr<const bridge::HologramResult> newest;
            std::vector<midair_object> objects;
            double earLimit_dB = 0.0;
            Eigen::Matrix3Xd ears(3, 0);
            {
                const std::lock_guard<std::mutex> lock(of->mutex);
                newest = threadOf(*of).latestResult();
                const device::UserCaps& caps = of->appliedCaps;
                earLimit_dB = device::stricterPressure(of->applied.earLimit, caps.earLimit_dB);
                readPlaces(device::joinedPlaces(of->applied.earPoints, caps.earPoints), ears);
            }
            if (newest)
                for (const auto& origin : newest->origins)
                    objects.push_back(origin ? *static_cast<const midair_object*>(origin.get())
                                             : 0);
            const std::shared_ptr<Field> made = newest ? fieldOf(*newest, objects) : nullptr;
            if (!made || made->info.frame == 0) fail(MIDAIR_NOT_YET, "no field was played so far");
            made->ears = std::move(ears);
            made->earLimit_dB = earLimit_dB;
            *field = fields().add(made);
            return MIDAIR_OK;
        });
}
