// midair_play() and related calls: a scene on a device.
#include "device/DeviceUri.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
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

// Names among the invalid values.
constexpr const char* kEars = "the ears of midair_set_ears()";
constexpr const char* kReflectors = "the reflectors of midair_set_reflectors()";

/// Silences \a scene until \a what is right again, and fails.
[[noreturn]] void refuse(Scene& scene, const char* what, const std::string& why)
    MIDAIR_REQUIRES(scene.mutex)
{
    scene.misunderstood.note({what}, why + "; nothing is played");
    scene.player.silence();
    fail(MIDAIR_INVALID, scene.misunderstood.why());
}

/// Waits at most a second for other threads' calls.
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

/// Stops all output at the program's end; otherwise a device would play its last field on. Mutes
/// first, permanently: a hanging callback can't block it, and nothing is played afterwards.
void stopAll()
{
    auto all = scenes().all();
    // In the child of a fork they belong to the parent, which continues to play.
    all.erase(std::remove_if(all.begin(),
                             all.end(),
                             [](const std::shared_ptr<Scene>& scene) { return !scene->isOurs; }),
              all.end());
    for (const std::shared_ptr<Scene>& scene : all)
        scene->setMuted(true);
    for (const std::shared_ptr<Scene>& scene : all)
    {
        if (!locks(scene->mutex)) continue;
        scene->isClosed = true;
        const std::shared_ptr<void> ended = scene->endPlaying(); // destroyed without the mutex
        scene->mutex.unlock();
    }
}

void stopAtExit()
{
    // Objects that ending threads use must be made first, so that they are destroyed last.
    static const bool isSet = []
    {
        bridge::ownSolverNames();
        device::ownSchemes();
        sceneTable();
        return std::atexit(stopAll) == 0;
    }();
    if (!isSet) fail(MIDAIR_FAILED, "atexit() failed: nothing is played");
}

/// Fails for an invalid URI, and for devices that play by themselves.
void requireDevice(const std::string& device)
{
    if (device::playsByItself(device))
        fail(MIDAIR_REFUSED, "device \"" + device + "\": a recording can't play a scene");
}

void requirePlaying(const Scene& scene) MIDAIR_REQUIRES(scene.mutex)
{
    if (scene.device.empty() && scene.isHeir) fail(MIDAIR_CLOSED, base::kForked);
    if (scene.device.empty()) fail(MIDAIR_NOT_YET, "nothing is played: midair_play() begins");
}

/// Calls the scene's listener with new and ended messages.
class TellAtEnd
{
public:
    explicit TellAtEnd(Scene& scene) : _scene(scene) {}
    TellAtEnd(const TellAtEnd&) = delete;
    TellAtEnd& operator=(const TellAtEnd&) = delete;
    ~TellAtEnd()
    {
        std::vector<base::Message> told;
        MessageListener listener;
        {
            const base::Lock lock(_scene.mutex);
            if (!_scene.listener.call) return;
            told = _scene.player.log().changedSince(_scene.listener.seen);
            listener = _scene.listener;
        }
        for (const base::Message& message : told)
        {
            const midair_message given = toPublic(message);
            base::thrownBy([&] { listener.call(listener.user, &given, message.text.c_str()); });
        }
    }

private:
    Scene& _scene;
};

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
            before.reset(); // closes its device before the other one opens
            const base::Lock lock(of->mutex);
            if (of->isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
            if (!of->device.empty())
                fail(MIDAIR_INVALID, "another thread plays the scene at the same time");
            of->device = uri;
            of->isHeir = false;
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
            // Called without the mutex, also after an update that fails.
            const TellAtEnd tells(*of);
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
            const std::vector<base::Message> faults = of->faults();
            of->player.log().sayNow({base::MessageCode::SETTINGS_SILENCED}, faults);
            const std::string why = of->whySilenced(faults);
            if (!why.empty())
            {
                of->player.silence();
                fail(MIDAIR_SILENCED, why);
            }
            of->configure();
            of->fillSnapshot();
            of->player.play(Eigen::Isometry3d::Identity());
            if (const std::string cap = of->player.whySilenced(); !cap.empty())
                fail(MIDAIR_SILENCED, cap);
        });
}

midair_status midair_stop(midair_scene* scene)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            of->silenceNow();
            std::shared_ptr<void> ended; // destroyed without the mutex
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

