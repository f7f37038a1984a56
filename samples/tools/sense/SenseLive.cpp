#include "samples/tools/sense/SenseLive.h"

#include "haptics/base/threads/SteadyClock.h"
#include "haptics/sensation/SensationClassics.h"
#include "haptics/sensation/SensationPlayer.h"
#include "haptics/sensation/SensationReader.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/sense/DesignerServer.h"
#include "samples/tools/sense/SensePlace.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kFrame_s = 1.0 / 60.0;
constexpr double kFade_s = 0.1; // at the end, until the array is silent

void say(const std::string& what)
{
    std::fprintf(stderr, "midair-sense: %s\n", what.c_str());
}

/// Waits for the next frame of 60 a second.
class FramePace
{
public:
    /// Returns the time of the frame, s.
    double wait()
    {
        _next_s = std::max(_next_s + kFrame_s, base::steadySeconds());
        std::this_thread::sleep_for(
            std::chrono::duration<double>(std::max(0.0, _next_s - base::steadySeconds())));
        return base::steadySeconds();
    }

private:
    double _next_s = base::steadySeconds();
};

/// Waits until the device is open, and prints on what is played. Returns false if it isn't.
bool waitForDevice(SensePlayback& playback, const SensePlaybackOptions& on)
{
    FramePace pace;
    while (playback.isOpening() && !isStopAsked())
        playback.update(pace.wait());
    playback.update(pace.wait()); // which tells why it couldn't be opened
    if (!playback.isOpen()) return false;
    const Eigen::Vector3d at_m = playback.place().topRightCorner<3, 1>();
    std::printf("plays on %s by %s, up to %g Pa; the pattern's %s is at (%.3f, %.3f, %.3f) m\n",
                on.array.c_str(),
                on.device.c_str(),
                on.pressure_Pa,
                on.height_m > 0.0 ? "(0, 0, 200) mm" : "origin",
                at_m.x(),
                at_m.y(),
                at_m.z());
    std::fflush(stdout);
    return true;
}

/// Plays until the end, then fades.
void playFrames(SensePlayback& playback,
                haptics::SensationPlayer& player,
                const SensePlayOptions& options,
                std::size_t next)
{
    FramePace pace;
    const double start_s = base::steadySeconds();
    double now_s = start_s;
    playback.begin();
    for (bool goesOn = true; goesOn && !isStopAsked(); now_s = pace.wait())
    {
        const double time_ms = 1e3 * (now_s - start_s);
        const std::size_t before = next;
        setDue(options.set, time_ms, next, player.values());
        if (next != before) playback.setParameters(valuesOf(player.values()));
        playback.update(now_s);
        goesOn = !player.sampleAt(time_ms).isStopped &&
                 (options.seconds == 0.0 || time_ms < 1e3 * options.seconds);
    }
    playback.end();
    for (const double end_s = now_s + kFade_s; now_s < end_s; now_s = pace.wait())
        playback.update(now_s);
}

} // namespace

int playSensation(const SensePlayOptions& options, const SensePlaybackOptions& on)
{
    SensePlaybackOptions own = on;
    own.height_m = haptics::isClassicSensation(options.name) ? 0.0 : kPatternHeight_m;
    haptics::SensationPlayerOptions playing;
    playing.seed = on.seed;
    haptics::SensationPlayer player(
        std::make_shared<const haptics::Sensation>(haptics::loadSensation(options.name)), playing);
    std::size_t next = 0;
    setDue(options.set, 0.0, next, player.values());

    catchStopSignals();
    SensePlayback playback(own, say);
    const SilenceAtStop silence([&playback] { playback.mute(); });
    playback.setSensation(options.name);
    playback.setParameters(valuesOf(player.values()));
    if (!waitForDevice(playback, own)) return isStopAsked() ? EXIT_DONE : EXIT_DEVICE;
    playFrames(playback, player, options, next);
    std::printf("%s\n", playback.status().c_str());
    return playback.isWorking() ? EXIT_DONE : EXIT_DEVICE;
}

int serveDesigner(int port, const std::vector<std::string>& origins, const SensePlaybackOptions& on)
{
    SensePlaybackOptions own = on;
    own.height_m = kPatternHeight_m;
    DesignerServerOptions options;
    options.port = port;
    options.origins = origins;

    catchStopSignals();
    SensePlayback playback(own, say);
    const SilenceAtStop silence([&playback] { playback.mute(); });
    DesignerServer server(playback, options, say);
    if (!waitForDevice(playback, own)) return isStopAsked() ? EXIT_DONE : EXIT_DEVICE;
    std::printf("listens for the AdapTics Designer on ws://127.0.0.1:%d/; Ctrl-C ends\n",
                server.port());
    std::fflush(stdout);
    server.run(isStopAsked);
    std::printf("%s\n", playback.status().c_str());
    return EXIT_DONE;
}

} // namespace midair::samples
