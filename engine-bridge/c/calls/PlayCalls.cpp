// midair_play() and its like: a scene on a device.
#include "device/DeviceUri.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/threads/SteadyClock.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

static_assert(static_cast<int>(bridge::ArrayState::CLOSED) == MIDAIR_STATE_CLOSED);
static_assert(static_cast<int>(bridge::ArrayState::OPENING) == MIDAIR_STATE_OPENING);
static_assert(static_cast<int>(bridge::ArrayState::SILENT) == MIDAIR_STATE_SILENT);
static_assert(static_cast<int>(bridge::ArrayState::PLAYING) == MIDAIR_STATE_PLAYING);
static_assert(static_cast<int>(bridge::ArrayState::MUTED) == MIDAIR_STATE_MUTED);
static_assert(static_cast<int>(bridge::ArrayState::LOST) == MIDAIR_STATE_LOST);
static_assert(static_cast<int>(bridge::ArrayState::FAULT) == MIDAIR_STATE_FAULT);

/// Waits for other threads' calls for at most a second.
bool locks(base::Mutex& mutex) MIDAIR_THREADS(try_acquire_capability(true, mutex))
{
    const double end_s = base::steadySeconds() + 1.0;
    while (!mutex.try_lock())
    {
        if (base::steadySeconds() > end_s) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

/// Ends all playing, since what a device was given last would sound on after the program's end. A
/// mute comes first, and stays: no end waits for a callback that hangs, and nothing is played past
/// it.
void stopAll()
{
    const auto all = scenes().all();
    for (const std::shared_ptr<Scene>& scene : all)
        scene->setMuted(true);
    for (const std::shared_ptr<Scene>& scene : all)
    {
        if (!locks(scene->mutex)) continue;
        scene->isClosed = true;
        const std::shared_ptr<void> ended = scene->endPlaying(); // dies without the mutex
        scene->mutex.unlock();
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

/// Fails for what is no URI, or plays by itself.
void requireDevice(const std::string& device)
{
    if (device::playsByItself(device))
        fail(MIDAIR_REFUSED, "device \"" + device + "\": a recording takes no fields of a scene");
}

void requirePlaying(const Scene& scene) MIDAIR_REQUIRES(scene.mutex)
{
    if (scene.device.empty()) fail(MIDAIR_NOT_YET, "nothing is played: midair_play() begins");
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
            std::shared_ptr<void> before;
            {
                const base::Lock lock(of->mutex);
                before = of->endPlaying();
            }
            before.reset(); // its device is closed before the other one is opened
            const base::Lock lock(of->mutex);
            if (of->isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
            if (!of->device.empty())
                fail(MIDAIR_INVALID, "another thread plays the scene at the same time");
            of->device = uri;
            std::error_code ignored;
            of->followsFile = std::filesystem::is_regular_file(of->array->file, ignored);
            of->isTimed = false;
            of->configure();
            of->player.open();
        });
}

midair_status midair_update(midair_scene* scene, double time_s)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            requireFinite(&time_s, 1, "time_s");
            const base::Lock lock(of->mutex);
            requirePlaying(*of);
            if (of->isTimed && time_s < of->time_s)
                fail(MIDAIR_INVALID,
                     fmt::format("time_s is {:g}, that of the update before was {:g}; it must not "
                                 "decrease",
                                 time_s,
                                 of->time_s));
            of->time_s = time_s;
            of->isTimed = true;
            ++of->frame;
            of->player.rest();
            const std::string why = of->whySilenced();
            if (!why.empty())
            {
                of->player.silence();
                fail(MIDAIR_SILENCED, why);
            }
            of->configure();
            of->fillSnapshot();
            of->player.play(Eigen::Isometry3d::Identity());
            if (!of->player.whySilenced().empty())
                fail(MIDAIR_SILENCED, of->player.whySilenced().front());
        });
}

midair_status midair_stop(midair_scene* scene)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            of->silenceNow();
            std::shared_ptr<void> ended; // dies without the mutex
            const base::Lock lock(of->mutex);
            ended = of->endPlaying();
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
            of->setMuted(muted != 0);
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
            const base::Lock lock(of->mutex);
            if (!of->device.empty())
            {
                const bridge::ArrayReading reading = of->player.reading();
                const bridge::ArrayFields& counted = reading.fields;
                now.state = static_cast<int32_t>(reading.state);
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
        });
}

midair_status midair_device_status(midair_scene* scene, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            requirePlaying(*of);
            return writeText(of->player.reading().status, text, size, needed);
        });
}

midair_status midair_messages(midair_scene* scene, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            of->player.takeResult();
            return writeText(
                fmt::format("{}", fmt::join(of->player.log().all(), "\n")), text, size, needed);
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
                const base::Lock lock(of->mutex);
                requirePlaying(*of);
                newest = of->player.latestResult();
                const SceneSettings played = of->player.playedSettings();
                earLimit_dB = played.earLimit;
                readPlaces(played.earPoints, ears);
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
            return soundsOrWhy(*made);
        });
}