namespace
{

/// Makes a handle of the newest field that was played; MIDAIR_SILENT: it is silence.
midair_status giveNewest(Scene& scene, midair_field** field)
{
    std::shared_ptr<const bridge::HologramResult> newest;
    std::vector<midair_object> objects;
    double earLimit_dB = 0.0;
    Eigen::Matrix3Xd ears(3, 0);
    {
        const base::Lock lock(scene.mutex);
        requirePlaying(scene);
        newest = scene.player.latestResult();
        const SceneSettings played = scene.player.playedSettings();
        earLimit_dB = played.earLimit;
        Eigen::Matrix3Xd points(3, 0);
        readPlaces(played.earPoints, points);
        ears.resize(3, scene.ears.cols() + points.cols());
        ears << scene.ears, points;
    }
    if (newest)
        for (const auto& origin : newest->origins)
            objects.push_back(origin ? *static_cast<const midair_object*>(origin.get()) : 0);
    const std::shared_ptr<Field> made = newest ? fieldOf(*newest, objects) : nullptr;
    if (!made || made->info.frame == 0) fail(MIDAIR_NOT_YET, "no field was played so far");
    made->ears = std::move(ears);
    made->earLimit_dB = earLimit_dB;
    *field = fields().add(made);
    return soundsOrWhy(*made);
}

} // namespace

midair_status midair_newest_field(midair_scene* scene, midair_field** field)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(field, "field");
            return giveNewest(*of, field);
        });
}

midair_status midair_wait_field(midair_scene* scene, double timeout_s, midair_field** field)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(field, "field");
            requireFinite(&timeout_s, 1, "timeout_s");
            if (timeout_s < 0.0)
                fail(MIDAIR_INVALID,
                     fmt::format("timeout_s is {:g}; it must be 0 or more", timeout_s));
            {
                const base::Lock lock(of->mutex);
                requirePlaying(*of);
                const std::string why = of->whySilenced();
                if (!why.empty()) fail(MIDAIR_SILENCED, why);
                if (const std::string cap = of->player.whySilenced(); !cap.empty())
                    fail(MIDAIR_SILENCED, cap);
                if (!of->isTimed) fail(MIDAIR_NOT_YET, "midair_update() was not called yet");
            }
            const std::string why = of->awaitField(timeout_s);
            if (!why.empty()) fail(MIDAIR_NOT_YET, why);
            return giveNewest(*of, field);
        });
}

midair_status midair_set_ears(midair_scene* scene, const double* positions, size_t count)
{
    return called(
        [&]
        {
            constexpr std::size_t kMost = 64;
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            if (count > kMost)
                refuse(*of, kEars, fmt::format("count is {}; it must be 0 .. {}", count, kMost));
            if (count > 0) given(positions, "positions");
            for (std::size_t i = 0; i < 3 * count; ++i)
                if (!std::isfinite(positions[i]))
                    refuse(*of,
                           kEars,
                           fmt::format("ear {} is at a position that is not finite", i / 3));
            of->ears.resize(3, static_cast<Eigen::Index>(count));
            std::copy_n(positions, 3 * count, of->ears.data());
            of->misunderstood.settle(kEars);
        });
}

midair_status midair_set_reflectors(midair_scene* scene, const char* json)
{
    return called(
        [&]
        {
            constexpr std::size_t kMost = 1 << 20;
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const std::size_t length = json == nullptr ? 0 : strnlen(json, kMost + 1);
            if (length > kMost)
                refuse(*of, kReflectors, fmt::format("json is longer than {} bytes", kMost));
            std::vector<haptics::FlatFace> faces;
            try
            {
                if (length > 0)
                    for (const haptics::Reflector& one :
                         haptics::reflectorsFromJson({json, length}, "json"))
                        faces.emplace_back().rectangle = one;
            }
            catch (const base::InputError& error)
            {
                refuse(*of, kReflectors, error.what());
            }
            of->reflectors = std::move(faces);
            of->misunderstood.settle(kReflectors);
        });
}

midair_status midair_ears(midair_scene* scene, midair_ear* ears, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const std::vector<haptics::PlaceExposure> all =
                of->device.empty() ? std::vector<haptics::PlaceExposure>() : of->player.ears();
            return copyAll(all,
                           ears,
                           capacity,
                           count,
                           [](const haptics::PlaceExposure& one) {
                               return midair_ear{{one.x_m, one.y_m, one.z_m},
                                                 one.level_dB,
                                                 one.eq_dB,
                                                 one.max_dB};
                           });
        });
}
